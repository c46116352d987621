"""Walks many cells: hybrid ones here, MuJoCo's in processes, for its callbacks belong to a whole process."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterable
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from tqdm.auto import tqdm

from mjbiped.errors import MjbipedError
from mjbiped.reproduction.cell import Cell, Result, measured
from mjbiped.reproduction.store import Store


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
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        min(workers, len(cells)), mp_context=multiprocessing.get_context("spawn"), initializer=_begin_worker
    )
    try:
        futures: dict[Future[Result], Cell] = {
            pool.submit(_walked, cell, store): cell for cell in sorted(cells, key=lambda cell: -(cell.steps or 0))
        }
        for future in as_completed(futures):
            results[futures[future].key] = future.result()
            bar.update()
    except BrokenProcessPool as error:
        raise MjbipedError(
            "a process that walked in MuJoCo died, of lack of memory perhaps; what had ended is kept: start again, "
            "with fewer --workers"
        ) from error
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
        raise
    finally:
        pool.shutdown()


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, and end where it ends, killed or not."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # tqdm's own lock is a semaphore of the system, which a worker that is ended would leave behind
    tqdm.set_lock(threading.RLock())
    parent = multiprocessing.parent_process()
    assert parent is not None

    def leave_with_parent() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=leave_with_parent, daemon=True).start()
