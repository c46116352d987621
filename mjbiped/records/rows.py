"""Functions that write the rows of a walk's record, in plain Python or as part of compiled code.

Their arguments are the columns of `mjbiped.records.columns` by name; a column of several numbers is a tuple. Optional
columns may be left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from mjbiped.records.columns import Column, tables_of, width
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot


class Rows(NamedTuple):
    """Writers of the rows of a kind of robot.

    Both writers are functions (row, first, **columns) that fill a row from the index `first` on. They take the columns
    of every kind of robot by name, and leave out those that this kind does not have: so one call serves all robots.

    Attributes:
        write_sample: Writes a sample.
        write_touchdown: Writes a touchdown.
        sampled: Floats of a sample; the controller's integrated states stand behind them.
        touched: Floats of a touchdown.
    """

    write_sample: Callable[..., None]
    write_touchdown: Callable[..., None]
    sampled: int
    touched: int


@cache
def rows_of(kind: type[Robot]) -> Rows:
    """Return the writers of the rows of a kind of robot."""
    samples, touchdowns = tables_of(kind)
    return Rows(
        _writer("write_sample", samples, [tables_of(other).samples for other in KINDS.values()]),
        _writer("write_touchdown", touchdowns, [tables_of(other).touchdowns for other in KINDS.values()]),
        width(samples),
        width(touchdowns),
    )


def _writer(name: str, columns: Mapping[str, Column], of_all: Sequence[Mapping[str, Column]]) -> Callable[..., None]:
    """Make the function (row, first, **columns) that fills a row from the index `first` on.

    It is written out as Python source, without loops: so Numba compiles it, although columns differ in their widths.

    Args:
        name: Name of the function.
        columns: Columns of the row.
        of_all: Columns of all kinds of robot; those that the row does not have are ignored.
    """
    numbers = [
        f"{column}[{place}]" if of.row else column for column, of in columns.items() for place in range(of.width)
    ]
    arguments = [column for column, of in columns.items() if not of.optional]
    arguments += [f"{column}=nan" for column, of in columns.items() if of.optional]
    arguments += [
        f"{column}=nan" for column in sorted({column for others in of_all for column in others} - columns.keys())
    ]
    source = [
        f"def {name}(row, first, {', '.join(arguments)}):",
        *(f"    row[first + {index}] = {number}" for index, number in enumerate(numbers)),
    ]
    space: dict[str, Any] = {"__name__": __name__, "nan": math.nan}
    exec("\n".join(source), space)
    writer: Callable[..., None] = space[name]
    return writer
