"""What many walks cost side by side: over their number, on one thread and on two, and how much memory.

    python -m scripts.benchmarks.many_benchmark        (part of: make bench)

Times are by the clock on the wall. One thread and two are timed in turn, with bare arithmetic between them, which
tells what two threads that share nothing get from this machine in the same minutes.
"""

from __future__ import annotations

import gc
import time
import tracemalloc
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import PassiveController
from mjbiped.numerics.jit import compiled
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.benchmark import ADAPTIVE, NoFunctions, turn
from scripts.benchmarks.timing import PAGE, Case, Timing, side_by_side
from scripts.pages import write_table

COUNTS = {"hybrid": (1, 4, 16, 64, 256), "mujoco": (1, 4, 16, 64)}
STEPS = {"hybrid": 25_600, "mujoco": 64}  # gait steps of all walks together, but at least `FEWEST` each
FEWEST = 4  # so that a walk takes longer than its scene
MILLION = ((1000, 1000), (10_000, 100))  # walks, steps of each
STEP_COUNTS = (1000, 10_000, 100_000, 1_000_000)
ROUNDS = 50_000_000  # of bare arithmetic


def grounds(count: int, steps: int) -> list[Terrain]:
    """Random ground, another for each walk, long enough for its steps."""
    return [Terrain.random(seed=seed, length=max(2.0, 0.4 * steps)) for seed in range(count)]


def walking(engine: str, count: int, steps: int, workers: int) -> Case:
    """Walks without samples; building the ground is not part of it."""
    terrains = grounds(count, steps)

    def run() -> float:
        started = time.perf_counter()
        walks = mjbiped.walk_many(ADAPTIVE, terrains, engine=engine, steps=steps, sample_period=None, workers=workers)
        taken = time.perf_counter() - started
        walked = sum(walk.steps for walk in walks)
        if walked != count * steps:
            raise RuntimeError(f"{walked} gait steps were walked, not {count * steps}")
        return taken

    return run


def arithmetic(threads: int) -> float:
    """Seconds in which so many threads do the same arithmetic, each for itself."""
    alone = compiled(turn, NoFunctions, (), inlined=())
    alone(1, 1.0, 0.0)
    return side_by_side(partial(alone, ROUNDS, 1.0, 0.0), threads)


def over_walks(engine: str, repeats: int) -> Iterator[list[str]]:
    """Rows over the number of walks."""
    walking(engine, 2, 1, 2)()  # compilation, caches
    for count in tqdm(COUNTS[engine], desc=f"walks, {engine}", disable=None):
        steps = max(FEWEST, STEPS[engine] // count)
        one, two = (walking(engine, count, steps, workers) for workers in (1, 2))
        pairs = np.array([(one(), arithmetic(1), two(), arithmetic(2)) for _ in range(repeats)])
        walks_one, walks_two = (Timing(pairs[:, column], count * steps) for column in (0, 2))
        bare_one, bare_two = Timing(pairs[:, 1], 1), Timing(pairs[:, 3], 2)
        yield [
            f"{engine}, {count} of {steps:,}",
            walks_one.rate,
            walks_two.rate,
            walks_two.ratio(walks_one),
            bare_two.ratio(bare_one),
        ]


def millions(workers: int) -> Iterator[list[str]]:
    """Rows for a million steps over random ground."""
    for count, steps in MILLION:
        started = time.perf_counter()
        terrains = grounds(count, steps)
        built = time.perf_counter() - started
        for summaries in (False, True) if steps == MILLION[-1][1] else (False,):
            started, used = time.perf_counter(), time.process_time()
            walks = mjbiped.walk_many(
                ADAPTIVE,
                terrains,
                engine="hybrid",
                steps=steps,
                sample_period=None,
                summaries=summaries,
                workers=workers,
            )
            taken, used = time.perf_counter() - started, time.process_time() - used
            walked = sum(walk["steps"] if isinstance(walk, dict) else walk.steps for walk in walks)
            what = "summaries" if summaries else "records without samples"
            yield [
                f"{count:,} of {steps:,}, {what}",
                f"{walked:,}",
                f"{built:.1f}",
                f"{taken:.1f}",
                f"{used:.1f}",
                f"{walked / taken:,.0f}",
            ]


def passive(steps: int, asked: Mapping[str, Any]) -> Sequence[object]:
    """One walk that costs little time."""
    given: dict[str, Any] = {"engine": "hybrid", "steps": steps, "workers": 1, **asked}
    return mjbiped.walk_many(PassiveController(), Terrain.incline(2.0), **given)


def memory() -> Iterator[list[str]]:
    """Rows of the memory of one passive walk over its steps: the most it took on the way, and what is left."""
    kinds: dict[str, dict[str, Any]] = {
        "record": {},
        "record without samples": {"sample_period": None},
        "summary": {"summaries": True},
    }
    for name, asked in kinds.items():
        cells = []
        for steps in STEP_COUNTS:
            if name == "record" and steps > 10_000:
                cells.append("")
                continue
            passive(2, asked)  # what is loaded once
            gc.collect()
            tracemalloc.start()
            before = tracemalloc.get_traced_memory()[0]
            walks = passive(steps, asked)
            gc.collect()
            now, most = tracemalloc.get_traced_memory()
            tracemalloc.stop()
            del walks
            cells.append(f"{(most - before) / 1e6:.3g}, {(now - before) / 1e6:.3g}")
        yield [name, *cells]


@click.command()
@click.option("--repeats", default=3, show_default=True, type=click.IntRange(1), help="Repetitions of each case.")
def main(repeats: int) -> None:
    """Measure, and write the tables of docs/tables/performance.md."""
    write_table(
        PAGE,
        "many",
        ("walks of gait steps", "steps/s, 1 thread", "2 threads", "ratio", "bare arithmetic"),
        [*over_walks("hybrid", repeats), *over_walks("mujoco", repeats)],
    )
    write_table(
        PAGE,
        "million",
        ("walks of gait steps", "steps walked", "ground, s", "walks, s", "CPU, s", "steps/s"),
        list(millions(2)),
    )
    write_table(
        PAGE,
        "memory",
        ("MB of one walk at so many steps: most, kept", *(f"{count:,}" for count in STEP_COUNTS)),
        list(memory()),
    )
    click.echo(PAGE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
