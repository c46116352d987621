"""How fast the engine is: paired timings, ratios from one run, written with the machine into docs/tables.

    python -m scripts.benchmarks.benchmark        (or: make bench)

The cases of a comparison are run in turn, again and again, so that a machine that slows down slows all of them; times
are CPU times of the one thread, but for the comparison of threads.
"""

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, Controller, PassiveController
from mjbiped.engines.plan import Plan, Terms
from mjbiped.numerics.jit import compiled
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.scipy_walk import ScipyWalk
from scripts.benchmarks.timing import PAGE, Case, Timing, interleaved, side_by_side
from scripts.pages import write_table

ENGINE = mjbiped.Hybrid()
ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
ADAPTIVE = AdaptiveController(ROBOT, GAIT)
STARTS = tuple(
    GAIT.start * np.array(part) for part in ((1, 1, 1, 1), (1, 1, 1.01, 1), (1, 1, 1, 0.97), (1.01, 1.01, 1, 1))
)
"""All on ground that both feet stand on: q2 = -q1."""
STEP_COUNTS = (100, 1000, 10_000, 100_000)
SEGMENT_COUNTS = (10, 100, 1000, 10_000, 100_000)
TOLERANCES = 10.0 ** np.arange(-7.0, -12.6, -0.5)


def hybrid_case(
    controller: Controller,
    terrain: Terrain,
    steps: int,
    *,
    sample_period: float | None = None,
    clock: Callable[[], float] = time.thread_time,
    walks: int = 1,
) -> Case:
    """Walks of the engine, without what builds them."""

    def run() -> float:
        taken = 0.0
        for _ in range(walks):
            start = tuple(GAIT.start.tolist())
            terms = Terms(ENGINE, steps, None, ROBOT, sample_period, ScuffingRule())
            walk = ENGINE.start(Plan(terms, controller, terrain, ROBOT, start[:2], start[2:], {}))
            started = clock()
            walk.go()
            taken += clock() - started
            if walk.outcome is not Outcome.FINISHED:
                raise RuntimeError(f"the walk {walk.outcome.words}")
        return taken

    return run


def grounds(length: float) -> dict[str, tuple[Controller, Terrain]]:
    """The three walks that are timed everywhere."""
    return {
        "passive, 2° down": (PassiveController(), Terrain.incline(2.0)),
        "closed loop, level": (ADAPTIVE, Terrain.level()),
        "closed loop, random slopes": (ADAPTIVE, Terrain.random(seed=1, length=length, rise=(0.0, 0.0))),
    }


def against_scipy(repeats: int, steps: int) -> list[list[str]]:
    """Rows of the comparison with `solve_ivp` at the same measured accuracy."""
    rows = []
    for name, (controller, terrain) in grounds(3000.0).items():
        exact = np.array([ScipyWalk(controller, terrain, ROBOT, tolerance=1e-13).states(s, 20) for s in STARTS])
        found = []
        for start in STARTS:
            touchdowns = mjbiped.walk(controller, terrain, engine="hybrid", steps=20, initial=start).touchdowns
            found.append(np.concatenate([touchdowns["q"], touchdowns["dq"]], axis=1))
        error = float(np.abs(np.array(found) - exact).max())
        errors = [
            float(
                np.abs([ScipyWalk(controller, terrain, ROBOT, tolerance=t).states(s, 20) for s in STARTS] - exact).max()
            )
            for t in tqdm(TOLERANCES.tolist(), desc=f"accuracy, {name}", disable=None)
        ]
        # the loosest tolerance from which on it is as accurate: its error does not fall evenly
        rough = [index for index, value in enumerate(errors) if value > error]
        chosen = rough[-1] + 1 if rough else 0
        scipy_walk = ScipyWalk(controller, terrain, ROBOT, tolerance=float(TOLERANCES[chosen]))

        def by_scipy(walk: ScipyWalk = scipy_walk) -> float:
            started = time.thread_time()
            walk.states(GAIT.start, 60)
            return time.thread_time() - started

        timings = interleaved(
            {
                "hybrid": (hybrid_case(controller, terrain, steps), steps),
                "sampled": (hybrid_case(controller, terrain, steps, sample_period=0.005), steps),
                "scipy": (by_scipy, 60),
            },
            repeats,
            name,
        )
        hybrid, scipy = timings["hybrid"], timings["scipy"]
        rows.append(
            [
                name,
                f"{error:.1e}",
                f"{errors[chosen]:.1e} at {TOLERANCES[chosen]:.0e}",
                hybrid.rate,
                timings["sampled"].rate,
                scipy.rate,
                hybrid.ratio(scipy),
            ]
        )
    return rows


