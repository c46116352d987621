"""Walks many cells: hybrid ones here, MuJoCo's in processes, for its callbacks belong to a whole process."""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import BrokenExecutor, Future, as_completed
from typing import Any

from tqdm.auto import tqdm

from mjbiped.errors import MjbipedError
from mjbiped.reproduction.cell import Cell, Result, measured
from mjbiped.reproduction.store import Store
from mjbiped.utils.parallel import processes


def run_cells(
    cells: Iterable[Cell], store: Store, *, workers: int | None = None, progress: bool = False
) -> dict[str, Result]:
    """Walk all cells that the store does not hold yet, and keep each as soon as it has ended.

    The results do not depend on the number of workers. A cell that fails is a result with an error's text.

    Args:
        cells: Any number; equal ones are walked once.
        store: Where finished cells are.
        workers: Processes for MuJoCo; one for each core unless given.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The result of each cell, by its key.

    Raises:
        MjbipedError: A process died, of lack of memory perhaps; what had ended is in the store.
        KeyboardInterrupt: Ctrl-C; what had ended is in the store.
    """
    results: dict[str, Result] = {}
    todo: dict[str, list[Cell]] = {"hybrid": [], "mujoco": []}
    wanted = {cell.key: cell for cell in cells}
    for cell in wanted.values():
        result = store.load(cell)
        if result is None:
            todo[cell.engine].append(cell)
        else:
            results[cell.key] = result
    with tqdm(
        total=len(wanted), initial=len(results), desc="walks", unit="walk", disable=None if progress else True
    ) as bar:
        for cell in todo["hybrid"]:
            results[cell.key] = _walked(cell, store)
            bar.update()
        if todo["mujoco"]:
            _run_processes(todo["mujoco"], store, workers or os.cpu_count() or 1, results, bar)
    return results


def _walked(cell: Cell, store: Store) -> Result:
    """Walk a cell and keep what came of it."""
    result, record = measured(cell)
    store.save(cell, result, record)
    return result


def _run_processes(cells: list[Cell], store: Store, workers: int, results: dict[str, Result], bar: tqdm[Any]) -> None:
    """Walk cells in processes of their own, the longest first."""
    try:
        with processes(min(workers, len(cells))) as pool:
            futures: dict[Future[Result], Cell] = {
                pool.submit(_walked, cell, store): cell for cell in sorted(cells, key=lambda cell: -(cell.steps or 0))
            }
            for future in as_completed(futures):
                results[futures[future].key] = future.result()
                bar.update()
    except BrokenExecutor as error:
        raise MjbipedError(
            "a process that walked in MuJoCo died, of lack of memory perhaps; what had ended is kept: start again, "
            "with fewer --workers"
        ) from error
