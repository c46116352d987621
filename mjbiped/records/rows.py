"""Writes the rows of a walk's record, for every engine: in plain Python, or as part of compiled code.

The arguments are the columns of `mjbiped.records.columns` by their names; what several numbers of a row hold is a
tuple of them. Optional columns may be left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, Column, tables_of, width
from mjbiped.robots.kneed import KneedBiped

SAMPLED = width(SAMPLES)
"""Floats of a sample; the controller's integrated states stand behind them."""

TOUCHED = width(TOUCHDOWNS)
"""Floats of a touchdown."""


def _writer(name: str, columns: Mapping[str, Column]) -> Callable[..., None]:
    """The function (row, first, *columns) that fills a row from the index `first` on.

    It is written out as Python source, without loops: so Numba compiles it, although columns differ in their widths.
    """
    numbers = [
        f"{column}[{place}]" if of.width > 1 else column for column, of in columns.items() for place in range(of.width)
    ]
    arguments = [f"{column}=nan" if of.optional else column for column, of in columns.items()]
    source = [
        f"def {name}(row, first, {', '.join(arguments)}):",
        *(f"    row[first + {index}] = {number}" for index, number in enumerate(numbers)),
    ]
    space: dict[str, Any] = {"__name__": __name__, "nan": math.nan}
    exec("\n".join(source), space)
    writer: Callable[..., None] = space[name]
    return writer


write_sample = _writer("write_sample", SAMPLES)
write_touchdown = _writer("write_touchdown", TOUCHDOWNS)

_KNEES = tables_of(KneedBiped)
write_kneed_sample = _writer("write_kneed_sample", _KNEES.samples)
write_kneed_touchdown = _writer("write_kneed_touchdown", _KNEES.touchdowns)
KNEED_SAMPLED = width(_KNEES.samples)
"""Floats of a sample of a robot with knees; the controller's integrated states stand behind them."""
