"""Long work: workers do it, none is left behind; its progress is a bar on a terminal, and lines elsewhere."""

import io
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor
from pathlib import Path

import pytest

from mjbiped.utils import parallel
from mjbiped.utils.parallel import processes, progress_bar


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


def test_worker_that_dies_is_told() -> None:
    with pytest.raises(BrokenExecutor), processes(1) as pool:
        pool.submit(os._exit, 1).result()
    assert multiprocessing.active_children() == []


def test_a_program_without_a_guard_is_told(tmp_path: Path) -> None:
    body = "from mjbiped.utils.parallel import processes\nwith processes(1) as it:\n    it.submit(abs, -3).result()\n"
    (tmp_path / "program.py").write_text(body)
    done = subprocess.run([sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode != 0
    assert "if __name__ == '__main__'" in done.stderr


# ---- progress --------------------------------------------------------------------------------------------------------


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_is_a_bar_on_a_terminal_and_a_line_now_and_then_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parallel, "EVERY", 0.02)

    def told(stream: io.StringIO, *, shown: bool = True) -> str:
        monkeypatch.setattr(sys, "stderr", stream)
        for _ in progress_bar(range(4), desc="walks", unit="walk", progress=shown):
            time.sleep(0.03)
        return stream.getvalue()

    assert told(Terminal(), shown=False) == told(io.StringIO(), shown=False) == ""
    assert "\rwalks: 100%|" in told(Terminal())
    lines = told(io.StringIO()).strip("\r").splitlines()
    assert 1 <= len(lines) <= 4
    for line in lines:
        assert re.fullmatch(r"walks: \d of 4 after 00:00, +[\d.]+ ?walk/s, 00:00 left", line)
