"""The table behind the report: a row for each walk, with numbers of six digits."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.grounds import Place
from mjbiped.reproduction.traces import TRACES

LENGTHS = (20, 45, 60, 100)
"""Numbers of steps after which c_mt is taken, from one walk."""

COSTS = {
    f"{kind}_{'end' if steps is None else steps}": (kind, steps) for kind in WORK_KINDS for steps in (*LENGTHS, None)
}
"""Columns of c_mt: the kind of work and the number of steps; None: up to the last touchdown."""

MEASURES = ("steps", "place", "ankle", "hip", "friction", "least_force", "strikes", "begun", "ended", "rms", "jump")
TEXTS = ("part", "ground", "pattern", "engine", "method", "slope_source", "gains", "update", "outcome", "error")
_COUNTS = ("steps", "strikes")
COLUMNS = (
    "part", "ground", "pattern", "first", "engine", "method", "delay", "slope_source", "gains", "adaptation_gain",
    "update", "start_estimate", "outcome", *MEASURES, "error", *COSTS, *TRACES,
)  # fmt: skip
_DIGITS = 6  # that tables keep


class Row(SimpleNamespace):
    """A walk and its measures, an attribute for each of `COLUMNS`. Missing numbers are NaN.

    Attributes:
        part: Part of the report that needs it, "table 2", "table 3", "figure 5" and so on.
        ground: The paper's name of the ground, or ours.
        pattern: Pattern in which Table II's ground was read.
        first: Position of its first change, m.
        engine: "mujoco" or "hybrid".
        method: The paper's name of the controller.
        delay: zeta; None without re-planning.
        slope_source: Slope source of a comparison controller.
        gains: Gains of a comparison controller, in words.
        adaptation_gain: gamma; NaN for controllers without one.
        update: Whether the estimate is updated (27), "yes", "no", or empty.
        start_estimate: Slope that the controller estimates, or is told, at the start, degrees; NaN for those without.
        outcome: Outcome of the walk; "failed" where an error ended it, empty where there is no walk.
        steps: Number of touchdowns.
        place: Position x of the hip at the end, m.
        ankle: Greatest |torque| of the ankle, N m.
        hip: Greatest |torque| of the hip, N m.
        friction: Greatest |F_t|/F_n asked of a stance foot.
        least_force: Least normal force of the ground on a stance foot, weights; below zero it would have to pull.
        strikes: Number of times that a swing foot struck a riser.
        begun: Greatest error of the slope estimate at a step's beginning, degrees.
        ended: Greatest error of the slope estimate at a step's end, degrees.
        rms: Root mean square of the errors at the steps' ends, degrees.
        jump: Greatest change of the size of the error at a touchdown, degrees.
        error: Text of the error that ended the walk.
        absolute_20: c_mt of absolute work after 20 steps; so for all of `COSTS`.
        trace_settled: See `mjbiped.reproduction.traces.TRACES`; all NaN where no record was kept.
    """

    @property
    def place_read(self) -> Place:
        """Table II's ground, its pattern and its first change, as this walk's was read."""
        return self.ground, self.pattern, self.first

    @property
    def finished(self) -> bool:
        """Whether the robot walked to the planned end."""
        return bool(self.outcome == "finished")

    @property
    def pulls(self) -> bool:
        """Whether the ground would have to pull at the stance foot."""
        return bool(self.least_force < 0.0)

    @property
    def torque(self) -> float:
        """Greatest torque of either joint, N m."""
        return float(max(self.ankle, self.hip))


def row_of(columns: Mapping[str, object]) -> Row:
    """Make a row from texts or numbers by column; what is missing is empty, 0, NaN, or None for zeta."""
    return Row(**{name: _read(name, columns.get(name)) for name in COLUMNS})


def _read(name: str, value: Any) -> object:
    if name in TEXTS:
        return value or ""
    if name in _COUNTS:
        return int(value or 0)
    if value is None or value == "":
        return None if name == "delay" else math.nan
    return float(f"{float(value):.{_DIGITS}g}")


NO_WALK = row_of({})


def select(rows: Iterable[Row], **wanted: object) -> list[Row]:
    """Select the rows whose attributes have the values wanted."""
    return [row for row in rows if all(getattr(row, name) == value for name, value in wanted.items())]


def find(rows: Iterable[Row], **wanted: object) -> Row:
    """Find the first row whose attributes have the values wanted; `NO_WALK` where there is none."""
    return next(iter(select(rows, **wanted)), NO_WALK)


def write_rows(rows: Iterable[Row]) -> str:
    """Write rows as CSV with headings; an empty cell is a number that does not exist."""
    lines = ([getattr(row, name) for name in COLUMNS] for row in rows)
    return as_csv(COLUMNS, (("" if value != value else value for value in line) for line in lines))


def as_csv(headings: Sequence[str], lines: Iterable[Iterable[object]]) -> str:
    """Write a table as CSV with headings."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([headings, *lines])
    return text.getvalue()


def read_rows(text: str) -> list[Row]:
    """Read the rows that `write_rows` wrote."""
    return [row_of(columns) for columns in csv.DictReader(io.StringIO(text))]
