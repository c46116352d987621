"""Where a progress bar is hidden."""

import sys
from types import SimpleNamespace

import pytest

from mjbiped.utils.progress import hidden


def kernel(**config: object) -> SimpleNamespace:
    return SimpleNamespace(get_ipython=lambda: SimpleNamespace(config=config))


def test_a_bar_nobody_asked_for_is_hidden_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "IPython", kernel(IPKernelApp={}))
    assert hidden(False) is True


def test_outside_notebooks_tqdm_looks_whether_there_is_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: None))
    assert hidden(True) is None
    monkeypatch.setitem(sys.modules, "IPython", kernel(TerminalIPythonApp={}))
    assert hidden(True) is None
    monkeypatch.delitem(sys.modules, "IPython")
    assert hidden(True) is None


def test_in_a_notebook_it_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "IPython", kernel(IPKernelApp={}))
    assert hidden(True) is False
