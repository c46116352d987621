"""Worker processes, here or on a cluster, with the interface of `concurrent.futures`."""

from __future__ import annotations

import ast
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, ModuleType
from typing import NoReturn

from mjbiped.errors import InputError, shown
from mjbiped.utils.files import remove_unfinished
from mjbiped.utils.packages import needed

_PATIENCE = 30.0
"""Time to wait for a scheduler, and then for its first worker, s."""

_MERCY = 5.0
"""Time that a terminated process may take to end, s: compiled code handles no signal before it returns."""


class UnguardedError(InputError, SystemExit):
    """A program starts processes in lines that each of them would run again.

    It is also a `SystemExit`: such a program does not catch it, and ends with this one line and status 1.
    """

    def __init__(self, place: str) -> None:
        """Make the message for a place in the program."""
        super().__init__(
            f"{place}: this starts processes, which import the program, so it must stand under "
            '`if __name__ == "__main__":`, with imports and definitions above; walk_many(..., workers=1) starts none'
        )
        self.code: str | int = str(self)


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def processes(count: int | None = None) -> Iterator[Executor]:
    """Start worker processes, which end with this process, however it ends.

    They are spawned, since a fork of a process with threads can hang: submitted work must be picklable, and the main
    program needs `if __name__ == "__main__"`. Ctrl-C reaches this process only.

    Args:
        count: Number of processes; one for each core unless given.

    Yields:
        The executor. Its futures raise `concurrent.futures.BrokenExecutor` if a process has died. If the block raises,
        work not begun is dropped and the processes are terminated; otherwise all submitted work is awaited.

    Raises:
        UnguardedError: The program has no such guard.
    """
    check_guarded()
    before = set(multiprocessing.active_children())
    count = count or cores()
    pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"), initializer=_begin)
    try:
        with _deaf_children():
            for _ in range(count):  # each submission finds no idle worker, and starts one
                pool.submit(_nothing)
        yield pool
    except BaseException:
        started = set(multiprocessing.active_children()) - before
        for child in started:
            child.terminate()
        end = time.monotonic() + _MERCY
        for child in started:
            child.join(max(0.0, end - time.monotonic()))
            child.kill()  # does nothing to those that have ended
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Connect to the workers of a Dask scheduler.

    Args:
        address: Address of the scheduler, such as "tcp://host:8786".

    Yields:
        The executor. Work of a worker that died goes to another. If the block raises, work not begun is dropped.

    Raises:
        InputError: Dask Distributed is not installed, nobody answers at the address, or there are no workers.
    """
    distributed = needed("distributed", "cluster", "a --scheduler")
    try:
        client = distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"no Dask scheduler answers at {shown(address)} ({error}); start one with: dask scheduler"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError as error:
            raise InputError(
                f"the scheduler at {address} has no workers; start some with: dask worker {address} --nthreads 1"
            ) from error
        pool = client.get_executor()
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False)
            raise
        pool.shutdown()


@contextmanager
def _deaf_children() -> Iterator[None]:
    """Block Ctrl-C while processes start: they inherit the mask and ignore it even before `_begin`."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)


def _nothing() -> None:
    pass


def _begin() -> None:
    """Ignore Ctrl-C, and end when the parent ends or on SIGTERM, without leaving unfinished files."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda number, _: _leave(128 + number))
    from tqdm.auto import tqdm

    # tqdm's own lock is a system semaphore, which a terminated worker would leave behind
    tqdm.set_lock(threading.RLock())
    parent = multiprocessing.parent_process()
    assert parent is not None

    def leave_with_parent() -> None:
        parent.join()
        _leave(1)

    threading.Thread(target=leave_with_parent, daemon=True).start()


def _leave(status: int) -> NoReturn:
    """End this process at once."""
    remove_unfinished()
    os._exit(status)


def check_guarded() -> None:
    """Refuse to start processes from lines of the main program that each process would run again.

    Raises:
        UnguardedError: The main program is at such a line, or this is such a process.
    """
    main = sys.modules.get("__main__")
    file = getattr(main, "__file__", None)
    if getattr(multiprocessing.current_process(), "_inheriting", False):  # importing the parent's program
        error = UnguardedError("the program")
        error.code = 1  # no message: there are as many of these as processes, and their parent reports it
        raise error
    if main is None or file is None or not _is_imported(main):
        return
    line = _line_of_main(sys._getframe(), Path(file))
    if line is not None and not _is_guarded(Path(file), line):
        raise UnguardedError(f"{Path(file).name}, line {line}")


def _is_imported(main: ModuleType) -> bool:
    """Whether processes import the main program; `multiprocessing.spawn` does not for `python -m package`."""
    name = getattr(getattr(main, "__spec__", None), "name", "")
    return not (name == "__main__" or name.endswith(".__main__"))


def _line_of_main(frame: FrameType | None, file: Path) -> int | None:
    """The line that the main program is running; None if it did not call this, or under some profilers."""
    while frame is not None:
        code = frame.f_code
        if code.co_name == "<module>" and Path(code.co_filename).resolve() == file.resolve():
            return frame.f_lineno
        frame = frame.f_back
    return None


def _is_guarded(file: Path, line: int) -> bool:
    """Whether a guard begins at or above a line of a program; true if its source cannot be read."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return True
    tests = [node.test for node in ast.walk(tree) if isinstance(node, ast.If) and node.lineno <= line]
    return any(isinstance(part, ast.Name) and part.id == "__name__" for test in tests for part in ast.walk(test))
