"""Benchmarks of many walks at once: over their number, in one thread and in two, and their memory.

One thread and two are timed in turn, with bare arithmetic between them: two threads that share nothing, in the same
minutes.
"""

from __future__ import annotations

import gc
import time
import tracemalloc
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import PassiveController
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.hybrid import ADAPTIVE, arithmetic
from scripts.benchmarks.timing import Case, Rows, Timing

COUNTS = {"hybrid": (1, 4, 16, 64, 256), "mujoco": (1, 4, 16, 64)}
STEPS = {"hybrid": 25_600, "mujoco": 64}  # gait steps of all walks together, but at least `FEWEST` each
FEWEST = 4  # so that a walk takes longer than its scene
MILLION = ((1000, 1000), (10_000, 100))  # walks, steps of each
STEP_COUNTS = (1000, 10_000, 100_000, 1_000_000)
ROUNDS = 50_000_000  # of bare arithmetic


def grounds(count: int, steps: int) -> list[Terrain]:
    """Random ground for each walk, long enough for its steps."""
    return [Terrain.random(seed=seed, length=max(2.0, 0.4 * steps)) for seed in range(count)]


def walking(engine: str, count: int, steps: int, workers: int) -> Case:
    """Time walks without samples, but not the making of their ground."""
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


def over_walks(repeats: int) -> Rows:
    """Time more and more walks at once, in both engines."""
    return [row for engine in COUNTS for row in walks_in(engine, repeats)]


def walks_in(engine: str, repeats: int) -> Iterator[list[str]]:
    """Rows of one engine."""
    walking(engine, 2, 1, 2)()  # compilation, caches
    for count in tqdm(COUNTS[engine], desc=f"walks, {engine}", disable=None):
        steps = max(FEWEST, STEPS[engine] // count)
        one, two = (walking(engine, count, steps, workers) for workers in (1, 2))
        pairs = np.array([(one(), arithmetic(1, ROUNDS), two(), arithmetic(2, ROUNDS)) for _ in range(repeats)])
        walks_one, walks_two = (Timing(pairs[:, column], count * steps) for column in (0, 2))
        bare_one, bare_two = Timing(pairs[:, 1], 1), Timing(pairs[:, 3], 2)
        yield [
            f"{engine}, {count} of {steps:,}",
            walks_one.rate,
            walks_two.rate,
            walks_two.ratio(walks_one),
            bare_two.ratio(bare_one),
        ]


def millions(_repeats: int) -> Rows:
    """Time a million steps over random ground, once, in two threads."""
    rows = []
    for count, steps in MILLION:
        started = time.perf_counter()
        terrains = grounds(count, steps)
        built = time.perf_counter() - started
        for summaries in (False, True) if steps == MILLION[-1][1] else (False,):
            started, used = time.perf_counter(), time.process_time()
            walks = mjbiped.walk_many(
                ADAPTIVE, terrains, engine="hybrid", steps=steps, sample_period=None, summaries=summaries, workers=2
            )
            taken, used = time.perf_counter() - started, time.process_time() - used
            walked = sum(walk["steps"] if isinstance(walk, dict) else walk.steps for walk in walks)
            what = "summaries" if summaries else "records without samples"
            seconds = [f"{each:.1f}" for each in (built, taken, used)]
            rows.append([f"{count:,} of {steps:,}, {what}", *seconds, f"{walked / taken:,.0f}"])
    return rows


def passive(steps: int, asked: Mapping[str, Any]) -> Sequence[object]:
    """A walk that costs little time."""
    given: dict[str, Any] = {"engine": "hybrid", "steps": steps, "workers": 1, **asked}
    return mjbiped.walk_many(PassiveController(), Terrain.incline(2.0), **given)


def memory(_repeats: int) -> Rows:
    """Trace the memory of one passive walk over its steps: the maximum on the way, and what its result keeps."""
    rows = []
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
        rows.append([name, *cells])
    return rows
