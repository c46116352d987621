"""Processes that work for this one, behind the interface of `concurrent.futures`."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager

from tqdm.auto import tqdm


@contextmanager
def processes(count: int | None = None) -> Iterator[Executor]:
    """Have work done in processes of their own, which end with this one, however it ends.

    They are spawned, for a fork of a process with threads can hang: what is submitted must be picklable, and a program
    that does so needs its `if __name__ == "__main__"`. Ctrl-C reaches this process alone.

    Args:
        count: Number of processes; one for each core unless given.

    Yields:
        The executor. Its futures raise `concurrent.futures.BrokenExecutor` where a process has died. Where the block
        raises, work not begun is dropped and the processes are ended; else all that was submitted is waited for.
    """
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        count or os.cpu_count() or 1, mp_context=multiprocessing.get_context("spawn"), initializer=_begin
    )
    try:
        yield pool
    except BaseException:
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


def _begin() -> None:
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
