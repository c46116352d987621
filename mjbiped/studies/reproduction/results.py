"""The rows behind the report, one for each walk, and the reading of Table II's grounds nearest to its numbers."""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace

from mjbiped.studies.reproduction import section_5 as paper
from mjbiped.studies.reproduction.cell import COSTS, LENGTHS, TRACES
from mjbiped.studies.reproduction.section_5 import Place, log_ratio, root_mean_square

MEASURES = ("steps", "place", "ankle", "hip", "friction", "least_force", "strikes", "begun", "ended", "rms", "jump")
TEXTS = ("part", "ground", "pattern", "engine", "method", "slope_source", "gains", "update", "outcome", "error")
_COUNTS = ("steps", "strikes")
COLUMNS = (
    "part", "ground", "pattern", "first", "engine", "method", "delay", "slope_source", "gains", "adaptation_gain",
    "update", "start_estimate", "outcome", *MEASURES, "error", *COSTS, *TRACES,
)  # fmt: skip
_DIGITS = 6  # that tables keep
NONE = "–"

ENGINES = {"hybrid": "hybrid", "mujoco": "MuJoCo"}
"""What the engines are called, in the order in which the report has them."""


class Row(SimpleNamespace):
    """A walk and its measures, an attribute for each of `COLUMNS`; missing numbers are NaN.

    Beside those of `cell.measures_of`, c_mt by `COSTS` and `TRACES`:

    part: Part of the report that needs it, "table 2", "table 3", "figure 5" and so on.
    ground: The paper's name of the ground, or ours.
    pattern, first: Pattern in which Table II's ground was read, and position of its first change, m.
    engine, method: "mujoco" or "hybrid"; the paper's name of the controller.
    delay: zeta; None without re-planning.
    slope_source, gains: Slope source and gains, in words, of a comparison controller.
    adaptation_gain: gamma; NaN for controllers without one.
    update: Whether the estimate is updated (27), "yes", "no", or empty.
    start_estimate: Slope that the controller estimates, or is told, at the start, degrees; NaN for those without.
    outcome: Outcome of the walk; "failed" where an error ended it, empty where there is no walk.
    error: Text of the error that ended the walk.
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


@dataclass(frozen=True)
class Choice:
    """One consistent reading of Table II's uneven grounds for the adaptive controller.

    zeta, kind of work and number of steps are shared by all grounds; pattern and place of the first change by the two
    stairs and by the two slopes.

    Attributes:
        delay: zeta; None without re-planning.
        kind: Kind of work.
        length: Steps of the mean.
        stairs: Pattern and first riser, m.
        slopes: Pattern and first change, m.
        distance: Root mean square of ln(ours / paper's) of the uneven grounds; infinite where one is not walked.
    """

    delay: float | None
    kind: str
    length: int
    stairs: tuple[str, float]
    slopes: tuple[str, float]
    distance: float

    @property
    def places(self) -> list[paper.Place]:
        """Table II's grounds as they are read, in its order."""
        stairs, slopes = (self.stairs, paper.STAIRS), (self.slopes, paper.SLOPES)
        return [paper.LEVEL, *(paper.Place(ground, *change) for change, pair in (stairs, slopes) for ground in pair)]

    @property
    def words(self) -> str:
        """Describe the reading in words."""
        replanned = "no re-planning" if self.delay is None else f"ζ = {self.delay:g}"
        return (
            f"{self.kind} work over the first {self.length} steps, {replanned}; stairs {self.stairs[0]}, first riser "
            f"at {self.stairs[1]:g} m; slopes {self.slopes[0]}, first change after {self.slopes[1]:g} m"
        )

    def cost(self, walk: Row) -> float:
        """c_mt of this kind of work after so many steps; NaN where the robot did not come so far."""
        return float(getattr(walk, f"{self.kind}_{self.length}"))

    def written(self, walk: Row) -> str:
        """Write c_mt of a walk as this reading takes it, or the step in which it ended before."""
        return walk.cost(self.kind, self.length)


@dataclass(frozen=True)
class Results:
    """The rows of a reproduction, read as fits Table II.

    Attributes:
        rows: The rows; those of MuJoCo may be missing.
    """

    rows: Sequence[Row]

    @cached_property
    def readings(self) -> list[Choice]:
        """All readings by the adaptive controller's walks in the hybrid engine, the nearest to the paper first."""
        found = []
        sides = (side_distances(self.rows, pair) for pair in (paper.STAIRS, paper.SLOPES))
        for stairs, slopes in itertools.product(*sides):
            if (stairs.delay, stairs.kind, stairs.length) == (slopes.delay, slopes.kind, slopes.length):
                distance = root_mean_square((stairs.distance, slopes.distance))
                found.append(replace(stairs, slopes=slopes.slopes, distance=distance))
        return sorted(found, key=lambda choice: choice.distance)

    @property
    def best(self) -> Choice:
        """The reading that is nearest to the paper."""
        return self.readings[0]

    @cached_property
    def sources(self) -> list[str]:
        """Slope sources of gains that settle, the one that agrees best in the hybrid engine first."""
        return sorted(paper.SLOPE_SOURCES, key=lambda source: self.agreement("hybrid", source).rank)

    @cached_property
    def _walks(self) -> dict[tuple[str, str, str | float | None, paper.Place], Row]:
        """Walks of Table II by engine, method, settings (zeta of the adaptive controller) and ground."""
        found = {}
        for row in self.rows:
            if row.part in ("table 2", "blind", "fitted"):
                settings = row.slope_source if row.part == "table 2" else row.part
                settings = row.delay if row.method == "adaptive" else settings
                found[row.engine, row.method, settings, row.place_read] = row
        return found

    def walks(
        self,
        method: str,
        settings: str | float | None = "fitted",
        engine: str = "hybrid",
        places: Iterable[paper.Place] | None = None,
    ) -> list[Row]:
        """Find a method's walks on grounds of Table II; `NO_WALK` where there is none.

        Args:
            method: One of `mjbiped.studies.reproduction.section_5.METHODS`.
            settings: "blind", "fitted", or the slope source of gains that settle. The adaptive controller has the best
                reading's zeta, unless another one is given here.
            engine: "hybrid" or "mujoco".
            places: The grounds; those of the best reading unless given.
        """
        if method == "adaptive" and isinstance(settings, str):
            settings = self.best.delay
        chosen = self.best.places if places is None else places
        return [self._walks.get((engine, method, settings, place), NO_WALK) for place in chosen]

    def agreement(self, engine: str, settings: str) -> paper.Agreement:
        """Compare the energy-based methods' walks with the paper; arguments as in `walks`."""
        walks = [walk for method in paper.ENERGY_BASED for walk in self.walks(method, settings, engine)]
        return paper.agreement((walk.method, walk.ground, self.best.cost(walk)) for walk in walks if walk.outcome)


def side_distances(rows: Iterable[Row], pair: Sequence[str]) -> Iterator[Choice]:
    """List readings of the stairs or of the slopes alone, with their distances."""
    known = logs(rows)
    for delay, kind, length, place in known:
        if place.ground == pair[0]:
            distance = root_mean_square([known[delay, kind, length, place._replace(ground=each)] for each in pair])
            yield Choice(delay, kind, length, place[1:], place[1:], distance)


def logs(rows: Iterable[Row]) -> dict[tuple[float | None, str, int, paper.Place], float]:
    """ln(ours / paper's) of the hybrid engine's walks of the adaptive controller on uneven ground.

    By zeta, kind of work, number of steps, and ground as it is read.
    """
    return {
        (row.delay, kind, steps, row.place_read): log_ratio(getattr(row, name), paper.TABLE_2["adaptive"][row.ground])
        for row in select(rows, part="table 2", engine="hybrid", method="adaptive")
        if row.ground in paper.UNEVEN
        for name, (kind, steps) in COSTS.items()
        if steps in LENGTHS
    }
