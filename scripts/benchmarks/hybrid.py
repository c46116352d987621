"""Benchmarks of the hybrid engine: against SciPy, over lengths of walk and ground, and in two threads."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, Controller, PassiveController
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.numerics.machine import compiled
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.scipy_walk import ScipyWalk
from scripts.benchmarks.timing import Case, Rows, interleaved, side_by_side

ENGINE = mjbiped.Hybrid()
ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
ADAPTIVE = AdaptiveController(ROBOT, GAIT)
STARTS = tuple(
    GAIT.start * np.array(part) for part in ((1, 1, 1, 1), (1, 1, 1.01, 1), (1, 1, 1, 0.97), (1.01, 1.01, 1, 1))
)
"""First states with both feet on the ground: q2 = -q1."""
CHECKED = 20  # touchdowns whose states are compared
STEPS = 3000  # of a timed walk
STEP_COUNTS = (100, 1000, 10_000, 100_000)
SEGMENT_COUNTS = (10, 100, 1000, 10_000, 100_000)
TOLERANCES = 10.0 ** np.arange(-7.0, -12.6, -0.5)


class Walked(NamedTuple):
    """A walk of a robot on a ground.

    Attributes:
        controller: The controller.
        terrain: The ground.
        robot: The robot.
    """

    controller: Controller
    terrain: Terrain
    robot: mjbiped.Compass = ROBOT

    def touchdowns(self, start: NDArray[np.float64]) -> Mapping[str, NDArray[Any]]:
        """The first touchdowns in the hybrid engine."""
        first = start.tolist()
        return mjbiped.walk(
            self.controller, self.terrain, engine="hybrid", robot=self.robot, steps=CHECKED, initial=first
        ).touchdowns

    def states(self, start: NDArray[np.float64]) -> NDArray[np.float64]:
        """States (rad, rad/s) after the first touchdowns in the hybrid engine, shape (CHECKED, 4)."""
        touchdowns = self.touchdowns(start)
        return np.concatenate([touchdowns["q"], touchdowns["dq"]], axis=1)

    def exact(self, start: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same states by SciPy at a tolerance of 1e-13."""
        return ScipyWalk(*self, tolerance=1e-13).states(start, CHECKED)

    def case(
        self,
        steps: int,
        *,
        start: NDArray[np.float64] = GAIT.start,
        sample_period: float | None = None,
        clock: Callable[[], float] = time.thread_time,
        walks: int = 1,
    ) -> Case:
        """Time repeated walks in the hybrid engine, without building the simulation."""
        terms = Terms(ENGINE, steps, None, self.robot, sample_period, ScuffingRule())

        def run() -> float:
            taken = 0.0
            for _ in range(walks):
                walk = ENGINE.start(make_plan(terms, self.controller, self.terrain, start.tolist()))
                started = clock()
                walk.go()
                taken += clock() - started
                if walk.outcome is not Outcome.FINISHED:
                    raise RuntimeError(f"the walk {walk.outcome.words}")
            return taken

        return run


def walks_of(length: float) -> dict[str, Walked]:
    """The three walks that are timed; random ground has this length, m."""
    return {
        "passive, 2° down": Walked(PassiveController(), Terrain.incline(2.0)),
        "closed loop, level": Walked(ADAPTIVE, Terrain.level()),
        "closed loop, random slopes": Walked(ADAPTIVE, Terrain.random(seed=1, length=length, rise=(0.0, 0.0))),
    }


