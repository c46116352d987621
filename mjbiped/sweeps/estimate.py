"""Estimate of what a study will take, from some of its walks."""

from __future__ import annotations

import time
from io import BytesIO

import numpy as np

from mjbiped.sweeps.parquet import write_samples
from mjbiped.sweeps.plan import Study
from mjbiped.sweeps.run import layout_of
from mjbiped.utils.parallel import cores

TRIED = 5
"""Walks that are made, evenly spread over the table."""

_LONGEST = 20.0  # s after which no further walk is tried


def estimate(study: Study, *, workers: int | None = None, trajectories: bool = False) -> dict[str, float]:
    """Make some walks of a study, and infer the time and the size of all.

    Nothing is kept. Each is walked twice, since the first time may compile.

    Args:
        study: The study.
        workers: Number of processes on this machine; by default one per core.
        trajectories: Whether the samples of all walks will be kept as well.

    Returns:
        Number of `walks` and of `workers` that will walk, the `seconds` that they take without compilation, the
        `bytes` of the table and of the samples if they are kept, and the number of walks `tried` for this.
    """
    count = len(study.cells)
    spread = np.unique(np.linspace(0, count - 1, min(TRIED, count)).round().astype(int)).tolist()
    began, times, sizes = time.monotonic(), [], []
    for place in spread:
        study.cells[place].row(trajectory=trajectories)
        started = time.perf_counter()
        row = study.cells[place].row(trajectory=trajectories)
        times.append(time.perf_counter() - started)
        sizes.append(2.0 * sum(len(f"{row.get(name)},") for name in layout_of(study).columns))
        if trajectories:
            samples = BytesIO()
            write_samples(row, samples)
            sizes[-1] += samples.tell()
        if time.monotonic() - began > _LONGEST:
            break
    used = min(workers or cores(), count)
    seconds, size = float(np.mean(times)) * count / used, float(np.mean(sizes)) * count
    return {"walks": count, "workers": used, "seconds": seconds, "bytes": size, "tried": len(times)}
