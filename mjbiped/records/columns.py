"""Tables of a walk's record: names, shapes, units and meanings of their columns, and the recorder that fills them.

Engines, files, exports and docs/tables/columns.md take the columns from here. A row is a structured type of NumPy,
`row_type`; engines write the numbers of a row in the same order as floats. Flat tables have one number per column.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Array, Robot
from mjbiped.robots.shape import HIP

if TYPE_CHECKING:
    from mjbiped.records.measures import Summary
    from mjbiped.records.record import Walk

Table = Mapping[str, NDArray[Any]]  # with a row for each sample or touchdown, by the names of the columns

STATE = "controller_state"  # prefix of the controller's integrated states in flat tables, numbered from 0

_TIME = 0  # index of the time in a row of either table
_SAME = 1e-9  # s: a sample this near to a touchdown is of its instant


class Column(NamedTuple):
    """A named quantity of a table.

    Attributes:
        unit: Unit for axes and headings; empty for a pure number. Numbers of a row with different units have a comma
            between their units.
        meaning: Description in one line.
        parts: Names of the numbers in a row, `name_part` in flat tables; empty for a single number.
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
    """Columns of both tables of a walk; records keep the controller's states in `controller_states` of the samples."""

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
    units = ", ".join("m" if place in HIP else "rad" for place in robot.places)
    return Column(units, "posture: hip, legs from the vertical, flexions", robot.places)


