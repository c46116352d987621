"""The columns of a walk's record: what every engine delivers, with widths, units and meanings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Column(NamedTuple):
    """One named quantity of a table.

    Attributes:
        width: Numbers per row.
        unit: For axes and headings; empty where it has none.
        meaning: One line.
        finite: Whether no record holds anything but finite numbers here. What a controller gives, and what is made of
            it, need not be: a walk with such a torque diverges, and its record says by which.
        since: Version of the record's format in which it came; NaN in records of earlier ones.
        parts: What each number of a row is, where there are several: flat tables have a column `name_part` for each.
    """

    width: int
    unit: str
    meaning: str
    finite: bool = True
    since: int = 1
    parts: tuple[str, ...] = ()


_LEGS, _JOINTS = ("stance", "swing"), ("ankle", "hip")
_PLACES = ("hip_x", "hip_z", "left", "right")


SAMPLES: Mapping[str, Column] = {
    "time": Column(1, "s", "since the walk's start"),
    "q": Column(2, "rad", "stance and swing leg from the ground's normal under the stance foot", parts=_LEGS),
    "dq": Column(2, "rad/s", "their rates", parts=_LEGS),
    "torque": Column(2, "N m", "ankle and hip, from now on", finite=False, parts=_JOINTS),
    "slope": Column(1, "rad", "of the ground under the stance foot"),
    "slope_estimate": Column(1, "rad", "the controller's; NaN where it has none", finite=False),
    "stance": Column(1, "", "0 left, 1 right"),
    "qpos": Column(4, "m, m, rad, rad", "hip x, hip z, left and right leg from the vertical", parts=_PLACES),
}
"""Columns of the samples; `controller_states` comes beside them, one column per integrated state of the controller."""

TOUCHDOWNS: Mapping[str, Column] = {
    "time": Column(1, "s", "of the support transfer"),
    "qpos": Column(4, "m, m, rad, rad", "hip x, hip z, left and right leg from the vertical", parts=_PLACES),
    "x": Column(1, "m", "position of the new stance foot"),
    "z": Column(1, "m", "its height"),
    "stance": Column(1, "", "the new stance leg, 0 left, 1 right"),
    "slope": Column(1, "rad", "of the ground under the new stance foot"),
    "q_before": Column(2, "rad", "stance and swing leg in the old roles, from the old ground's normal", parts=_LEGS),
    "dq_before": Column(2, "rad/s", "their rates just before the impact", parts=_LEGS),
    "q": Column(2, "rad", "stance and swing leg in the new roles, from the new ground's normal", parts=_LEGS),
    "dq": Column(2, "rad/s", "their rates just after the impact", parts=_LEGS),
    "work_absolute": Column(1, "J", "since the start, the absolute work of both joints", finite=False),
    "work_net": Column(1, "J", "the same, with its sign", finite=False),
    "work_positive": Column(1, "J", "the same, positive work alone", finite=False),
    "slip": Column(
        1, "m", "greatest distance that the old stance foot slid along the ground (rolling on its radius is none)"
    ),
    "penetration": Column(1, "m", "deepest contact of the step that ends"),
    "friction": Column(1, "", "greatest |F_t| / F_n of the old stance foot"),
    "strikes": Column(1, "", "1 where the swing foot struck a vertical face"),
    "slope_estimate_before": Column(1, "rad", "the controller's estimate at the step's end", finite=False),
    "slope_estimate": Column(1, "rad", "the same after its update", finite=False),
    "normal_force": Column(
        1,
        "N",
        "least normal force of the ground on the old stance foot; below zero it would have to pull",
        finite=False,
        since=2,
    ),
}
"""Columns of the touchdowns, one row per support transfer, in their order in a row."""

WHOLE_NUMBERS = ("stance", "strikes")


def width(columns: Mapping[str, Column]) -> int:
    """Numbers in one row of a table."""
    return sum(column.width for column in columns.values())


def index_of(columns: Mapping[str, Column], name: str) -> int:
    """Index of a column's first number in a row."""
    return sum(columns[earlier].width for earlier in list(columns)[: list(columns).index(name)])


def split(
    columns: Mapping[str, Column], rows: Sequence[Sequence[float]] | NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Rows as one array per column, of shape (rows,) or (rows, width).

    Args:
        columns: What a row is made of.
        rows: Each of `width(columns)` numbers.
    """
    table = np.asarray(rows, dtype=np.float64).reshape(len(rows), width(columns))
    arrays: dict[str, NDArray[np.float64]] = {}
    first = 0
    for name, column in columns.items():
        part = table[:, first : first + column.width]
        arrays[name] = part.copy() if column.width > 1 else part[:, 0].copy()
        if name in WHOLE_NUMBERS:
            arrays[name] = arrays[name].astype(np.int64)
        first += column.width
    return arrays
