"""Progress: a bar on a terminal and in a notebook, lines elsewhere, nothing where nobody asked for it."""

from __future__ import annotations

import io
import re
import sys
import time
from types import SimpleNamespace

import pytest

from mjbiped.utils import parallel as progress
from mjbiped.utils.parallel import in_notebook, progress_bar


def kernel(**config: object) -> SimpleNamespace:
    return SimpleNamespace(get_ipython=lambda: SimpleNamespace(config=config))


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def told(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO, *, shown: bool = True, pause: float = 0.0) -> str:
    monkeypatch.setattr(sys, "stderr", stream)
    for _ in progress_bar(range(4), desc="walks", unit="walk", progress=shown):
        time.sleep(pause)
    return stream.getvalue()


def test_a_bar_nobody_asked_for_is_hidden_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.0)
    for stream in (Terminal(), io.StringIO()):
        assert told(monkeypatch, stream, shown=False) == ""


def test_on_a_terminal_it_is_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "\rwalks: 100%|" in told(monkeypatch, Terminal())


def test_elsewhere_it_is_a_line_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.02)
    lines = told(monkeypatch, io.StringIO(), pause=0.03).strip("\r").splitlines()
    assert 1 <= len(lines) <= 4
    for line in lines:
        assert re.fullmatch(r"walks: \d of 4 after 00:00, +[\d.]+ ?walk/s, 00:00 left", line)


def test_a_line_says_how_far_the_work_is_when_it_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.02)
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    for done, _ in enumerate(progress_bar(range(5), desc="walks", unit="walk")):
        if done > 2:
            assert stream.getvalue().splitlines()[-1].strip("\r").startswith(f"walks: {done} of 5 after")
        time.sleep(0.03)
    assert "?" not in stream.getvalue()


def test_what_is_short_says_nothing_there(monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(monkeypatch, io.StringIO()) == ""


def test_a_notebook_is_told_by_its_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "IPython", kernel(IPKernelApp={}))
    assert in_notebook()
    monkeypatch.setitem(sys.modules, "IPython", kernel(TerminalIPythonApp={}))
    assert not in_notebook()
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: None))
    assert not in_notebook()
    monkeypatch.delitem(sys.modules, "IPython")
    assert not in_notebook()
