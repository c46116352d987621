"""Worker processes: they do the work, and none is left behind."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from concurrent.futures import BrokenExecutor

import pytest

from mjbiped.utils.parallel import processes


def test_work_is_done_elsewhere() -> None:
    with processes(1) as pool:
        assert pool.submit(os.getpid).result() != os.getpid()
        assert pool.submit(signal.getsignal, signal.SIGINT).result() == signal.SIG_IGN
        late = pool.submit(pow, 2, 10)
    assert late.result() == 1024
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_error_ends_the_workers_at_once() -> None:
    def broken_off() -> None:
        with processes(1) as pool:
            pool.submit(os.getpid).result()
            for _ in range(5):
                pool.submit(time.sleep, 600.0)
            raise KeyboardInterrupt

    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        broken_off()
    assert time.monotonic() - started < 120.0  # the import in the worker, on a busy machine
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_workers_do_not_hear_ctrl_c_from_their_first_moment_on() -> None:
    with processes(2) as pool:
        children = multiprocessing.active_children()
        assert len(children) == 2
        for child in children:
            assert child.pid is not None
            os.kill(child.pid, signal.SIGINT)  # still busy with their imports
        assert pool.submit(pow, 2, 3).result() == 8
    assert [child.exitcode for child in children] == [0, 0]


def test_worker_that_dies_is_told() -> None:
    with pytest.raises(BrokenExecutor), processes(1) as pool:
        pool.submit(os._exit, 1).result()
    assert multiprocessing.active_children() == []
