"""Estimate of what a study will take, from some of its walks."""

from __future__ import annotations

import time
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from mjbiped.sweeps.parquet import write_samples
from mjbiped.sweeps.plan import Study
from mjbiped.sweeps.run import layout_of, row_of
from mjbiped.utils.parallel import cores

TRIED = 5
"""Walks that are made, evenly spread over the table."""

_LONGEST = 20.0  # s after which no further walk is tried


@dataclass(frozen=True)
class Estimate:
    """What a study will take.

    Attributes:
        walks: Number of its walks.
        workers: Number of processes that will walk.
        seconds: Time that they take, without compilation, s.
        bytes: Size of the table, and of the samples if they are kept.
        tried: Number of walks that were made for this estimate.
    """

    walks: int
    workers: int
    seconds: float
    bytes: float
    tried: int


def estimate(study: Study, *, workers: int | None = None, trajectories: bool = False) -> Estimate:
    """Make some walks of a study, and infer the time and the size of all.

    Nothing is kept. Each is walked twice, since the first time may compile.

    Args:
        study: The study.
        workers: Number of processes on this machine; by default one per core.
        trajectories: Whether the samples of all walks will be kept as well.
    """
    count = len(study.cells)
    spread = np.unique(np.linspace(0, count - 1, min(TRIED, count)).round().astype(int)).tolist()
    began, times, sizes = time.monotonic(), [], []
    for place in spread:
        row_of(study.cells[place], trajectory=trajectories)
        started = time.perf_counter()
        row = row_of(study.cells[place], trajectory=trajectories)
        times.append(time.perf_counter() - started)
        sizes.append(2.0 * sum(len(f"{row.get(name)},") for name in layout_of(study).columns))
        if trajectories:
            samples = BytesIO()
            write_samples(row, samples)
            sizes[-1] += samples.tell()
        if time.monotonic() - began > _LONGEST:
            break
    used = min(workers or cores(), count)
    return Estimate(count, used, float(np.mean(times)) * count / used, float(np.mean(sizes)) * count, len(times))
