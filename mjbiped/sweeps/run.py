"""Lets cells walk in other processes: batches to an executor, rows to the table as they come."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from tqdm.auto import tqdm

from mjbiped.control.loading import digest_of
from mjbiped.engines.plan import versions
from mjbiped.errors import MjbipedError
from mjbiped.sweeps.cell import KNEES_MEASURES, Cell, Row, measured
from mjbiped.sweeps.plan import Study
from mjbiped.sweeps.provenance import sources
from mjbiped.sweeps.store import Layout, Store, opened
from mjbiped.sweeps.trajectories import Trajectories, forget
from mjbiped.utils.parallel import cluster, cores, processes
from mjbiped.utils.progress import hidden

MOST_IN_BATCH = 32
LONGEST_BATCH = 0.5
"""Seconds after which a worker hands back what it has, so that little is lost when it is killed."""

AnyCell = TypeVar("AnyCell")


def layout_of(study: Study) -> Layout:
    """Describe what a study's table holds."""
    columns = ("cell", *(("sample",) if study.drawn else ()), *study.varied, "outcome", "error", *study.measures)
    return Layout("study", columns, range(len(study.cells)), frozenset(KNEES_MEASURES))


def run(
    study: Study,
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    fresh: bool = False,
    trajectories: bool = False,
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
        trajectories: Keep the samples of all walks too, in `mjbiped.sweeps.trajectories.FILE`; cells that have walked
            without are walked again.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The rows in the order of the cells, and the table as a CSV file.

    Raises:
        InputError: The folder holds rows of another study, or the scheduler cannot be used.
        RecordError: The table cannot be written.
        MjbipedError: Workers died, or their mjbiped is another one; what had ended is kept.
        KeyboardInterrupt: Ctrl-C; what had ended is kept.
    """
    identity = {"study": dict(study.declared), **_machinery(study.laws), "cells": study.digest}
    with opened(folder, layout_of(study), identity, fresh=fresh) as store:
        if fresh:
            forget(folder)
        done = {row["cell"] for row in store.rows()}
        kept = None
        if trajectories:
            kept = Trajectories(folder, len(study.cells))
            done &= kept.cells()
        todo = [cell for cell in study.cells if cell.index not in done]
        walk_cells(
            partial(_walked, trajectory=trajectories),
            todo,
            store,
            ended=len(done),
            workers=workers,
            scheduler=scheduler,
            progress=progress,
            laws=study.laws,
            keep=None if kept is None else kept.keep,
        )
        if kept is not None:
            kept.join()
        return store.rows(), store.export()


def walk_cells(
    walked: Callable[[AnyCell], Row],
    todo: Sequence[AnyCell],
    store: Store,
    *,
    ended: int,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = False,
    laws: Mapping[str, str] = MappingProxyType({}),
    keep: Callable[[Sequence[Row]], None] | None = None,
) -> None:
    """Let cells walk in other processes, and keep their rows as they come.

    Args:
        walked: Lets a cell walk, there, and returns its row.
        todo: The cells.
        store: Where the rows are kept.
        ended: How many cells have ended before, for the progress bar.
        workers: As of `run`, and so are scheduler, progress and what is raised.
        scheduler: See there.
        progress: See there.
        laws: Of the user's own; see `Study.laws`.
        keep: Keeps what of the rows is no part of the table, before the table has them.
    """
    if not todo:
        return
    machinery = _machinery(laws)
    back: queue.SimpleQueue[Future[list[Row]]] = queue.SimpleQueue()
    pending: dict[Future[list[Row]], list[AnyCell]] = {}

    def submit(cells: Iterable[AnyCell], most: int) -> None:
        rest = iter(cells)
        while batch := list(islice(rest, most)):
            future = pool.submit(walk_batch, walked, batch, machinery, dict(laws))  # a mapping's proxy is not picklable
            pending[future] = batch
            future.add_done_callback(back.put)

    count = min(workers or cores(), len(todo))
    bar = tqdm(total=ended + len(todo), initial=ended, desc="walks", unit="walk", disable=hidden(progress))
    try:
        with bar, processes(count) if scheduler is None else cluster(scheduler) as pool:
            submit(todo, MOST_IN_BATCH)
            while pending:
                future = back.get()
                batch, rows = pending.pop(future), future.result()
                if keep is not None:
                    keep(rows)
                store.save(rows)
                bar.update(len(rows))
                submit(batch[len(rows) :], len(rows))  # what the batch had no time for
    except MjbipedError:
        raise
    except Exception as error:
        raise MjbipedError(
            f"the workers failed ({type(error).__name__}: {error}): a process died, of lack of memory perhaps, or a "
            f"scheduler is gone. What had ended is in {store.folder}: the same command goes on from there; with fewer "
            "--workers where memory was short"
        ) from error


def walk_batch(
    walked: Callable[[AnyCell], Row],
    cells: Sequence[AnyCell],
    machinery: dict[str, Any],
    laws: Mapping[str, str] = MappingProxyType({}),
) -> list[Row]:
    """Let cells walk, in order, for `LONGEST_BATCH` or until all have; what a worker does.

    Args:
        walked: Lets a cell walk, and returns its row.
        cells: At least one.
        machinery: Sources and versions that the rows shall be of.
        laws: As of `walk_cells`.

    Returns:
        The rows of the first cells; of one at least.

    Raises:
        MjbipedError: This process has others.
    """
    here = _machinery(laws)
    for name, digest in machinery.get("controllers", {}).items():
        if here["controllers"][name] != digest:
            raise MjbipedError(
                f"the source of the controller {name} is another one where it walks: it has changed since the study "
                "was begun, or that machine has another file"
            )
    if machinery != here:
        raise MjbipedError(
            "a worker's mjbiped, Python or libraries are not the same as here; install the same versions everywhere"
        )
    started, rows = time.monotonic(), []
    for cell in cells:
        rows.append(walked(cell))
        if time.monotonic() - started > LONGEST_BATCH:
            break
    return rows


def _machinery(laws: Mapping[str, str]) -> dict[str, Any]:
    """What computes the rows."""
    own = {"controllers": {name: digest_of(place) for name, place in laws.items()}} if laws else {}
    return {"sources": sources(), "versions": dict(versions()), **own}


def _walked(cell: Cell, *, trajectory: bool = False) -> Row:
    """Let a study's cell walk; its row, where truth values are text."""
    plain = {name: str(value).lower() if isinstance(value, bool) else value for name, value in cell.values.items()}
    return {"cell": cell.index, "sample": cell.sample, **plain, **measured(cell, trajectory=trajectory)}
