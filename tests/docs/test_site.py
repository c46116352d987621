"""What the site makes of the code: tables of columns and ranges, and docstrings in its own markup."""

import importlib
from types import ModuleType

import pytest
from documentation import ROOT

from mjbiped.records import columns


def extension(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A module of docs/, which is no package."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    return importlib.import_module(name)


def test_tables_have_every_column_and_range(monkeypatch: pytest.MonkeyPatch) -> None:
    lookups = extension("lookups", monkeypatch)
    for name in ("samples", "touchdowns"):
        heads, *rows = getattr(lookups, name)()
        assert {len(row) for row in rows} == {len(heads)}
        assert {f"`{column}`" for column in getattr(columns, name.upper())} <= {row[0] for row in rows}
    assert ["`timestep`", "from 1e-06 to 0.004 s"] in lookups.limits()


MARKDOWN = r"""Text `|a|`.
## Part
  | a | b |
  |---|---|
  | \|x\| | |
```python
f()
```"""
RESTRUCTURED = r"""Text `|a|`.
.. rubric:: Part
  .. list-table::
     :header-rows: 1
     * - a
       - b
     * - \|x\|
       -
.. code-block:: python
   f()"""


def test_docstrings_in_markdown(monkeypatch: pytest.MonkeyPatch) -> None:
    found = extension("markdown_docstrings", monkeypatch).as_restructured_text(MARKDOWN.splitlines())
    assert [line for line in found if line] == RESTRUCTURED.splitlines()
