"""Estimate of what a study will take, from some of its walks."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mjbiped.sweeps.cell import Row
from mjbiped.sweeps.parquet import Trajectories
from mjbiped.sweeps.plan import Study
from mjbiped.sweeps.run import layout_of, row_of
from mjbiped.sweeps.store import opened
from mjbiped.utils.parallel import cores

TRIED = 5
"""Walks that are made, evenly spread over the table."""

_LONGEST = 20.0  # s after which no further walk is tried
_COPIES = 400  # of rows, for a database grows by whole pages


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
    began, times, rows = time.monotonic(), [], []
    for place in spread:
        row_of(study.cells[place], trajectory=trajectories)
        started = time.perf_counter()
        rows.append(row_of(study.cells[place], trajectory=trajectories))
        times.append(time.perf_counter() - started)
        if time.monotonic() - began > _LONGEST:
            break
    used = min(workers or cores(), count)
    each = float(np.mean(times))
    return Estimate(count, used, each * count / used, _size_of_row(study, rows, trajectories) * count, len(rows))


def _size_of_row(study: Study, rows: list[Row], trajectories: bool) -> float:
    """Mean size of a walk's row in the table's files and of its samples, bytes."""
    copies = min(_COPIES, len(study.cells))
    with TemporaryDirectory() as name, opened(Path(name), layout_of(study), {}) as store:
        empty = _size(Path(name))
        store.save([{**rows[k % len(rows)], "cell": k} for k in range(copies)])
        store.export()
        table = _size(Path(name)) - empty
        if trajectories:
            Trajectories(store, len(study.cells)).save(rows)
        return table / copies + (_size(Path(name)) - empty - table) / len(rows)


def _size(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
