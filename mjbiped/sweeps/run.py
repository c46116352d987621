"""Walks a study: batches of cells to an executor, rows to the table as they come."""

from __future__ import annotations

import os
import queue
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager
from itertools import islice
from pathlib import Path
from typing import Any

from tqdm.auto import tqdm

from mjbiped.engines.plan import versions
from mjbiped.errors import MjbipedError
from mjbiped.sweeps.cell import Cell, Row, measured
from mjbiped.sweeps.plan import Study
from mjbiped.sweeps.provenance import sources
from mjbiped.sweeps.store import Store, opened
from mjbiped.utils.parallel import cluster, processes

MOST_IN_BATCH = 32
LONGEST_BATCH = 0.5
"""Seconds after which a worker hands back what it has, so that little is lost when it is killed."""


def identity_of(study: Study) -> dict[str, Any]:
    """All that the rows of a study depend on."""
    return {"study": dict(study.declared), **_machinery(), "cells": study.digest}


def run(
    study: Study,
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    fresh: bool = False,
    progress: bool = False,
) -> tuple[list[Row], Path]:
    """Walk all cells of a study that have no row yet.

    The rows do not depend on the number of workers, nor on how often it was broken off. A cell that fails is a row with
    an error's text.

    Args:
        study: What to walk.
        folder: Where the table is, or will be.
        workers: Processes on this machine; one for each core unless given.
        scheduler: Address of a Dask scheduler, whose workers walk instead.
        fresh: Begin again.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The rows in the order of the cells, and the table as a CSV file.

    Raises:
        InputError: The folder holds rows of another study, or the scheduler cannot be used.
        RecordError: The table cannot be written.
        MjbipedError: Workers died, or their mjbiped is another one; what had ended is kept.
        KeyboardInterrupt: Ctrl-C; what had ended is kept.
    """
    with opened(folder, study, identity_of(study), fresh=fresh) as store:
        done = store.done()
        todo = [cell for cell in study.cells if cell.index not in done]
        if todo:
            count = min(workers or os.cpu_count() or 1, len(todo))
            pool = processes(count) if scheduler is None else cluster(scheduler)
            with tqdm(
                total=len(study.cells), initial=len(done), desc="walks", unit="walk", disable=None if progress else True
            ) as bar:
                _walk_all(todo, store, pool, bar)
        return store.rows(), store.export()


def walk_batch(cells: Sequence[Cell], machinery: dict[str, Any]) -> list[Row]:
    """Let cells walk, in order, for `LONGEST_BATCH` or until all have; what a worker does.

    Args:
        cells: At least one.
        machinery: Sources and versions that the rows shall be of.

    Returns:
        The rows of the first cells; of one at least.

    Raises:
        MjbipedError: This process has others.
    """
    if machinery != _machinery():
        raise MjbipedError(
            "a worker's mjbiped, Python or libraries are not the same as here; install the same versions everywhere"
        )
    begun, rows = time.monotonic(), []
    for cell in cells:
        rows.append({"cell": cell.index, "sample": cell.sample, **_plain(cell), **measured(cell)})
        if time.monotonic() - begun > LONGEST_BATCH:
            break
    return rows


def _walk_all(todo: Sequence[Cell], store: Store, executor: AbstractContextManager[Executor], bar: tqdm[Any]) -> None:
    """Submit batches, keep their rows as they come, and submit again what a batch had no time for."""
    machinery = _machinery()
    ended: queue.SimpleQueue[Future[list[Row]]] = queue.SimpleQueue()
    pending: dict[Future[list[Row]], list[Cell]] = {}

    def submit(cells: Iterable[Cell], most: int) -> None:
        for batch in _batches(cells, most):
            future = pool.submit(walk_batch, batch, machinery)
            pending[future] = batch
            future.add_done_callback(ended.put)

    try:
        with executor as pool:
            submit(todo, MOST_IN_BATCH)
            while pending:
                future = ended.get()
                batch, rows = pending.pop(future), future.result()
                store.save(rows)
                bar.update(len(rows))
                submit(batch[len(rows) :], len(rows))
    except MjbipedError:
        raise
    except Exception as error:
        raise MjbipedError(
            f"the workers failed ({type(error).__name__}: {error}): a process died, of lack of memory perhaps, or a "
            f"scheduler is gone. What had ended is in {store.folder}: the same command goes on from there; with fewer "
            "--workers where memory was short"
        ) from error


def _batches(cells: Iterable[Cell], most: int) -> Iterator[list[Cell]]:
    rest = iter(cells)
    while batch := list(islice(rest, most)):
        yield batch


def _machinery() -> dict[str, Any]:
    """What computes the rows."""
    return {"sources": sources(), "versions": dict(versions())}


def _plain(cell: Cell) -> Row:
    """The values of a cell as the table holds them: truth values are text."""
    return {name: str(value).lower() if isinstance(value, bool) else value for name, value in cell.values.items()}
