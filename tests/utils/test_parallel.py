"""Long work: workers do it, none is left behind; its progress is a bar on a terminal, and lines elsewhere."""

from __future__ import annotations

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
from types import SimpleNamespace

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


HEAD = "from mjbiped.utils.parallel import processes\n"
BODY = "with processes(1) as pool:\n    print(pool.submit(abs, -3).result())\n"
INDENTED = "".join(f"    {line}\n" for line in BODY.splitlines())

PROGRAMS = {
    "bare": (HEAD + BODY, False),
    "guarded": (HEAD + 'if __name__ == "__main__":\n' + INDENTED, True),
}


@pytest.mark.parametrize(
    ("text", "runs"),
    [pytest.param(*case, id=name, marks=() if name == "bare" else pytest.mark.slow) for name, case in PROGRAMS.items()],
)
def test_a_program_without_a_guard_is_told(text: str, runs: bool, tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(text)
    done = subprocess.run([sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.stdout == ("3\n" if runs else ""), done.stderr
    assert (done.returncode == 0) == runs
    assert runs or "if __name__ == '__main__'" in done.stderr


# ---- progress --------------------------------------------------------------------------------------------------------


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def told(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO, *, shown: bool = True, pause: float = 0.0) -> str:
    monkeypatch.setattr(sys, "stderr", stream)
    for _ in progress_bar(range(4), desc="walks", unit="walk", progress=shown):
        time.sleep(pause)
    return stream.getvalue()


def test_a_bar_nobody_asked_for_is_hidden_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parallel, "EVERY", 0.0)
    for stream in (Terminal(), io.StringIO()):
        assert told(monkeypatch, stream, shown=False) == ""


def test_on_a_terminal_it_is_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "\rwalks: 100%|" in told(monkeypatch, Terminal())


def test_elsewhere_it_is_a_line_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parallel, "EVERY", 0.02)
    lines = told(monkeypatch, io.StringIO(), pause=0.03).strip("\r").splitlines()
    assert 1 <= len(lines) <= 4
    for line in lines:
        assert re.fullmatch(r"walks: \d of 4 after 00:00, +[\d.]+ ?walk/s, 00:00 left", line)


@pytest.mark.parametrize(
    ("shell", "notebook"),
    [
        (SimpleNamespace(config={"IPKernelApp": {}}), True),
        (SimpleNamespace(config={"TerminalIPythonApp": {}}), False),
        (None, False),
    ],
)
def test_a_notebook_is_told_by_its_kernel(shell: object, notebook: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    assert parallel.in_notebook() == notebook
    monkeypatch.delitem(sys.modules, "IPython")
    assert not parallel.in_notebook()
