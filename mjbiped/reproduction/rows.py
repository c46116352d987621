"""The table that the report is made of: one row per walk, in plain numbers of six digits; and what is walked for it."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mjbiped.errors import RecordError, shown
from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.cell import Cell, Result
from mjbiped.reproduction.grounds import Place
from mjbiped.reproduction.methods import gains_told
from mjbiped.reproduction.traces import Traces

LENGTHS = (20, 45, 60, 100)
"""Numbers of steps after which c_mt is taken, from one walk."""

_DIGITS = 6
_COSTS = [(kind, length) for kind in WORK_KINDS for length in (*LENGTHS, None)]
_TABLES = ("cost", "traces")  # fields of a row that are several columns


@dataclass(frozen=True)
class Row:
    """A walk and what was measured. Missing numbers are NaN.

    Attributes:
        part: What it is for, "table 2", "table 3", "figure 5" and so on.
        ground: The paper's name of the ground, or ours.
        pattern: How Table II's ground was read.
        first: Where its first change lies, m.
        engine: "mujoco" or "hybrid".
        method: The paper's name of the controller.
        delay: zeta; None without re-planning.
        slope_source: Of comparison controllers.
        gains: The same.
        adaptation_gain: gamma; NaN for controllers without one.
        update: Whether the estimate is updated (27), "yes", "no", or empty.
        start_estimate: Slope that the controller estimates, or is told, at the start, degrees; NaN for those without.
        outcome: Of the walk.
        steps: Touchdowns.
        place: Hip's x when it ended, m.
        ankle: Greatest |torque|, N m.
        hip: The same.
        friction: Greatest |F_t|/F_n asked of a stance foot.
        least_force: Least normal force of the ground on a stance foot, weights; below zero it would have to pull.
        strikes: Swing feet that struck a riser.
        begun: Greatest error of the slope estimate at a step's beginning, degrees.
        ended: The same at the steps' ends.
        rms: Root mean square of the errors at the steps' ends, degrees.
        jump: Greatest change of the size of the error at a touchdown, degrees.
        cost: c_mt by (kind, steps); None: to the last touchdown.
        traces: See `mjbiped.reproduction.traces.Traces`; all NaN where no record was kept.
        error: Why a walk failed that has no outcome of its own.
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
        """Whether the robot walked as far as it should."""
        return self.outcome == "finished"

    @property
    def pulls(self) -> bool:
        """Whether the motion needs a ground that pulls at the stance foot."""
        return self.least_force < 0.0

    @property
    def torque(self) -> float:
        """Greatest torque of either joint, N m."""
        return max(self.ankle, self.hip)


@dataclass(frozen=True)
class Entry:
    """A cell and its place in the report.

    Attributes:
        part: "table 2", "blind", "fitted", "misjudged", "gravity", "table 3", "start" or "figure 5".
        ground: The ground's name.
        method: The paper's name of the controller.
        cell: The walk.
        pattern: How Table II's ground was read.
        first: Where its first change lies, m.
    """

    part: str
    ground: str
    method: str
    cell: Cell
    pattern: str = ""
    first: float = 0.0

    def row(self, result: Result, traces: Traces | None = None) -> Row:
        """What the report has of the finished cell, and of its record where it keeps one."""
        law = self.cell.controller.describe()
        begun, ended = (
            np.abs(np.degrees(np.array(values, dtype=np.float64))) for values in (result.begun, result.ended)
        )
        update = law.get("estimate_update")
        return Row(
            part=self.part,
            ground=self.ground,
            pattern=self.pattern,
            first=self.first,
            engine=self.cell.engine,
            method=self.method,
            delay=law.get("replanning_delay"),
            slope_source=law.get("slope_source", ""),
            gains=gains_told(law),
            adaptation_gain=float(law.get("adaptation_gain", math.nan)),
            update="" if update is None else "yes" if update else "no",
            start_estimate=rounded(math.degrees(law.get("initial_slope_estimate", law.get("initial_slope", math.nan)))),
            outcome=result.outcome,
            steps=result.steps,
            place=rounded(result.place),
            ankle=rounded(result.peak_torque[0]),
            hip=rounded(result.peak_torque[1]),
            friction=rounded(result.friction),
            least_force=rounded(result.least_force),
            strikes=result.strikes,
            begun=rounded(float(begun.max())) if begun.size else math.nan,
            ended=rounded(float(ended.max())) if ended.size else math.nan,
            rms=rounded(math.sqrt(float(np.mean(ended**2)))) if ended.size else math.nan,
            jump=rounded(float(np.abs(begun - ended).max())) if begun.size else math.nan,
            cost={(kind, length): rounded(result.cost_of_transport(kind, length)) for kind, length in _COSTS},
            traces=Traces(*map(rounded, traces or Traces())),
            error=" ".join(result.error.split()),
        )


def write_rows(rows: Iterable[Row]) -> str:
    """Rows as CSV, a heading first; an empty cell is a number that does not exist."""
    plain = _plain()
    values = (
        (*(getattr(row, name) for name in plain), *(row.cost[key] for key in _COSTS), *row.traces) for row in rows
    )
    return as_csv(_columns(), (("" if value != value else value for value in line) for line in values))


def as_csv(headings: Sequence[str], lines: Iterable[Iterable[object]]) -> str:
    """A table as CSV, the headings first."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([headings, *lines])
    return text.getvalue()


def _plain() -> list[str]:
    return [field.name for field in fields(Row) if field.name not in _TABLES]


def _columns() -> list[str]:
    return [*_plain(), *(_name(kind, length) for kind, length in _COSTS), *map(_trace, Traces._fields)]


def read_rows(text: str) -> list[Row]:
    """The rows that `write_rows` wrote.

    Raises:
        RecordError: The text is no such table.
    """
    kinds = {field.name: str(field.type) for field in fields(Row)}
    found = []
    try:
        lines = csv.DictReader(io.StringIO(text))
        if lines.fieldnames != _columns():
            raise ValueError("its columns are others")
        for line in lines:
            if None in line or None in line.values():
                raise ValueError("a line has not one entry for each column")
            plain: dict[str, Any] = {name: _read(line[name], kinds[name]) for name in _plain()}
            cost = {(kind, length): _read(line[_name(kind, length)], "float") for kind, length in _COSTS}
            traces = Traces(*(_read(line[_trace(name)], "float") for name in Traces._fields))
            found.append(Row(**plain, cost=cost, traces=traces))
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        raise RecordError(f"not a table of the reproduction: {shown(error)}") from error
    return found


def _read(text: str, kind: str) -> Any:
    if kind.startswith("float"):
        return None if kind.endswith("None") and not text else float(text or "nan")
    return int(text) if kind == "int" else text


def _name(kind: str, length: int | None) -> str:
    return f"{kind}_{'end' if length is None else length}"


def _trace(name: str) -> str:
    return f"trace_{name}"


def rounded(value: float) -> float:
    """A number of six digits, as tables keep it."""
    return float(f"{value:.{_DIGITS}g}")
