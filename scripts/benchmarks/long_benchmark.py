"""What the length of the terrain costs in MuJoCo: a step and the start, on windows of the ground and on all of it.

    python -m scripts.benchmarks.long_benchmark        (part of: make bench)

All cases of a ground make the same closed-loop steps from the same states, in turn. CPU times of the thread.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from unittest.mock import patch

import click
import numpy as np

import mjbiped
from mjbiped.engines.mujoco import ground_window
from mjbiped.engines.mujoco.ground import FEW_SEGMENTS
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.benchmark import ADAPTIVE, GAIT
from scripts.benchmarks.step_benchmark import LENGTH, simulation, states_of, stepping
from scripts.benchmarks.timing import PAGE, Case, interleaved
from scripts.pages import write_table

SEGMENTS = (10, 100, 1000, 10_000)
WALKED = 60  # gait steps of a whole walk: into the second window
SPARED = 6  # of so many states one is used: a step on all of a long terrain takes half a millisecond


def sampled(count: int) -> Terrain:
    """A trail with samples at equal distances of 1.5 m, 15 mm to and fro."""
    x = np.arange(count + 1) * 1.5
    z = np.random.default_rng(0).normal(0.0, 0.015, count + 1) * (x > 0.0)
    return Terrain(tuple(x[:-1]), tuple(z[:-1]), tuple(-np.arctan(np.diff(z) / 1.5)))


def drawn(count: int, step_probability: float) -> Terrain:
    """Random ground of so many segments, 1.4 m long on average."""
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
    """A simulation, and the seconds that its making took."""
    few = max(FEW_SEGMENTS, len(terrain.x) if whole else 0)
    with patch.object(ground_window, "FEW_SEGMENTS", few):
        started = time.thread_time()
        made = simulation(ADAPTIVE, terrain, compile=True)
        return made, time.thread_time() - started


def walked(terrain: Terrain) -> float:
    """Seconds of `mjbiped.walk`, all that belongs to it included."""
    started = time.thread_time()
    walk = mjbiped.walk(ADAPTIVE, terrain, steps=WALKED, initial=GAIT.start.tolist())
    taken = time.thread_time() - started
    if walk.steps < WALKED:
        raise RuntimeError(f"the walk {walk.outcome} after {walk.steps} steps")
    return taken


def rows_of(name: str, repeats: int) -> list[list[str]]:
    """The table's rows of one ground."""
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
        walks.append(f"{walked(terrain):.2f}")
    step = interleaved(cases, repeats, name)
    return [
        [f"**{name}**: step, all of it, µs", *(step[f"True {count}"].each(1e-6) for count in SEGMENTS)],
        ["step, window, µs", *(step[f"False {count}"].each(1e-6) for count in SEGMENTS)],
        ["and against 10 segments", *(step["False 10"].ratio(step[f"False {count}"]) for count in SEGMENTS)],
        ["`Simulation`, all of it, ms", *made["True"]],
        ["`Simulation`, window, ms", *made["False"]],
        [f"`walk()`, {WALKED} steps, window, s", *walks],
    ]


@click.command()
@click.option("--repeats", default=5, show_default=True, type=click.IntRange(3), help="Repetitions of each case.")
def main(repeats: int) -> None:
    """Measure, and write the table of docs/tables/performance.md."""
    rows = [row for name in GROUNDS for row in rows_of(name, repeats)]
    write_table(PAGE, "long", ["at so many segments", *(f"{count:,}" for count in SEGMENTS)], rows)


if __name__ == "__main__":
    main()
