"""Docstrings reach Sphinx in its own markup."""

from __future__ import annotations

import importlib.util
from types import ModuleType

import pytest
from documentation import ROOT


@pytest.fixture(scope="module")
def markdown() -> ModuleType:
    """The module as docs/conf.py has it, which is no package's."""
    spec = importlib.util.spec_from_file_location("markdown_docstrings", ROOT / "docs" / "markdown_docstrings.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_table_heading_and_code(markdown: ModuleType) -> None:
    lines = [
        "Text.",
        "",
        "## Part",
        "  | a | b |",
        "  |---|---|",
        r"  | 1 | \|x\| |",
        "  | 2 | |",
        "```python",
        "f()",
        "```",
    ]
    assert [line for line in markdown.as_restructured_text(lines) if line] == [
        "Text.",
        ".. rubric:: Part",
        "  .. list-table::",
        "     :header-rows: 1",
        "     * - a",
        "       - b",
        "     * - 1",
        r"       - \|x\|",
        "     * - 2",
        "       -",
        ".. code-block:: python",
        "   f()",
    ]


def test_other_lines_stay(markdown: ModuleType) -> None:
    lines = ["One `|a|` and", "", "Args:", "    x: y | z.", ""]
    assert markdown.as_restructured_text(lines) == lines
