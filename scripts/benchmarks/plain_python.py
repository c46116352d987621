"""Benchmark of controllers that cannot be compiled: whole walks in both engines, in pairs.

A controller without `law()` runs as ordinary Python; with it so does all of the hybrid engine. MuJoCo's callbacks are
compiled all the same, and call its methods.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial

import mjbiped
from controllers import AdaptiveController, Controller, KneedController, Memory, PassiveController
from mjbiped.gaits.gait import Gait
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.hybrid import GAIT, ROBOT
from scripts.benchmarks.timing import Rows, interleaved

STEPS = {("hybrid", True): 3000, ("hybrid", False): 20, ("mujoco", True): 20, ("mujoco", False): 4}
"""Gait steps of a timed walk, by engine and whether it is compiled: some tenths of a second each."""
DIGITS = {"hybrid": 3, "mujoco": 1}


class PlainPassive(PassiveController):
    """The passive walk as a user writes it who knows nothing of compilation."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Nothing, in plain Python: a class with a `torque` of its own has no law to be compiled."""
        return super().torque(memory, t, q, dq)


class PlainAdaptive(AdaptiveController):
    """The paper's controller as a user writes it who knows nothing of compilation."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """The same torques, in plain Python."""
        return super().torque(memory, t, q, dq)


class PlainKneed(KneedController):
    """The adaptive controller of three joints, as a user writes it who knows nothing of compilation."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """The same torques, in plain Python."""
        return super().torque(memory, t, q, dq)


KNEED = mjbiped.KneedBiped()
REFERENCE = mjbiped.find_reference(KNEED, clearance=0.08)

PAIRS: dict[str, tuple[Controller, Controller, Terrain, Gait]] = {
    "passive, 2° down": (PassiveController(), PlainPassive(), Terrain.incline(2.0), GAIT),
    "closed loop, level": (AdaptiveController(ROBOT, GAIT), PlainAdaptive(ROBOT, GAIT), Terrain.level(), GAIT),
    "with knees, level": (KneedController(KNEED, REFERENCE), PlainKneed(KNEED, REFERENCE), Terrain.level(), REFERENCE),
}


def walking(controller: Controller, terrain: Terrain, gait: Gait, engine: str, steps: int) -> float:
    """CPU time of a walk without samples, s."""
    started = time.thread_time()
    walk = mjbiped.walk(
        controller, terrain, engine=engine, steps=steps, initial=gait.start.tolist(), sample_period=None
    )
    taken = time.thread_time() - started
    if walk.outcome != "finished":
        raise RuntimeError(f"the walk {walk.outcome}")
    return taken


def against_compiled(repeats: int) -> Rows:
    """Compare each controller as plain Python with the compiled one."""
    rows = []
    for name, (compiled, plain, terrain, gait) in PAIRS.items():
        for engine in ("hybrid", "mujoco"):
            cases = {}
            for controller, fast in ((compiled, True), (plain, False)):
                steps = STEPS[engine, fast]
                cases[str(fast)] = (partial(walking, controller, terrain, gait, engine, steps), steps)
            timings = interleaved(cases, repeats, f"{name}, {engine}")
            fast_one, slow_one = timings["True"], timings["False"]
            each = [timing.each(1e-3, DIGITS[engine]) for timing in (fast_one, slow_one)]
            rows.append([name, engine, *each, fast_one.ratio(slow_one)])
    return rows
