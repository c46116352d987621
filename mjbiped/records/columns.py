"""Columns of a walk's record, with widths, units and meanings; all engines write the same ones."""

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
        width: Numbers per row.
        unit: Unit for axes and headings; empty for a pure number.
        meaning: Description in one line.
        finite: Whether the numbers must be finite. Quantities that depend on the controller's output need not be: a
            walk with an infinite torque diverges, and its record shows the torque.
        since: First version of the record's format with this column; older records are filled with NaN.
        parts: Names of the numbers in a row; exported flat tables have a column `name_part` for each.
        optional: Whether an engine may omit the column, which is then NaN.
    """

    width: int
    unit: str
    meaning: str
    finite: bool = True
    since: int = 1
    parts: tuple[str, ...] = ()
    optional: bool = False

    @property
    def row(self) -> tuple[int, ...]:
        """Shape of the numbers in a row: () for a single number without a name, else (width,)."""
        return (self.width,) if self.parts or self.width > 1 else ()


class Tables(NamedTuple):
    """Columns of both tables of a walk.

    Attributes:
        samples: Columns of the samples, without the controller's states, which records keep in `controller_states`.
        touchdowns: Columns of the touchdowns, in their order in a row.
    """

    samples: Mapping[str, Column]
    touchdowns: Mapping[str, Column]


@cache
def tables_of(robot: type[Robot]) -> Tables:
    """Columns of the records of a kind of robot."""
    return Tables(_samples_of(robot), _touchdowns_of(robot))


# columns of the stance knee's motor; without one the knee is locked
_MOTOR: Mapping[str, Any] = {"since": 3, "optional": True}


def _of_angles(robot: type[Robot], unit: str, meaning: str, **more: Any) -> Column:
    return Column(len(robot.angles), unit, meaning, parts=robot.angles, **more)


def _from_controller(unit: str, meaning: str, **more: Any) -> Column:
    return Column(1, unit, meaning, finite=False, **more)


def _posture_of(robot: type[Robot]) -> Column:
    units = ", ".join(["m", "m", *["rad"] * (len(robot.places) - 2)])
    return Column(len(robot.places), units, "posture: hip, legs from the vertical, flexions", parts=robot.places)


def _samples_of(robot: type[Robot]) -> dict[str, Column]:
    samples = {
        "time": Column(1, "s", "time since the start of the walk"),
        "q": _of_angles(robot, "rad", "angles from the ground's normal under the stance foot"),
        "dq": _of_angles(robot, "rad/s", "rates of the angles"),
        "torque": Column(len(robot.joints), "N m", "joint torques from now on", finite=False, parts=robot.joints),
        "ankle_asked": _from_controller("N m", "ankle torque that the law asks for; a sole transmits less", since=6),
        "slope": Column(1, "rad", "slope of the ground under the stance foot"),
        "slope_estimate": _from_controller("rad", "slope that the controller estimates; NaN if it makes no estimate"),
        "stance": Column(1, "", "number of the stance leg; of a biped 0 left, 1 right"),
        "qpos": _posture_of(robot),
    }
    if "knee" in robot.joints:
        samples["locked"] = Column(1, "", "1 where the swing knee has struck its stop and is locked")
        samples["stance_knee_torque"] = _from_controller(
            "N m", "torque of the motor that holds the stance knee; NaN where the knee is locked", **_MOTOR
        )
    return samples


def _touchdowns_of(robot: type[Robot]) -> dict[str, Column]:
    touchdowns = {
        "time": Column(1, "s", "time of the support transfer"),
        "qpos": _posture_of(robot),
        "x": Column(1, "m", "position of the new stance foot"),
        "z": Column(1, "m", "height of the new stance foot"),
        "stance": Column(1, "", "number of the new stance leg; of a biped 0 left, 1 right"),
        "slope": Column(1, "rad", "slope of the ground under the new stance foot"),
        "q_before": _of_angles(robot, "rad", "angles in the old roles, from the normal of the old ground"),
        "dq_before": _of_angles(robot, "rad/s", "rates in the old roles, just before the impact"),
        "q": _of_angles(robot, "rad", "angles in the new roles, from the normal of the new ground"),
        "dq": _of_angles(robot, "rad/s", "rates in the new roles, just after the impact"),
        "work_absolute": _from_controller("J", "absolute work of all joints since the start"),
        "work_net": _from_controller("J", "net work of all joints since the start"),
        "work_positive": _from_controller("J", "positive work of all joints since the start"),
        "slip": Column(1, "m", "greatest distance that the old stance foot slid along the ground"),
        "penetration": Column(1, "m", "deepest contact of the step that ends"),
        "friction": Column(1, "", "greatest |F_t| / F_n of the old stance foot"),
        "strikes": Column(1, "", "1 where the swing foot struck a vertical face"),
        "slope_estimate_before": _from_controller("rad", "slope estimate at the end of the step, before its update"),
        "slope_estimate": _from_controller("rad", "slope estimate after its update"),
        "normal_force": _from_controller(
            "N", "least normal force on the old stance foot; below zero the ground would have to pull", since=2
        ),
        "pressure_ahead": _from_controller(
            "m", "farthest centre of pressure ahead of the old stance foot; -inf where it hardly bore load", since=4
        ),
        "pressure_behind": _from_controller(
            "m", "farthest centre of pressure behind the old stance foot; -inf where it hardly bore load", since=4
        ),
        "sole_bound_time": _from_controller(
            "s", "time since the start in which the sole did not transmit the ankle torque asked for", since=6
        ),
        "contact_force": _from_controller(
            "N", "greatest normal force of all contacts, averaged over 5 ms, without touchdowns", since=7, optional=True
        ),
    }
    if "knee" in robot.joints:
        touchdowns |= {
            "knee_strike": _from_controller("s", "time from the start of the step to the knee strike; NaN without one"),
            "knee_q": _of_angles(robot, "rad", "angles at the knee strike; NaN without one", finite=False),
            "knee_dq_before": _of_angles(
                robot, "rad/s", "rates just before the knee strike; NaN without one", finite=False
            ),
            "knee_dq": _of_angles(robot, "rad/s", "rates just after the knee strike; NaN without one", finite=False),
            "flexion": Column(1, "rad", "greatest flexion of the swing knee in the step that ends"),
            "stubs": Column(1, "", "number of times that the swing foot struck the ground and did not take the load"),
            "stance_knee_torque": _from_controller(
                "N m", "greatest torque of the stance knee's motor in the step that ends", **_MOTOR
            ),
            "stance_knee_work": _from_controller(
                "J", "absolute work of the stance knees' motor since the start", **_MOTOR
            ),
        }
    if "left_foot" in robot.places:
        touchdowns |= {
            "tipped": Column(1, "rad", "greatest angle by which the old stance foot tipped in the step that ends"),
            "one_sided": Column(
                1, "s", "time in the step that ends in which the ground bore the old stance foot on one side alone"
            ),
            "slap": Column(1, "s", "time from the new stance foot's first contact until heel and toe were down"),
            "support_behind": Column(1, "m", "distance behind its ankle at which the ground bears the new stance foot"),
            "support_ahead": Column(1, "m", "distance ahead of its ankle at which it does"),
            "intrusion": _from_controller(
                "m",
                "height of an edge of the ground over the line from heel to toe of the new stance foot",
                since=7,
                optional=True,
            ),
        }
    return touchdowns


SAMPLES, TOUCHDOWNS = tables_of(Compass)
"""Columns of the records of the compass biped."""

WHOLE_NUMBERS = ("stance", "strikes", "locked")


def width(columns: Mapping[str, Column]) -> int:
    """Numbers in one row of a table."""
    return sum(column.width for column in columns.values())


def whole_rows(columns: Mapping[str, Column], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return those of a table's rows in which all numbers that must be finite are; more numbers may follow in a row."""
    finite = np.repeat([column.finite for column in columns.values()], [column.width for column in columns.values()])
    whole: NDArray[np.float64] = rows[np.isfinite(rows[:, : len(finite)][:, finite]).all(axis=1)]
    return whole


def index_of(columns: Mapping[str, Column], name: str) -> int:
    """Index of a column's first number in a row."""
    return sum(columns[earlier].width for earlier in list(columns)[: list(columns).index(name)])


def split(
    columns: Mapping[str, Column], rows: Sequence[Sequence[float]] | NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Split rows into one array per column, of shape `(rows, *column.row)`.

    Args:
        columns: Columns of a row, in their order.
        rows: Rows of `width(columns)` numbers each.
    """
    table = np.asarray(rows, dtype=np.float64).reshape(len(rows), width(columns))
    arrays: dict[str, NDArray[np.float64]] = {}
    for name, column in columns.items():
        first = index_of(columns, name)
        part = table[:, first : first + column.width] if column.row else table[:, first]
        arrays[name] = part.astype(np.int64 if name in WHOLE_NUMBERS else np.float64)
    return arrays
