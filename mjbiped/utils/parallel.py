"""Long work: worker processes, here or on a cluster, with the interface of `concurrent.futures`; and its progress."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from mjbiped.errors import InputError, shown
from mjbiped.utils.packages import needed

if TYPE_CHECKING:
    from tqdm.std import tqdm

_PATIENCE = 30.0
"""Time to wait for a scheduler, and then for its first worker, s."""


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def processes(count: int | None = None) -> Iterator[Executor]:
    """Start worker processes.

    They are spawned, since a fork of a process with threads can hang: submitted work must be picklable, and the main
    program needs `if __name__ == "__main__"`. Ctrl-C reaches this process only.

    Args:
        count: Number of processes; one for each core unless given.

    Yields:
        The executor. Its futures raise `concurrent.futures.BrokenExecutor` if a process has died. If the block raises,
        work not begun is dropped and the processes are terminated; otherwise all submitted work is awaited.
    """
    before = set(multiprocessing.active_children())
    count = count or cores()
    pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"), initializer=_begin)
    try:
        with _deaf_children():
            for _ in range(count):  # each submission finds no idle worker, and starts one
                pool.submit(int)
        yield pool
    except BaseException:
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
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
            f"no Dask scheduler answers at {shown(address)} ({error}); start one: dask scheduler"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError as error:
            raise InputError(
                f"the scheduler at {address} has no workers; start: dask worker {address} --nthreads 1"
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


def _begin() -> None:
    """Ignore Ctrl-C, which the process that started this one handles, and end with that process if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    from tqdm.auto import tqdm

    # tqdm's own lock is a system semaphore, which a terminated worker would leave behind
    tqdm.set_lock(threading.RLock())
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end_with_parent() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


EVERY = 30.0
"""Time between lines where there is no terminal, s."""

_LINE = "{desc}: {n_fmt} of {total_fmt} after {elapsed}, {rate_fmt}, {remaining} left"


def progress_bar(iterable: Iterable[object] | None = None, *, progress: bool = True, **given: Any) -> tqdm[Any]:
    """Return a progress bar on stderr; where that is no terminal, one that writes a line every half a minute.

    Args:
        iterable: What is gone through, as for tqdm.
        progress: Whether progress is shown at all.
        **given: Other arguments of tqdm.
    """
    # imported where it is used: `import mjbiped` need not wait for it
    from tqdm.auto import tqdm as shown
    from tqdm.std import tqdm

    class Lines(tqdm):  # type: ignore[type-arg]  # generic in its stubs only
        """A bar each of whose states is a line of its own."""

        def display(self, msg: str | None = None, pos: int | None = None) -> None:
            """Write a line; none at the end, where tqdm clears its own by an empty one."""
            if msg is None:
                print(self, file=self.fp, flush=True)

    if not progress or in_notebook() or sys.stderr.isatty():
        return shown(iterable, disable=not progress, **given)
    # each step looks at the clock, and the rate is that of the whole time: a line says what is so when it is written
    rare = {"delay": EVERY, "mininterval": EVERY, "miniters": 1, "smoothing": 0.0}
    return Lines(iterable, leave=False, bar_format=_LINE, **{**rare, **given})


def in_notebook() -> bool:
    """Whether this process is a notebook's kernel, by the test of `tqdm.auto`."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and "IPKernelApp" in shell.config
