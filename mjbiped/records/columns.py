"""The columns of a walk's record: what every engine delivers, with widths, units and meanings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot


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
        optional: Whether an engine may leave it out of a row, where NaN then stands.
    """

    width: int
    unit: str
    meaning: str
    finite: bool = True
    since: int = 1
    parts: tuple[str, ...] = ()
    optional: bool = False


class Tables(NamedTuple):
    """The columns of both tables of a walk.

    Attributes:
        samples: One row at a time; `controller_states` comes beside them, a column per state of the controller.
        touchdowns: One row per support transfer, the columns in their order in a row.
    """

    samples: Mapping[str, Column]
    touchdowns: Mapping[str, Column]


@cache
def tables_of(robot: type[Robot]) -> Tables:
    """The columns that walks of a kind of robot have."""
    angles, joints, places = robot.angles, robot.joints, robot.places
    bent = "stance leg (from its foot to the hip), swing thigh and swing shank"
    legs = bent if robot.knees else "stance and swing leg"
    motors, both = ("ankle, hip and swing knee", "all") if robot.knees else ("ankle and hip", "both")
    units = ", ".join(["m", "m", *["rad"] * (len(places) - 2)])
    posture = "hip x, hip z, left and right leg from the vertical"
    if robot.knees:
        posture = "hip x, hip z, left and right thigh from the vertical, flexion of left and right knee"

    def of_angles(unit: str, meaning: str, **more: Any) -> Column:
        return Column(len(angles), unit, meaning, parts=angles, **more)

    qpos = Column(len(places), units, posture, parts=places)
    normal = "from the ground's normal under the stance foot"
    samples = {
        "time": Column(1, "s", "since the walk's start"),
        "q": of_angles("rad", f"{legs} {normal}"),
        "dq": of_angles("rad/s", "their rates"),
        "torque": Column(len(joints), "N m", f"{motors}, from now on", finite=False, parts=joints),
        "slope": Column(1, "rad", "of the ground under the stance foot"),
        "slope_estimate": Column(1, "rad", "the controller's; NaN where it has none", finite=False),
        "stance": Column(1, "", "0 left, 1 right"),
        "qpos": qpos,
    }
    touchdowns = {
        "time": Column(1, "s", "of the support transfer"),
        "qpos": qpos,
        "x": Column(1, "m", "position of the new stance foot"),
        "z": Column(1, "m", "its height"),
        "stance": Column(1, "", "the new stance leg, 0 left, 1 right"),
        "slope": Column(1, "rad", "of the ground under the new stance foot"),
        "q_before": of_angles("rad", f"{legs} in the old roles, from the old ground's normal"),
        "dq_before": of_angles("rad/s", "their rates just before the impact"),
        "q": of_angles("rad", f"{legs} in the new roles, from the new ground's normal"),
        "dq": of_angles("rad/s", "their rates just after the impact"),
        "work_absolute": Column(1, "J", f"since the start, the absolute work of {both} joints", finite=False),
        "work_net": Column(1, "J", "the same, with its sign", finite=False),
        "work_positive": Column(1, "J", "the same, positive work alone", finite=False),
        "slip": Column(1, "m", "greatest distance that the old stance foot slid along the ground"),
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
        "pressure_ahead": Column(
            1,
            "m",
            "where the ankle's torque asks for the centre of pressure at most, ahead of the old stance foot; minus "
            "infinity where it hardly bore anything",
            finite=False,
            since=4,
        ),
        "pressure_behind": Column(1, "m", "the same behind it", finite=False, since=4),
    }
    if robot.knees:
        own: dict[str, Any] = {"finite": False, "since": 3, "optional": True}  # of a motor at the stance knee
        samples["locked"] = Column(1, "", "1 where the swing knee has struck its stop and is locked")
        samples["stance_knee_torque"] = Column(
            1, "N m", "of the motor that keeps the stance knee from bending; NaN where it is locked", **own
        )
        strike = "just {} the knee strike; NaN without one"
        touchdowns |= {
            "knee_strike": Column(
                1, "s", "from the step's beginning to the knee strike; NaN without one", finite=False
            ),
            "knee_q": of_angles("rad", f"{legs} {strike.format('before')}", finite=False),
            "knee_dq_before": of_angles("rad/s", f"their rates {strike.format('before')}", finite=False),
            "knee_dq": of_angles("rad/s", f"their rates {strike.format('after')}", finite=False),
            "flexion": Column(1, "rad", "greatest flexion of the swing knee in the step that ends"),
            "stubs": Column(1, "", "how often the swing foot struck the ground in it, and did not come to stand"),
            "stance_knee_torque": Column(
                1, "N m", "greatest of the stance knee's motor in it; NaN where the knee is locked", **own
            ),
            "stance_knee_work": Column(
                1, "J", "since the start, absolute, of the stance knees' motor; NaN where they are locked", **own
            ),
        }
    return Tables(samples, touchdowns)


SAMPLES, TOUCHDOWNS = tables_of(Compass)
"""Columns of the compass biped's walks."""

WHOLE_NUMBERS = ("stance", "strikes", "locked")


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