def against_scipy(repeats: int) -> Rows:
    """Compare with `solve_ivp` at the same measured accuracy."""
    rows = []
    for name, walked in walks_of(3000.0).items():
        exact = np.array([walked.exact(start) for start in STARTS])
        error = float(np.abs([walked.states(start) for start in STARTS] - exact).max())

        def error_of(tolerance: float, walked: Walked = walked, exact: NDArray[np.float64] = exact) -> float:
            found = [ScipyWalk(*walked, tolerance=tolerance).states(start, CHECKED) for start in STARTS]
            return float(np.abs(found - exact).max())

        errors = [error_of(each) for each in tqdm(TOLERANCES.tolist(), desc=f"accuracy, {name}", disable=None)]
        # the loosest tolerance from which on SciPy is as accurate: its error does not fall evenly
        rough = [index for index, value in enumerate(errors) if value > error]
        chosen = rough[-1] + 1 if rough else 0
        scipy_walk = ScipyWalk(*walked, tolerance=float(TOLERANCES[chosen]))

        def by_scipy(walk: ScipyWalk = scipy_walk) -> float:
            started = time.thread_time()
            walk.states(GAIT.start, 60)
            return time.thread_time() - started

        cases = {
            "hybrid": (walked.case(STEPS), STEPS),
            "sampled": (walked.case(STEPS, sample_period=0.005), STEPS),
            "scipy": (by_scipy, 60),
        }
        hybrid, sampled, scipy = interleaved(cases, repeats, name).values()
        accuracies = [f"{error:.1e}", f"{errors[chosen]:.1e} at {TOLERANCES[chosen]:.0e}"]
        rows.append([name, *accuracies, hybrid.rate, sampled.rate, scipy.rate, hybrid.ratio(scipy)])
    return rows


def over_steps(repeats: int) -> Rows:
    """Time walks of more and more steps."""
    cases: dict[str, tuple[Case, int]] = {}
    walks = walks_of(0.4 * max(STEP_COUNTS))
    for name, walked in walks.items():
        for count in STEP_COUNTS:
            repeated = max(1, 3000 // count)
            cases[f"{name}/{count}"] = (walked.case(count, walks=repeated), repeated * count)
    timings = interleaved(cases, repeats, "steps")
    return [[name, *(timings[f"{name}/{count}"].median(1e-6) for count in STEP_COUNTS)] for name in walks]


def over_segments(repeats: int) -> Rows:
    """Time the same 380 gait steps over the first ten segments of longer and longer grounds."""
    angles = np.random.default_rng(1).uniform(-3.0, 3.0, max(SEGMENT_COUNTS))
    segments = [(15.0 if index < 10 else 0.9, float(angle), 0.0) for index, angle in enumerate(angles)]
    cases = {
        str(count): (Walked(ADAPTIVE, Terrain.from_segments(segments[:count])).case(380, walks=5), 5 * 380)
        for count in SEGMENT_COUNTS
    }
    timings = interleaved(cases, repeats, "segments").values()
    return [["closed loop, random slopes", *(timing.median(1e-6) for timing in timings)]]


def over_threads(repeats: int) -> Rows:
    """Compare one walk with two side by side, by wall-clock time; last, arithmetic that shares nothing."""
    steps, rounds = 5 * STEPS, 200_000_000
    cases = {
        name: (walked.case(steps, clock=time.perf_counter), steps) for name, walked in walks_of(0.4 * steps).items()
    }
    cases["bare arithmetic (a million rounds)"] = (partial(arithmetic, 1, rounds), rounds // 1_000_000)
    rows = []
    for name, (one, work) in cases.items():
        both = partial(side_by_side, one, 2)
        timings = interleaved({"one": (one, work), "two": (both, 2 * work)}, repeats, f"threads, {name}")
        rows.append([name, timings["one"].rate, timings["two"].rate, timings["two"].ratio(timings["one"])])
    return rows


def turn(rounds: int, x: float, y: float) -> float:
    """Rotate a point again and again: arithmetic in registers alone."""
    for _round in range(rounds):
        x, y = 0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y
    return x


def arithmetic(threads: int, rounds: int) -> float:
    """Wall-clock time in which so many threads each do the same arithmetic, s."""
    alone = compiled(turn, "float64(int64, float64, float64)")
    alone(1, 1.0, 0.0)
    return side_by_side(partial(alone, rounds, 1.0, 0.0), threads)
