"""Run the walks of a study in worker processes, and digest the sources on which their numbers depend."""

from __future__ import annotations

import hashlib
import queue
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from functools import lru_cache, partial
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from mjbiped import errors
from mjbiped.control.loading import digest_of
from mjbiped.control.registry import registered
from mjbiped.engines.ahead import AHEAD
from mjbiped.engines.mujoco import scene
from mjbiped.engines.plan import versions
from mjbiped.errors import MjbipedError
from mjbiped.sweeps.cell import KNEES_MEASURES, Cell, Row, measured
from mjbiped.sweeps.parquet import Trajectories, forget
from mjbiped.sweeps.plan import Study
from mjbiped.sweeps.store import Layout, Store, opened
from mjbiped.utils.parallel import cluster, cores, processes
from mjbiped.utils.progress import progress_bar

MOST_IN_BATCH = 32
LONGEST_BATCH = 0.5
"""Time after which a worker returns its finished rows, s, so that little is lost if it is killed."""

_NO_NUMBERS = ("cli", "plotting", "rendering", "reports", "reproduction", "sweeps")
"""Packages that change no number of a walk, apart from their files `cell.py`, which define walks and measures."""

AnyCell = TypeVar("AnyCell")


class Swept(NamedTuple):
    """What `run` did.

    Attributes:
        rows: Rows of all cells, in their order.
        table: The table as a CSV file.
        walks: Number of walks that were made now; the others had ended earlier.
        seconds: Time that they took, s.
    """

    rows: list[Row]
    table: Path
    walks: int
    seconds: float


def layout_of(study: Study) -> Layout:
    """Describe the columns of a study's table."""
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
) -> Swept:
    """Walk all cells of a study that have no row yet.

    The rows depend neither on the number of workers nor on interruptions. A cell that fails gets a row with the error's
    text.

    Args:
        study: The study.
        folder: Folder of the table.
        workers: Number of processes on this machine; by default one per core.
        scheduler: Address of a Dask scheduler, whose workers are used instead.
        fresh: Delete all rows in the folder and start again.
        trajectories: Also keep the samples of all walks, in `mjbiped.sweeps.parquet.FILE`; cells whose samples were
            not kept are walked again.
        progress: Show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: The folder holds rows of another study, or the scheduler cannot be used.
        RecordError: The table cannot be written.
        MjbipedError: Workers died, or run other versions than this process; finished rows are kept.
        KeyboardInterrupt: Ctrl-C was pressed; finished rows are kept.
    """
    identity = {"study": dict(study.declared), **_machinery(study.laws), "cells": study.digest}
    with opened(folder, layout_of(study), identity, fresh=fresh) as store:
        if fresh:
            forget(folder)
        done = {row["cell"] for row in store.rows()}
        samples = Trajectories(store, len(study.cells)) if trajectories else None
        if samples is not None:
            done &= samples.cells()
        todo = [cell for cell in study.cells if cell.index not in done]
        started = time.monotonic()
        walk_cells(
            partial(row_of, trajectory=trajectories),
            todo,
            samples or store,
            ended=len(done),
            workers=workers,
            scheduler=scheduler,
            progress=progress,
            laws=study.laws,
        )
        seconds = time.monotonic() - started
        if samples is not None:
            samples.join()
        return Swept(store.rows(), store.export(), len(todo), seconds)


