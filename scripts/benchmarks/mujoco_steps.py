"""Benchmarks of MuJoCo steps: those of the engine against a bare `mj_step`, and what the length of the terrain costs.

The cases of a comparison make the same physics steps from the same states, which are taken along a walk.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from unittest.mock import patch

import mujoco
import numpy as np
from numpy.typing import NDArray

import mjbiped
from controllers import Controller, PassiveController
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.options import DEFAULT_TIMESTEP, LONGEST_TIMESTEP
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.hybrid import ADAPTIVE, GAIT, ROBOT
from scripts.benchmarks.timing import Case, Rows, interleaved

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
STATES = 60  # from which all cases start
APART = 397  # steps between two of them: some three in two swings, at all phases
LENGTH = 200  # steps made from each
WALKED = 60  # gait steps of a whole walk
SEGMENTS = (10, 100, 1000, 10_000)
SPARED = 6  # of so many states one is used on long terrain, all of which takes half a millisecond a step


def grounds() -> dict[str, tuple[Controller, Terrain]]:
    """The walks whose steps are timed."""
    return {
        "passive, 2° down": (PassiveController(), Terrain.incline(2.0)),
        "closed loop, level": (ADAPTIVE, Terrain.level()),
        "closed loop, mixed": (ADAPTIVE, Terrain.mixed()),
        "closed loop, stairs −0.06 m": (ADAPTIVE, Terrain.stairs(rise=-0.06)),
        "closed loop, random": (ADAPTIVE, Terrain.random(seed=0)),
    }


def simulation(controller: Controller, terrain: Terrain, *, compile: bool) -> Simulation:
    """A simulation that starts on the gait."""
    engine = mjbiped.Mujoco()
    terms = Terms(engine, 200, None, ROBOT, 100.0, mjbiped.ScuffingRule())
    return Simulation(make_plan(terms, controller, terrain, GAIT.start.tolist()), engine, compile=compile)


def states_of(walker: Simulation) -> list[NDArray[np.float64]]:
    """States along a simulation's walk, for `mj_setState`."""
    states = []
    for _ in range(STATES):
        walker.advance(APART)
        states.append(np.empty(mujoco.mj_stateSize(walker.model, STATE)))
        mujoco.mj_getState(walker.model, walker.data, states[-1], STATE)
    return states


def stepping(walker: Simulation, states: list[NDArray[np.float64]], *, bare: bool) -> Case:
    """Time physics steps from each of the states."""

    def run() -> float:
        taken = 0.0
        for state in states:
            mujoco.mj_setState(walker.model, walker.data, state, STATE)
            walker.model.opt.timestep = DEFAULT_TIMESTEP  # the engine's steps change it, for themselves
            started = time.thread_time()
            if bare:
                mujoco.mj_step(walker.model, walker.data, nstep=LENGTH)
            else:
                walker.advance(LENGTH)
            taken += time.thread_time() - started
        return taken

    return run


def walked(controller: Controller, terrain: Terrain, engine: mjbiped.Mujoco) -> tuple[float, float]:
    """Simulated time and CPU time of `mjbiped.walk`, s, from the call to the record."""
    started = time.thread_time()
    walk = mjbiped.walk(controller, terrain, steps=WALKED, initial=GAIT.start.tolist(), engine=engine)
    taken = time.thread_time() - started
    if walk.steps < WALKED:
        raise RuntimeError(f"the walk {walk.outcome} after {walk.steps} steps")
    return float(walk.end[0]), taken


def over_callbacks(repeats: int) -> Rows:
    """Time steps of the engine, as machine code and in Python, and bare ones; and whole walks."""
    rows = []
    for name, (controller, terrain) in grounds().items():
        walker, in_python = (simulation(controller, terrain, compile=compile) for compile in (True, False))
        states = states_of(walker)
        work = STATES * LENGTH
        cases = {
            "compiled": (stepping(walker, states, bare=False), work),
            "bare": (stepping(walker, states, bare=True), work),
            "python": (stepping(in_python, states, bare=False), work),
        }
        compiled, bare, python = interleaved(cases, repeats, name).values()
        row = [name, bare.each(1e-6)]
        for timing in (compiled, python):
            row += [timing.each(1e-6), bare.ratio(timing)]
        for timestep in (DEFAULT_TIMESTEP, LONGEST_TIMESTEP):
            times = [walked(controller, terrain, mjbiped.Mujoco(timestep=timestep)) for _ in range(repeats)]
            row.append(f"{np.median([simulated / taken for simulated, taken in times]):.0f}")
        rows.append(row)
    return rows


def sampled(count: int) -> Terrain:
    """A trail sampled every 1.5 m, with normally distributed heights (15 mm)."""
    x = np.arange(count + 1) * 1.5
    z = np.random.default_rng(0).normal(0.0, 0.015, count + 1) * (x > 0.0)
    return Terrain(tuple(x[:-1]), tuple(z[:-1]), tuple(-np.arctan(np.diff(z) / 1.5)))


def drawn(count: int, step_probability: float) -> Terrain:
    """Random ground of a number of segments, 1.4 m long on average."""
    rows = Terrain.random(seed=0, length=1.45 * count + 20.0, step_probability=step_probability)
    names = ("x", "z", "angle")
    return Terrain(*(getattr(rows, name)[:count] for name in names))


GROUNDS: dict[str, Callable[[int], Terrain]] = {
    "stairs (boxes and risers)": lambda count: Terrain.stairs(rise=-0.006, count=count - 1),
    "equal slopes (heightfields of many)": sampled,
    "unequal slopes (heightfields of one)": lambda count: drawn(count, 0.0),
    "slopes and steps (all of them)": lambda count: drawn(count, 0.5),
}


def build(terrain: Terrain, *, whole: bool) -> tuple[Simulation, float]:
    """A simulation, and the time to make it, s."""
    with patch.object(Ground, "window", (lambda ground, *_: ground.pieces) if whole else Ground.window):
        started = time.thread_time()
        made = simulation(ADAPTIVE, terrain, compile=True)
        return made, time.thread_time() - started


def rows_of(name: str, repeats: int) -> Rows:
    """Rows of one kind of ground."""
    cases: dict[str, tuple[Case, int]] = {}
    made: dict[str, list[str]] = {"True": [], "False": []}
    walks = []
    for count in SEGMENTS:
        terrain = GROUNDS[name](count)
        states = states_of(build(terrain, whole=False)[0])[::SPARED]
        for whole in (False, True):
            walker, seconds = build(terrain, whole=whole)
            made[str(whole)].append(f"{1e3 * seconds:.0f}")
            cases[f"{whole} {count}"] = (stepping(walker, states, bare=False), len(states) * LENGTH)
        walks.append(f"{walked(ADAPTIVE, terrain, mjbiped.Mujoco())[1]:.2f}")
    step = interleaved(cases, repeats, name)
    return [
        [f"{name}: step, all of it, µs", *(step[f"True {count}"].each(1e-6) for count in SEGMENTS)],
        ["step, window, µs", *(step[f"False {count}"].each(1e-6) for count in SEGMENTS)],
        ["and against 10 segments", *(step["False 10"].ratio(step[f"False {count}"]) for count in SEGMENTS)],
        ["`Simulation`, all of it, ms", *made["True"]],
        ["`Simulation`, window, ms", *made["False"]],
        [f"`walk()`, {WALKED} steps, window, s", *walks],
    ]


def over_terrain(repeats: int) -> Rows:
    """Time a step and the start on longer and longer terrain, on windows of the ground and on all of it."""
    return [row for name in GROUNDS for row in rows_of(name, repeats)]
