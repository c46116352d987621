"""Run a study's walks in worker processes, or estimate what they will take; digest the sources of their numbers."""

from __future__ import annotations

import hashlib
import queue
import random
import time
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import cache, partial
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mjbiped import errors
from mjbiped.control.loading import digest_of
from mjbiped.control.registry import registered
from mjbiped.engines.compiling import AHEAD
from mjbiped.engines.mujoco import scene
from mjbiped.engines.plan import versions
from mjbiped.errors import MjbipedError
from mjbiped.studies.cell import Cell, Row
from mjbiped.studies.plan import Study
from mjbiped.studies.store import join_samples, opened, sampled, save_samples, write_samples
from mjbiped.utils.packages import needed
from mjbiped.utils.parallel import cluster, cores, processes, progress_bar

_NO_NUMBERS = ("cli", "plotting", "rendering", "reports", "studies", "viewing")
_NUMBERS = "cell.py"
"""Packages that change no number of a walk, apart from their files of this name, which define walks and measures."""

TRIED = 5
"""Walks of each engine that are made for an estimate, evenly spread over the table."""

_LONGEST = 20.0  # s after which no further walk of an engine is tried
_SMOOTHING = 0.05  # of the rate from which the time left is told: that of some twenty arrivals, of all kinds of walks


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


def columns_of(study: Study) -> tuple[str, ...]:
    """Names of the columns of a study's table."""
    return ("cell", *(("sample",) if study.drawn else ()), *study.varied, "outcome", "error", *study.measures)


def run(study: Study, folder: Path, *, fresh: bool = False, trajectories: bool = False, **walking: Any) -> Swept:
    """Walk all cells of a study that have no row yet.

    The rows depend neither on the number of workers nor on interruptions. A cell that fails gets a row with the error's
    text.

    Args:
        study: The study.
        folder: Folder of the table.
        fresh: Delete all rows in the folder and start again.
        trajectories: Also keep the samples of all walks, in `mjbiped.studies.store.FILE`; cells whose samples were
            not kept are walked again.
        **walking: The arguments workers, scheduler and progress of `walk_cells`.

    Raises:
        InputError: The folder holds rows of another study, or the scheduler cannot be used.
        RecordError: The table cannot be written.
        MjbipedError: Workers died, or run other versions than this process; finished rows are kept.
        KeyboardInterrupt: Ctrl-C was pressed; finished rows are kept.
    """
    if trajectories:
        needed("pyarrow.parquet", "data", "keeping trajectories")
    laws = {name: digest_of(place) for name, place in study.laws.items()}
    identity = {"study": dict(study.declared), **machinery(), "controllers": laws, "cells": study.digest}
    with opened(folder, "study", columns_of(study), identity, fresh=fresh) as store:
        done = {row["cell"] for row in store.rows()}
        done &= sampled(folder, len(study.cells)) if trajectories else done

        def save(rows: Sequence[Row]) -> None:
            if trajectories:
                save_samples(folder, rows)
            store.save(rows)

        todo = [cell for cell in study.cells if cell.index not in done]
        random.Random(0).shuffle(todo)  # the time left is told from walks of all kinds, not from the quick ones first
        started = time.monotonic()
        walked = partial(Cell.row, trajectory=trajectories, laws=laws)
        walk_cells(walked, todo, save, ended=len(done), **walking)
        seconds = time.monotonic() - started
        if trajectories:
            join_samples(folder, len(study.cells))
        return Swept(store.rows(), store.export(), len(todo), seconds)


