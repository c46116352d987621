"""The tables that the site makes of the code."""

from __future__ import annotations

import sys

import pytest
from documentation import ROOT

from mjbiped.records import columns


def test_they_have_every_column_and_range(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import lookups  # type: ignore[import-not-found]

    for name in ("samples", "touchdowns"):
        heads, *rows = getattr(lookups, name)()
        assert {len(row) for row in rows} == {len(heads)}
        assert {f"`{column}`" for column in getattr(columns, name.upper())} <= {row[0] for row in rows}
    assert ["`timestep`", "from 1e-06 to 0.004 s"] in lookups.limits()
    del sys.modules["lookups"]
