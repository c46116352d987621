"""The table behind the report: a row for each walk, with numbers of six digits, and how the report writes them."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import SimpleNamespace

from mjbiped.rules.termination import Outcome
from mjbiped.studies.cell import LIMIT, Cell
from mjbiped.studies.reproduction import cell as cells
from mjbiped.studies.reproduction.cell import COSTS, KEY_DIGITS, TRACES, key, record_path
from mjbiped.studies.reproduction.section_5 import Place
from mjbiped.studies.run import walk_cells
from mjbiped.studies.store import opened

MEASURES = ("steps", "place", "ankle", "hip", "friction", "least_force", "strikes", "begun", "ended", "rms", "jump")
TEXTS = ("part", "ground", "pattern", "engine", "method", "slope_source", "gains", "update", "outcome", "error")
_COUNTS = ("steps", "strikes")
COLUMNS = (
    "part", "ground", "pattern", "first", "engine", "method", "delay", "slope_source", "gains", "adaptation_gain",
    "update", "start_estimate", "outcome", *MEASURES, "error", *COSTS, *TRACES,
)  # fmt: skip
_DIGITS = 6  # that tables keep
_ENDS = {outcome.words for outcome in Outcome}

NONE = "–"

ENGINES = {"hybrid": "hybrid", "mujoco": "MuJoCo"}
"""What the engines are called, in the order in which the report has them."""


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
        trace_settled: See `mjbiped.studies.reproduction.cell.TRACES`; all NaN where no record was kept.
    """

    @property
    def place_read(self) -> Place:
        """Table II's ground, its pattern and its first change, as this walk's was read."""
        return Place(self.ground, self.pattern, self.first)

    @property
    def finished(self) -> bool:
        """Whether the robot walked to the planned end."""
        return bool(self.outcome == "finished")

    @property
    def torque(self) -> float:
        """Greatest torque of either joint, N m."""
        return float(max(self.ankle, self.hip))

    def ending(self, finished: str) -> str:
        """Write why and where the walk stopped before its end, or a text for one that came to it."""
        if not self.outcome:
            return NONE
        if self.finished:
            return finished
        struck = f", {self.strikes} riser{'s' * (self.strikes > 1)} struck" if self.strikes else ""
        return f"X ({self.outcome} in step {self.steps + 1}, hip at {number(self.place, '.2f')} m{struck})"

    def cost(self, kind: str = "absolute", length: int | None = None) -> str:
        """Write c_mt after some steps, or at the walk's end, or the step in which it ended before that."""
        value = getattr(self, f"{kind}_{length or 'end'}")
        if self.finished or (length and math.isfinite(value)):
            return number(value)
        return f"X {self.steps + 1}" if self.outcome else NONE


def row_of(columns: Mapping[str, str | float | None]) -> Row:
    """Make a row from texts or numbers by column; what is missing is empty, 0, NaN, or None for zeta."""
    return Row(**{name: _read(name, columns.get(name)) for name in COLUMNS})


def _read(name: str, value: str | float | None) -> str | float | None:
    if name in TEXTS:
        return value or ""
    if name in _COUNTS:
        return int(value or 0)
    if value is None or value == "":
        return None if name == "delay" else math.nan
    return float(f"{float(value):.{_DIGITS}g}")


NO_WALK = row_of({})


def walked(
    planned: Sequence[Cell], folder: Path, *, fresh: bool = False, workers: int | None = None, progress: bool = False
) -> list[Row]:
    """Return the rows of cells; those that are not kept in a folder yet are walked, and kept there as they end.

    The rows do not depend on the number of workers. A cell that fails has a row with the error's text, and is walked
    again the next time.

    Args:
        planned: Any number of cells; equal ones are walked once.
        folder: Folder of a table, and of a file for each record that is kept; it is made if missing.
        fresh: Delete the walks that are kept.
        workers: Number of processes that walk; one for each core unless given.
        progress: Show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: The folder cannot be made, or another process has it.
        RecordError: The table is damaged, or a file cannot be written.
        MjbipedError: A process died, of lack of memory perhaps; what had ended is kept.
        KeyboardInterrupt: Ctrl-C; what had ended is kept.
    """
    keys = [key(cell) for cell in planned]
    wanted = dict(zip(keys, planned, strict=True))
    with opened(folder, "walks", ("key", *COLUMNS), {}, fresh=fresh) as store:
        for file in folder.glob(f"{'[0-9a-f]' * KEY_DIGITS}.npz") if fresh else ():
            file.unlink()
        kept = {row["key"] for row in store.rows() if row["outcome"] in _ENDS}  # others failed, or are damaged
        todo = [
            cell
            for known, cell in wanted.items()
            if known not in kept or (cell.values.get("record") and not record_path(folder, cell).exists())
        ]
        # MuJoCo's take the longest, and longer the more steps they have
        todo.sort(key=lambda cell: (cell.values["engine"] != "mujoco", -int(cell.values.get(f"{LIMIT}.steps", 0))))
        ended = len(wanted) - len(todo)
        walk_cells(partial(cells.row, folder=folder), todo, store.save, ended=ended, workers=workers, progress=progress)
        found = {row["key"]: row_of(row) for row in store.rows()}
    return [found[each] for each in keys]


def select(rows: Iterable[Row], **wanted: object) -> list[Row]:
    """Select the rows whose attributes have the values wanted."""
    return [row for row in rows if all(getattr(row, name) == value for name, value in wanted.items())]


def find(rows: Iterable[Row], **wanted: object) -> Row:
    """Find the first row whose attributes have the values wanted; `NO_WALK` where there is none."""
    return next(iter(select(rows, **wanted)), NO_WALK)


def engine_shown(rows: Sequence[Row]) -> str:
    """Name of the engine whose figures the page shows: MuJoCo where it has any."""
    return "mujoco" if select(rows, part="table 3", engine="mujoco") else "hybrid"


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


def number(value: float, form: str = ".4f") -> str:
    """Write a number; a dash stands for one that does not exist."""
    return format(value, form).replace("-", "−") if math.isfinite(value) else NONE


def share(value: float, form: str = ".0f") -> str:
    """Write a share in percent."""
    return f"{number(100 * value, form)} %"


def excess(ours: float, other: float, form: str = "+.1f") -> str:
    """Write by how much ours exceeds the other, in percent."""
    return NONE if math.isnan(other) or math.isnan(ours) else share(ours / other - 1.0, form)


def in_words(zeta: float | None) -> str:
    """Write zeta, or "none" without re-planning."""
    return "none" if zeta is None else f"{zeta:g}"