def estimate(study: Study, *, workers: int | None = None, trajectories: bool = False) -> dict[str, float]:
    """Make some walks of a study in each of its engines, and infer the time and the size of all.

    Nothing is kept. Each is walked twice, since the first time may compile.

    Args:
        study: The study.
        workers: Number of processes on this machine; by default one per core.
        trajectories: Whether the samples of all walks will be kept as well.

    Returns:
        Number of `walks` and of `workers` that will walk, the `seconds` that they take without compilation, the
        `bytes` of the table and of the samples if they are kept, and the number of walks `tried` for this.
    """
    kinds: dict[object, list[Cell]] = defaultdict(list)
    for cell in study.cells:
        kinds[cell.values["engine"]].append(cell)
    seconds, size, tried = 0.0, 0.0, 0
    for cells in kinds.values():
        began, times, sizes = time.monotonic(), [], []
        for place in np.unique(np.linspace(0, len(cells) - 1, TRIED).round().astype(int)).tolist():
            cells[place].row(trajectory=trajectories)
            started = time.perf_counter()
            row = cells[place].row(trajectory=trajectories)
            times.append(time.perf_counter() - started)
            samples = BytesIO()
            if trajectories:
                write_samples(row, samples)
            sizes.append(2.0 * sum(len(f"{row.get(name)},") for name in columns_of(study)) + samples.tell())
            if time.monotonic() - began > _LONGEST:
                break
        seconds += float(np.mean(times)) * len(cells)
        size += float(np.mean(sizes)) * len(cells)
        tried += len(times)
    used = min(workers or cores(), len(study.cells))
    return {"walks": len(study.cells), "workers": used, "seconds": seconds / used, "bytes": size, "tried": tried}


def walk_cells(
    walked: Callable[[Cell], Row],
    todo: Sequence[Cell],
    save: Callable[[Sequence[Row]], None],
    *,
    ended: int,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = False,
) -> None:
    """Walk cells in worker processes, and store each row as it arrives.

    Args:
        walked: Function that walks a cell in a worker and returns its row.
        todo: Cells to walk.
        save: Puts rows on disk.
        ended: Number of cells finished earlier, for the progress bar.
        workers: Number of processes on this machine; by default one per core.
        scheduler: Address of a Dask scheduler, whose workers are used instead.
        progress: Show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: The scheduler cannot be used.
        RecordError: The rows cannot be written.
        MjbipedError: Workers died, or run other versions than this process; finished rows are kept.
    """
    if not todo:
        return
    back: queue.SimpleQueue[Future[Row]] = queue.SimpleQueue()
    count = min(workers or cores(), len(todo))
    named = {"desc": "walks", "unit": "walk"}
    bar = progress_bar(total=ended + len(todo), initial=ended, smoothing=_SMOOTHING, progress=progress, **named)
    try:
        with bar, processes(count) if scheduler is None else cluster(scheduler) as pool:
            for cell in todo:
                pool.submit(walk_one, walked, cell, machinery(), len(todo)).add_done_callback(back.put)
            left = len(todo)
            while left:
                arrived = [back.get() for _ in range(max(1, back.qsize()))]
                save([future.result() for future in arrived if future.exception() is None])
                for future in arrived:
                    future.result()
                bar.update(len(arrived))
                left -= len(arrived)
    except MjbipedError:
        raise
    except Exception as error:
        raise MjbipedError(
            f"the workers failed ({type(error).__name__}: {error}): a process died, of lack of memory perhaps, or a "
            "scheduler is gone. What had ended is kept, and the same command goes on from there; with fewer --workers "
            "where memory was short"
        ) from error


def walk_one(walked: Callable[[Cell], Row], cell: Cell, needed: Mapping[str, object], walks: int) -> Row:
    """Walk a cell; a worker calls this.

    Args:
        walked: Function that walks the cell and returns its row.
        cell: The cell.
        needed: Sources and versions with which the row must be computed.
        walks: Number of walks that are being made.

    Raises:
        MjbipedError: This process has other sources or versions.
    """
    if needed != machinery():
        raise MjbipedError("a worker has another mjbiped, Python or libraries: install the same versions everywhere")
    before = AHEAD.set(walks)
    try:
        return walked(cell)
    finally:
        AHEAD.reset(before)


@cache
def machinery() -> Mapping[str, object]:
    """Digest of all source files on which a walk's numbers can depend, and versions of all that computes them."""
    sources = digest(Path(errors.__file__).parent, law_folders(), scene.models_folder())
    return {"sources": sources, "versions": dict(versions())}


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
        for file in [place] if place.is_file() else sorted([*place.rglob("*.py"), *place.rglob("*.xml")]):
            name = file.relative_to(place)
            if place != package or name.parts[0] not in _NO_NUMBERS or name.name == _NUMBERS:
                found.update(f"{place.name}/{name.as_posix()}\n".encode() + hashlib.sha256(file.read_bytes()).digest())
    return found.hexdigest()