def _samples_of(robot: type[Robot]) -> Columns:
    samples = {
        "time": Column("s", "time since the start of the walk"),
        "q": Column("rad", "angles from the ground's normal under the stance foot", robot.angles),
        "dq": Column("rad/s", "rates of the angles", robot.angles),
        "torque": _free("N m", "joint torques just after this time", robot.joints),
        "ankle_asked": _free("N m", "ankle torque that the law asks for; a sole transmits less"),
        "slope": Column("rad", "slope of the ground under the stance foot"),
        "slope_estimate": _free("rad", "slope that the controller estimates; NaN if it makes no estimate"),
        "stance": _flag("number of the stance leg; of a biped 0 left, 1 right"),
        "qpos": _posture_of(robot),
    }
    if "roll" in robot.angles:
        samples["lateral_slope"] = Column("rad", "slope of the ground to the left")
        samples["lateral_estimate"] = _free("rad", "that slope as the controller estimates it")
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
    if "roll" in robot.angles:
        touchdowns |= {
            "y": Column("m", "lateral position of the new stance foot, positive to the left"),
            "lateral_slope": Column("rad", "slope of the ground under the new stance foot, to the left"),
            "lateral_estimate_before": _free("rad", "estimate of the lateral slope before its update"),
            "lateral_estimate": _free("rad", "estimate of the lateral slope after its update"),
            "roll_work": _free("J", "absolute work of the motor about the heading since the start"),
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


def row_type(columns: Columns) -> np.dtype[np.void]:
    """Structured type of a table's row, all floats; a column with named parts is an array in it."""
    return np.dtype([(name, np.float64, (each.width,) if each.parts else ()) for name, each in columns.items()])


def width(columns: Columns) -> int:
    """Numbers in one row of a table."""
    return row_type(columns).itemsize // 8


def index_of(columns: Columns, name: str) -> int:
    """Index of a column's first number in a row."""
    return int(row_type(columns).fields[name][1]) // 8  # type: ignore[index]  # a structured type has fields


def split(columns: Columns, rows: ArrayLike) -> dict[str, NDArray[Any]]:
    """Split rows of `width(columns)` floats into an array for each column, whole numbers where the column has them."""
    table = np.asarray(rows, dtype=np.float64).reshape(-1, width(columns))
    named = np.ascontiguousarray(table).view(row_type(columns))[:, 0]
    return {name: named[name].astype(np.int64 if each.whole else np.float64) for name, each in columns.items()}


def flat_samples(walk: Walk) -> Table:
    """Return the samples, one number per column: `step`, `time`, `q_stance`, ..., `controller_state_0`, ...

    `step` counts from 1; a sample at the instant of a touchdown belongs to the step whose stance leg it has.
    """
    time, touched = walk.samples["time"], walk.touchdowns
    ended = np.searchsorted(touched["time"], time - _SAME)
    following = np.append(touched["time"], np.inf)[ended]
    begun = (np.abs(following - time) <= _SAME) & (np.append(touched["stance"], -1)[ended] == walk.samples["stance"])
    states = {f"{STATE}_{number}": state for number, state in enumerate(walk.samples["controller_states"].T)}
    return _flat(tables_of(type(walk.robot)).samples, walk.samples, 1 + ended + begun) | states


def flat_touchdowns(walk: Walk) -> Table:
    """Return the touchdowns, one number per column; `step` is the step that the touchdown ends, from 1 on."""
    return _flat(tables_of(type(walk.robot)).touchdowns, walk.touchdowns, np.arange(1, walk.steps + 1))


def _flat(columns: Columns, table: Table, steps: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    numbers = (row for name in columns for row in np.atleast_2d(table[name].T))
    return dict(zip(units_of(columns), (steps, *numbers), strict=True))


def units_of(columns: Columns) -> dict[str, str]:
    """Return the unit of each flat column; empty for a pure number."""
    units = {"step": ""}
    for name, column in columns.items():
        of_parts = column.unit.split(", ") if ", " in column.unit else [column.unit] * column.width
        units |= zip([f"{name}_{part}" for part in column.parts] or [name], of_parts, strict=True)
    return units


def attributes(units: Mapping[str, str]) -> dict[str, str]:
    """Return the metadata of a Parquet file from which pandas reads units by column, `frame.attrs["units"]`."""
    return {"PANDAS_ATTRS": json.dumps({"units": dict(units)})}


Cancellation: TypeAlias = Callable[[], None]
"""Function that is called at times during a walk, and may raise an exception to stop it."""


def _new(columns: Columns, rows: Array, taken: Sequence[Array]) -> Array:
    """Return a copy of the rows that are later than the last row that was taken, and hold a motion of numbers."""
    finite = np.repeat([column.finite for column in columns.values()], [column.width for column in columns.values()])
    rows = rows[np.isfinite(rows[:, : len(finite)][:, finite]).all(axis=1)]  # the controller's states follow in a row
    return rows[rows[:, _TIME] > taken[-1][-1, _TIME]] if taken else rows


def never_cancelled() -> None:
    """Never cancel a walk."""


class Recorder:
    """Samples and touchdowns of a walk so far in any engine, whose tables may be read at any time.

    Attributes:
        cancellation: Function that the engine calls each time before the walk goes on.
        summary: Summary that takes the touchdowns, which are then not kept; None where they are.
    """

    def __init__(
        self,
        *,
        robot: type[Robot] = Compass,
        keep_samples: bool = True,
        summary: Summary | None = None,
        cancellation: Cancellation = never_cancelled,
    ) -> None:
        """Begin an empty recording of a kind of robot; unless all samples are kept, only the last ones are."""
        self.cancellation, self.summary = cancellation, summary
        self._keep_samples, self._columns = keep_samples, tables_of(robot)
        self._rows: list[Array] = []
        self._samples: list[Array] = []

    def add(self, rows: Array, samples: Array | None = None) -> None:
        """Add copies of rows to both tables.

        Rows that were added before are skipped: Ctrl-C may come before an engine notes that its rows were added. So are
        rows with a motion that is not finite, with which a walk that diverges may end; no record may hold such rows.
        Rows of samples have the controller's states behind the columns of `SAMPLES`.
        """
        rows = _new(self._columns.touchdowns, rows, self._rows)
        if len(rows) and self.summary is not None:
            self.summary.take(split(self._columns.touchdowns, rows))
        elif len(rows):
            self._rows.append(rows)
        if samples is not None and len(samples := _new(self._columns.samples, samples, self._samples)):
            if not self._keep_samples:
                self._samples.clear()
            self._samples.append(samples)

    @property
    def end(self) -> tuple[float, float]:
        """Time (s) and hip x (m) of the last sample; zeros without one."""
        if not self._samples:
            return 0.0, 0.0
        last = self._samples[-1][-1]
        return float(last[_TIME]), float(last[index_of(self._columns.samples, "qpos")])

    @property
    def steps(self) -> int:
        """Number of touchdowns."""
        return self.summary.steps if self.summary is not None else sum(map(len, self._rows))

    def samples(self) -> dict[str, NDArray[Any]]:
        """Return the samples so far, with the columns of `SAMPLES`."""
        sampled = width(self._columns.samples)
        table = np.concatenate(self._samples) if self._samples else np.empty((0, sampled))
        if not self._keep_samples:
            table = table[:0]
        return {**split(self._columns.samples, table[:, :sampled]), "controller_states": table[:, sampled:].copy()}

    def touchdowns(self) -> dict[str, NDArray[Any]]:
        """Return the touchdowns so far, with the columns of `TOUCHDOWNS`."""
        return split(self._columns.touchdowns, np.concatenate(self._rows) if self._rows else [])
