"""What the controller and the contact events cost in MuJoCo: a closed-loop step against a bare `mj_step`.

    python -m scripts.benchmarks.step_benchmark        (part of: make bench)

All cases make the same physics steps from the same states, taken along a walk, in turn: with compiled callbacks, with
Python's, and with none. CPU times of the thread.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import click
import mujoco
import numpy as np
from numpy.typing import NDArray

import mjbiped
from controllers import Controller, PassiveController
from mjbiped.engines.mujoco.options import DEFAULT_TIMESTEP, LONGEST_TIMESTEP
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.benchmark import ADAPTIVE, GAIT, ROBOT
from scripts.benchmarks.timing import PAGE, Case, interleaved
from scripts.pages import write_table

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
STATES = 60  # from which all cases start
APART = 397  # steps between two of them: some three in two swings, at all phases
LENGTH = 200  # steps made from each
WALKED = 60  # gait steps of a whole walk


def grounds() -> dict[str, tuple[Controller, Terrain]]:
    """The walks that are timed."""
    return {
        "passive, 2° down": (PassiveController(), Terrain.incline(2.0)),
        "closed loop, level": (ADAPTIVE, Terrain.level()),
        "closed loop, mixed": (ADAPTIVE, Terrain.mixed()),
        "closed loop, stairs −0.06 m": (ADAPTIVE, Terrain.stairs(rise=-0.06)),
        "closed loop, random": (ADAPTIVE, Terrain.random(seed=0)),
    }


def simulation(controller: Controller, terrain: Terrain, *, compile: bool) -> Simulation:
    """A walk from the gait's start."""
    start = GAIT.start.tolist()
    return mjbiped.Mujoco().simulation(
        controller, terrain, steps=200, initial=start, robot=ROBOT, sample_period=100.0, compile=compile
    )


def states_of(walker: Simulation) -> list[NDArray[np.float64]]:
    """States along its walk, for `mj_setState`."""
    states = []
    with walker.callbacks():
        for _ in range(STATES):
            mujoco.mj_step(walker.model, walker.data, nstep=APART)
            states.append(np.empty(mujoco.mj_stateSize(walker.model, STATE)))
            mujoco.mj_getState(walker.model, walker.data, states[-1], STATE)
    return states


@contextmanager
def no_callbacks() -> Iterator[None]:
    """For the bare step."""
    yield


def stepping(walker: Simulation, states: list[NDArray[np.float64]], *, bare: bool) -> Case:
    """Physics steps from each of the states."""

    def run() -> float:
        taken = 0.0
        with no_callbacks() if bare else walker.callbacks():
            for state in states:
                mujoco.mj_setState(walker.model, walker.data, state, STATE)
                walker.model.opt.timestep = DEFAULT_TIMESTEP  # the callbacks change it, for themselves
                started = time.thread_time()
                mujoco.mj_step(walker.model, walker.data, nstep=LENGTH)
                taken += time.thread_time() - started
        return taken

    return run


def real_time(controller: Controller, terrain: Terrain, timestep: float, repeats: int) -> str:
    """Simulated time over CPU time of `mjbiped.walk`, all that belongs to it included: median of repeated walks."""
    factors = []
    for _ in range(repeats):
        started = time.thread_time()
        walk = mjbiped.walk(
            controller, terrain, steps=WALKED, initial=GAIT.start.tolist(), engine=mjbiped.Mujoco(timestep=timestep)
        )
        factors.append(walk.end[0] / (time.thread_time() - started))
    return f"{np.median(factors):.0f}"


@click.command()
@click.option("--repeats", default=11, show_default=True, type=click.IntRange(3), help="Repetitions of each case.")
def main(repeats: int) -> None:
    """Measure, and write the table of docs/tables/performance.md."""
    rows = []
    for name, (controller, terrain) in grounds().items():
        walker, in_python = (simulation(controller, terrain, compile=compile) for compile in (True, False))
        states = states_of(walker)
        work = STATES * LENGTH
        timings = interleaved(
            {
                "compiled": (stepping(walker, states, bare=False), work),
                "bare": (stepping(walker, states, bare=True), work),
                "python": (stepping(in_python, states, bare=False), work),
            },
            repeats,
            name,
        )
        bare, compiled, python = (timings[case] for case in ("bare", "compiled", "python"))
        rows.append(
            [
                name,
                bare.each(1e-6),
                compiled.each(1e-6),
                bare.ratio(compiled),
                python.each(1e-6),
                bare.ratio(python),
                *(
                    real_time(controller, terrain, timestep, repeats)
                    for timestep in (DEFAULT_TIMESTEP, LONGEST_TIMESTEP)
                ),
            ]
        )
    headings = (
        "walk",
        "bare `mj_step`, µs",
        "compiled callbacks, µs",
        "compiled : bare",
        "Python callbacks, µs",
        "Python : bare",
        "`walk()`, × real time",
        "at 4 ms",
    )
    write_table(PAGE, "callbacks", headings, rows)


if __name__ == "__main__":
    main()
