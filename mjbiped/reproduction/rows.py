"""The table behind the report, with a row for each walk and numbers of six digits; and the entries that are walked."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from mjbiped.errors import RecordError, shown
from mjbiped.reproduction.cell import COSTS, Cell
from mjbiped.reproduction.grounds import Place
from mjbiped.reproduction.methods import gains_told
from mjbiped.reproduction.traces import Traces
from mjbiped.sweeps.cell import Row as Measured

_DIGITS = 6


@dataclass(frozen=True)
class Row:
    """A walk and its measures. Missing numbers are NaN.

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
        outcome: Outcome of the walk; "failed" where an error ended it.
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
        cost: c_mt by (kind, steps); None: to the last touchdown.
        traces: See `mjbiped.reproduction.traces.Traces`; all NaN where no record was kept.
        error: Text of the error that ended the walk.
    """

    part: str
    ground: str
    pattern: str
    first: float
    engine: str
    method: str
    delay: float | None
    slope_source: str
    gains: str
    adaptation_gain: float
    update: str
    start_estimate: float
    outcome: str
    steps: int
    place: float
    ankle: float
    hip: float
    friction: float
    least_force: float
    strikes: int
    begun: float
    ended: float
    rms: float
    jump: float
    cost: Mapping[tuple[str, int | None], float]
    traces: Traces
    error: str

    @property
    def place_read(self) -> Place:
        """Table II's ground, its pattern and its first change, as this walk's was read."""
        return self.ground, self.pattern, self.first

    @property
    def finished(self) -> bool:
        """Whether the robot walked to the planned end."""
        return self.outcome == "finished"

    @property
    def pulls(self) -> bool:
        """Whether the ground would have to pull at the stance foot."""
        return self.least_force < 0.0

    @property
    def torque(self) -> float:
        """Greatest torque of either joint, N m."""
        return max(self.ankle, self.hip)


@dataclass(frozen=True)
class Entry:
    """A cell and its role in the report.

    Attributes:
        part: "table 2", "blind", "fitted", "misjudged", "gravity", "table 3", "start" or "figure 5".
        ground: The ground's name.
        method: The paper's name of the controller.
        cell: The walk.
        pattern: Pattern in which Table II's ground was read.
        first: Position of its first change, m.
    """

    part: str
    ground: str
    method: str
    cell: Cell
    pattern: str = ""
    first: float = 0.0

    def row(self, measured: Measured, traces: Traces | None = None) -> Row:
        """Combine the entry with the measures of its finished cell, and those of its record where it keeps one."""
        law = self.cell.controller.describe()
        update = law.get("estimate_update")
        start = law.get("initial_slope_estimate", math.nan)
        columns = {
            **measured,
            **{name: getattr(self, name) for name in ("part", "ground", "pattern", "first", "method")},
            "engine": self.cell.engine,
            "delay": law.get("replanning_delay"),
            "slope_source": law.get("slope_source"),
            "gains": gains_told(law),
            "adaptation_gain": law.get("adaptation_gain"),
            "update": None if update is None else "yes" if update else "no",
            "start_estimate": math.degrees(start),
            "error": " ".join((measured["error"] or "").split()),
            **{_trace(name): value for name, value in (traces or Traces())._asdict().items()},
        }
        return _row({name: rounded(value) if isinstance(value, float) else value for name, value in columns.items()})


def select(rows: Iterable[Row], **wanted: object) -> list[Row]:
    """Select the rows whose attributes have the values wanted."""
    return [row for row in rows if all(getattr(row, name) == value for name, value in wanted.items())]


def write_rows(rows: Iterable[Row]) -> str:
    """Write rows as CSV with headings; an empty cell is a number that does not exist."""
    values = (
        (*(getattr(row, name) for name in _PLAIN), *(row.cost[key] for key in COSTS.values()), *row.traces)
        for row in rows
    )
    return as_csv(_COLUMNS, (("" if value != value else value for value in line) for line in values))


def as_csv(headings: Sequence[str], lines: Iterable[Iterable[object]]) -> str:
    """Write a table as CSV with headings."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([headings, *lines])
    return text.getvalue()


def read_rows(text: str) -> list[Row]:
    """Read the rows that `write_rows` wrote.

    Raises:
        RecordError: The text is no such table.
    """
    try:
        headings, *lines = csv.reader(io.StringIO(text))
        if headings != _COLUMNS:
            raise ValueError("its columns are others")
        return [_row(dict(zip(_COLUMNS, line, strict=True))) for line in lines]
    except (ValueError, csv.Error) as error:
        raise RecordError(f"not a table of the reproduction: {shown(error)}") from error


def _trace(name: str) -> str:
    return f"trace_{name}"


_PLAIN = {field.name: str(field.type) for field in fields(Row) if field.name not in ("cost", "traces")}
_COLUMNS = [*_PLAIN, *COSTS, *map(_trace, Traces._fields)]


def _row(columns: Mapping[str, Any]) -> Row:
    """Make a row from the columns of its table, given as texts or numbers."""
    plain: dict[str, Any] = {name: _read(columns[name], kind) for name, kind in _PLAIN.items()}
    cost = {key: _read(columns[name], "float") for name, key in COSTS.items()}
    traces = Traces(*(_read(columns[_trace(name)], "float") for name in Traces._fields))
    return Row(**plain, cost=cost, traces=traces)


def _read(value: Any, kind: str) -> Any:
    if kind == "str":
        return value or ""
    if kind == "int":
        return 0 if value is None else int(value)
    if value is None or value == "":
        return None if kind.endswith("None") else math.nan
    return float(value)


def rounded(value: float) -> float:
    """Round a number to the six digits that tables keep."""
    return float(f"{value:.{_DIGITS}g}")