def over_steps(repeats: int) -> dict[str, list[Timing]]:
    """Timings of walks of more and more steps."""
    walks = grounds(0.4 * max(STEP_COUNTS))
    cases = {
        (name, count): (
            hybrid_case(controller, terrain, count, walks=max(1, 3000 // count)),
            max(count, 3000 // count * count),
        )
        for name, (controller, terrain) in walks.items()
        for count in STEP_COUNTS
    }
    timings = interleaved({f"{name}/{count}": case for (name, count), case in cases.items()}, repeats, "steps")
    return {name: [timings[f"{name}/{count}"] for count in STEP_COUNTS] for name in walks}


def over_segments(repeats: int, walks: int) -> list[Timing]:
    """Timings of the same 380 gait steps over the first ten segments of longer and longer grounds."""
    angles = np.random.default_rng(1).uniform(-3.0, 3.0, max(SEGMENT_COUNTS))
    segments = [(15.0 if index < 10 else 0.9, float(angle), 0.0) for index, angle in enumerate(angles)]
    cases = {
        str(count): (hybrid_case(ADAPTIVE, Terrain.from_segments(segments[:count]), 380, walks=walks), 380 * walks)
        for count in SEGMENT_COUNTS
    }
    return list(interleaved(cases, repeats, "segments").values())


def over_threads(repeats: int, steps: int) -> list[list[str]]:
    """Rows of one walk, and of two side by side, by the clock on the wall; last, arithmetic that shares nothing."""
    cases = {
        name: (hybrid_case(controller, terrain, steps, clock=time.perf_counter), steps)
        for name, (controller, terrain) in grounds(0.4 * steps).items()
    }
    rounds = 200_000_000
    alone = compiled(turn, NoFunctions, (), inlined=())

    def arithmetic() -> float:
        started = time.perf_counter()
        alone(rounds, 1.0, 0.0)
        return time.perf_counter() - started

    rows = []
    for name, (one, work) in {**cases, "bare arithmetic (a million rounds)": (arithmetic, rounds // 1_000_000)}.items():
        both = partial(side_by_side, one, 2)
        timings = interleaved({"one": (one, work), "two": (both, 2 * work)}, repeats, f"threads, {name}")
        rows.append([name, timings["one"].rate, timings["two"].rate, timings["two"].ratio(timings["one"])])
    return rows


class NoFunctions(NamedTuple):
    """For a function that calls no others."""


def turn(_: NoFunctions, rounds: int, x: float, y: float) -> float:
    """Rotations of a point: arithmetic in registers alone."""
    for _round in range(rounds):
        x, y = 0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y
    return x


def machine() -> list[list[str]]:
    """What it was measured on."""
    model = next(
        (line.partition(":")[2].strip() for line in _lines("/proc/cpuinfo") if line.startswith("model name")),
        platform.processor() or platform.machine(),
    )
    load = ", ".join(f"{value:.1f}" for value in os.getloadavg())
    versions = ", ".join(f"{name} {version(name)}" for name in ("mujoco", "numba", "numpy", "scipy"))
    return [
        ["processor", f"{model}, {os.cpu_count()} cores"],
        ["system", f"{platform.system()}, Python {platform.python_version()}, {versions}"],
        ["load in the last 1, 5, 15 minutes", load],
        ["date", time.strftime("%Y-%m-%d")],
    ]


def _lines(path: str) -> list[str]:
    return Path(path).read_text(encoding="utf-8").splitlines() if Path(path).exists() else []


@click.command()
@click.option("--repeats", default=11, show_default=True, type=click.IntRange(3), help="Repetitions of each case.")
@click.option("--steps", default=3000, show_default=True, type=click.IntRange(60), help="Gait steps of a timed walk.")
def main(repeats: int, steps: int) -> None:
    """Measure, and write the tables of docs/tables/performance.md."""
    write_table(PAGE, "machine", ("", ""), machine())
    write_table(
        PAGE,
        "scipy",
        (
            "walk",
            "error, hybrid",
            "error, SciPy",
            "steps/s, hybrid",
            "with samples",
            "steps/s, SciPy",
            "hybrid : SciPy",
        ),
        against_scipy(repeats, steps),
    )
    write_table(
        PAGE, "threads", ("walk", "steps/s, 1 thread", "2 threads", "ratio"), over_threads(2 * repeats, 5 * steps)
    )
    by_steps, by_segments = over_steps(repeats), over_segments(repeats, 5)
    for name, headings, rows in (
        ("steps", STEP_COUNTS, [(name, timings) for name, timings in by_steps.items()]),
        ("segments", SEGMENT_COUNTS, [("closed loop, random slopes", by_segments)]),
    ):
        cells = [[row, *(f"{1e6 * np.median(t.seconds) / t.work:.1f}" for t in timings)] for row, timings in rows]
        write_table(PAGE, name, (f"µs per gait step at so many {name}", *(f"{count:,}" for count in headings)), cells)
    click.echo(PAGE.read_text(encoding="utf-8"))
    click.echo(f"wrote {PAGE}")


if __name__ == "__main__":
    main()