def walk_cells(
    walked: Callable[[AnyCell], Row],
    todo: Sequence[AnyCell],
    store: Store | Trajectories,
    *,
    ended: int,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = False,
    laws: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Walk cells in worker processes, and store their rows as they arrive.

    Args:
        walked: Function that walks a cell in a worker and returns its row.
        todo: Cells to walk.
        store: Store of the rows.
        ended: Number of cells finished earlier, for the progress bar.
        workers: Number of processes on this machine; by default one per core.
        scheduler: Address of a Dask scheduler, whose workers are used instead.
        progress: Show a progress bar (never where the output is not a terminal).
        laws: The user's own controllers, see `Study.laws`.

    Raises:
        InputError: The scheduler cannot be used.
        RecordError: The rows cannot be written.
        MjbipedError: Workers died, or run other versions than this process; finished rows are kept.
    """
    if not todo:
        return
    machinery = _machinery(laws)
    back: queue.SimpleQueue[Future[list[Row]]] = queue.SimpleQueue()
    pending: dict[Future[list[Row]], list[AnyCell]] = {}

    def submit(cells: Iterable[AnyCell], most: int) -> None:
        rest = iter(cells)
        while batch := list(islice(rest, most)):
            future = pool.submit(
                walk_batch, walked, batch, machinery, dict(laws), len(todo)
            )  # no mapping proxy: it cannot be pickled
            pending[future] = batch
            future.add_done_callback(back.put)

    count = min(workers or cores(), len(todo))
    bar = progress_bar(total=ended + len(todo), initial=ended, desc="walks", unit="walk", progress=progress)
    try:
        with bar, processes(count) if scheduler is None else cluster(scheduler) as pool:
            submit(todo, MOST_IN_BATCH)
            while pending:
                future = back.get()
                batch, rows = pending.pop(future), future.result()
                store.save(rows)
                bar.update(len(rows))
                submit(batch[len(rows) :], len(rows))  # cells that the batch had no time for
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
    walks: int = 1,
) -> list[Row]:
    """Walk cells in order until all are done or `LONGEST_BATCH` has passed; a worker calls this.

    Args:
        walked: Function that walks a cell and returns its row.
        cells: At least one cell.
        machinery: Sources and versions with which the rows must be computed.
        laws: The user's own controllers, see `Study.laws`.
        walks: Number of walks of all batches.

    Returns:
        Rows of the cells that were walked, at least one.

    Raises:
        MjbipedError: This process has other sources or versions.
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
    before = AHEAD.set(walks)
    try:
        for cell in cells:
            rows.append(walked(cell))
            if time.monotonic() - started > LONGEST_BATCH:
                break
    finally:
        AHEAD.reset(before)
    return rows


def _machinery(laws: Mapping[str, str]) -> dict[str, Any]:
    """Digests and versions of everything that computes the rows."""
    own = {"controllers": {name: digest_of(place) for name, place in laws.items()}} if laws else {}
    return {"sources": sources(), "versions": dict(versions()), **own}


def row_of(cell: Cell, *, trajectory: bool = False) -> Row:
    """Walk a study's cell, and return its row, with booleans as text."""
    plain = {name: str(value).lower() if isinstance(value, bool) else value for name, value in cell.values.items()}
    return {"cell": cell.index, "sample": cell.sample, **plain, **measured(cell, trajectory=trajectory)}


@lru_cache(maxsize=1)
def sources() -> str:
    """Digest of all source files that a walk's numbers can depend on."""
    return digest(Path(errors.__file__).parent, law_folders(), scene.models_folder())


def law_folders() -> list[Path]:
    """Folders of the packages that register controllers, and files of registered modules outside any package."""
    names = [entry.module.split(".") for entry in registered().values()]
    # of this project the laws alone, whose folder is a link in a checkout, which no search through it follows
    packages = {".".join(name[: 2 if name[0] == "mjbiped" else 1]) for name in names}
    specs = filter(None, map(find_spec, sorted(packages)))
    return [Path(place) for spec in specs for place in spec.submodule_search_locations or (spec.origin,) if place]


def digest(package: Path, laws: Sequence[Path], models: Path) -> str:
    """Digest the contents and paths of all files that a walk's numbers can depend on."""
    found = hashlib.sha256()
    for place in (package, *laws, models):
        files = [place] if place.is_file() else sorted([*place.rglob("*.py"), *place.rglob("*.xml")])
        for file in files:
            name = file.relative_to(place)
            if place != package or name.parts[0] not in _NO_NUMBERS or name.name == "cell.py":
                found.update(f"{place.name}/{name.as_posix()}\n".encode() + hashlib.sha256(file.read_bytes()).digest())
    return found.hexdigest()
