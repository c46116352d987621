"""Columns of a walk's record: names, shapes, units and meanings.

Engines, files, exports and docs/tables/columns.md take the columns from here. A row is a structured type of NumPy,
`row_type`, with 8 bytes for each number; engines write the numbers of a row in the same order as floats.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot


class Column(NamedTuple):
    """A named quantity of a table.

    Attributes:
        unit: Unit for axes and headings; empty for a pure number. Numbers of a row with different units have a comma
            between their units.
        meaning: Description in one line.
        parts: Names of the numbers in a row; exported flat tables have a column `name_part` for each. Empty for a
            single number.
        finite: Whether the numbers must be finite. Quantities that depend on the controller's output need not be: a
            walk with an infinite torque diverges, and its record shows the torque.
        whole: Whether the numbers are whole.
    """

    unit: str
    meaning: str
    parts: tuple[str, ...] = ()
    finite: bool = True
    whole: bool = False

    @property
    def width(self) -> int:
        """Numbers per row."""
        return max(len(self.parts), 1)


Columns = Mapping[str, Column]
"""Columns of a table by name, in their order in a row."""


class Tables(NamedTuple):
    """Columns of both tables of a walk.

    Attributes:
        samples: Columns of the samples, without the controller's states, which records keep in `controller_states`.
        touchdowns: Columns of the touchdowns.
    """

    samples: Columns
    touchdowns: Columns


@cache
def tables_of(robot: type[Robot]) -> Tables:
    """Columns of the records of a kind of robot."""
    return Tables(_samples_of(robot), _touchdowns_of(robot))


def _free(unit: str, meaning: str, parts: tuple[str, ...] = ()) -> Column:
    """Describe a quantity that need not be finite."""
    return Column(unit, meaning, parts, finite=False)


def _flag(meaning: str) -> Column:
    """Describe a whole number."""
    return Column("", meaning, whole=True)


def _posture_of(robot: type[Robot]) -> Column:
    units = ", ".join(["m", "m", *["rad"] * (len(robot.places) - 2)])
    return Column(units, "posture: hip, legs from the vertical, flexions", robot.places)


def _samples_of(robot: type[Robot]) -> Columns:
    samples = {
        "time": Column("s", "time since the start of the walk"),
        "q": Column("rad", "angles from the ground's normal under the stance foot", robot.angles),
        "dq": Column("rad/s", "rates of the angles", robot.angles),
        "torque": _free("N m", "joint torques from now on", robot.joints),
        "ankle_asked": _free("N m", "ankle torque that the law asks for; a sole transmits less"),
        "slope": Column("rad", "slope of the ground under the stance foot"),
        "slope_estimate": _free("rad", "slope that the controller estimates; NaN if it makes no estimate"),
        "stance": _flag("number of the stance leg; of a biped 0 left, 1 right"),
        "qpos": _posture_of(robot),
    }
    if "knee" in robot.joints:
        samples["locked"] = _flag("1 where the swing knee has struck its stop and is locked")
        samples["stance_knee_torque"] = _free(
            "N m", "torque of the motor that holds the stance knee; NaN where the knee is locked"
        )
    return samples


def _touchdowns_of(robot: type[Robot]) -> Columns:
    angles = robot.angles
    touchdowns = {
        "time": Column("s", "time of the support transfer"),
        "qpos": _posture_of(robot),
        "x": Column("m", "position of the new stance foot"),
        "z": Column("m", "height of the new stance foot"),
        "stance": _flag("number of the new stance leg; of a biped 0 left, 1 right"),
        "slope": Column("rad", "slope of the ground under the new stance foot"),
        "q_before": Column("rad", "angles in the old roles, from the normal of the old ground", angles),
        "dq_before": Column("rad/s", "rates in the old roles, just before the impact", angles),
        "q": Column("rad", "angles in the new roles, from the normal of the new ground", angles),
        "dq": Column("rad/s", "rates in the new roles, just after the impact", angles),
        "work_absolute": _free("J", "absolute work of all joints since the start"),
        "work_net": _free("J", "net work of all joints since the start"),
        "work_positive": _free("J", "positive work of all joints since the start"),
        "slip": Column("m", "greatest distance that the old stance foot slid along the ground"),
        "penetration": Column("m", "deepest contact of the step that ends"),
        "friction": Column("", "greatest |F_t| / F_n of the old stance foot"),
        "strikes": _flag("1 where the swing foot struck a vertical face"),
        "slope_estimate_before": _free("rad", "slope estimate at the end of the step, before its update"),
        "slope_estimate": _free("rad", "slope estimate after its update"),
        "normal_force": _free("N", "least normal force on the old stance foot; below 0 the ground would have to pull"),
        "pressure_ahead": _free("m", "farthest centre of pressure ahead of the old stance foot; -inf without load"),
        "pressure_behind": _free("m", "farthest centre of pressure behind the old stance foot; -inf without load"),
        "sole_bound_time": _free("s", "time since the start in which the sole transmitted less torque than asked for"),
        "contact_force": _free("N", "greatest normal force of all contacts, averaged over 5 ms, without touchdowns"),
    }
    if "knee" in robot.joints:
        touchdowns |= {
            "knee_strike": _free("s", "time from the start of the step to the knee strike; NaN without one"),
            "knee_q": _free("rad", "angles at the knee strike; NaN without one", angles),
            "knee_dq_before": _free("rad/s", "rates just before the knee strike; NaN without one", angles),
            "knee_dq": _free("rad/s", "rates just after the knee strike; NaN without one", angles),
            "flexion": Column("rad", "greatest flexion of the swing knee in the step that ends"),
            "stubs": Column("", "number of times that the swing foot struck the ground and did not take the load"),
            "stance_knee_torque": _free("N m", "greatest torque of the stance knee's motor in the step that ends"),
            "stance_knee_work": _free("J", "absolute work of the stance knees' motor since the start"),
        }
    if "left_foot" in robot.places:
        touchdowns |= {
            "tipped": Column("rad", "greatest angle by which the old stance foot tipped in the step that ends"),
            "one_sided": Column("s", "time in which the ground bore the old stance foot on one side alone"),
            "slap": Column("s", "time from the new stance foot's first contact until heel and toe were down"),
            "support_behind": Column("m", "distance behind its ankle at which the ground bears the new stance foot"),
            "support_ahead": Column("m", "distance ahead of its ankle at which the ground bears the new stance foot"),
            "intrusion": _free("m", "height of an edge over the line from heel to toe of the new stance foot"),
        }
    return touchdowns


SAMPLES, TOUCHDOWNS = tables_of(Compass)
"""Columns of the records of the compass biped."""


def row_type(columns: Columns) -> np.dtype[Any]:
    """Structured type of a table's row; a column with named parts is an array in it."""
    kinds = {name: np.int64 if column.whole else np.float64 for name, column in columns.items()}
    return np.dtype([(name, kinds[name], (len(each.parts),) if each.parts else ()) for name, each in columns.items()])


def width(columns: Columns) -> int:
    """Numbers in one row of a table."""
    return row_type(columns).itemsize // 8


def index_of(columns: Columns, name: str) -> int:
    """Index of a column's first number in a row."""
    before = list(columns).index(name)
    return sum([column.width for column in columns.values()][:before])


def whole_rows(columns: Columns, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return those of a table's rows in which all numbers that must be finite are; more numbers may follow in a row."""
    finite = np.repeat([column.finite for column in columns.values()], [column.width for column in columns.values()])
    whole: NDArray[np.float64] = rows[np.isfinite(rows[:, : len(finite)][:, finite]).all(axis=1)]
    return whole


def split(columns: Columns, rows: Sequence[Sequence[float]] | NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    """Split rows into one array per column.

    Args:
        columns: Columns of a row, in their order.
        rows: Rows of `width(columns)` numbers each.
    """
    table, kind = np.asarray(rows, dtype=np.float64).reshape(len(rows), width(columns)), row_type(columns)
    numbers = zip(
        columns, np.split(table, np.cumsum([column.width for column in columns.values()])[:-1], axis=1), strict=True
    )
    return {name: part.reshape(-1, *kind[name].shape).astype(kind[name].base) for name, part in numbers}
