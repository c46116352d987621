"""The reading of Table II's grounds nearest to its numbers, and the agreement of walks with the table."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.grounds import (
    ENERGY_BASED,
    SLOPES,
    STAIRS,
    TABLE_2,
    UNEVEN,
    Place,
    meets,
)
from mjbiped.reproduction.methods import SLOPE_SOURCES
from mjbiped.reproduction.rows import Row, select


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
        distance: Root mean square of ln(ours / paper's) of the four uneven grounds; infinite where one is not walked.
    """

    delay: float | None
    kind: str
    length: int
    stairs: tuple[str, float]
    slopes: tuple[str, float]
    distance: float

    @property
    def places(self) -> list[Place]:
        """Ground, pattern and first change of every ground in Table II."""
        stairs, slopes = (self.stairs, STAIRS), (self.slopes, SLOPES)
        return [("level", "", 0.0), *((ground, *change) for change, pair in (stairs, slopes) for ground in pair)]

    def reads(self, entry: Row) -> bool:
        """Whether a walk is on one of the grounds of this reading."""
        return entry.place_read in self.places


def choices(rows: Iterable[Row]) -> list[Choice]:
    """List all readings by the adaptive controller's walks in the hybrid engine, the nearest to the paper first."""
    known, found = logs(rows), []
    for delay, kind, length in dict.fromkeys(key[:3] for key in known):
        sides = ([key[4:] for key in known if key[:4] == (delay, kind, length, pair[0])] for pair in (STAIRS, SLOPES))
        for stairs, slopes in itertools.product(*sides):
            places = [*((ground, *stairs) for ground in STAIRS), *((ground, *slopes) for ground in SLOPES)]
            values = [known[(delay, kind, length, *place)] for place in places]
            found.append(Choice(delay, kind, length, stairs, slopes, root_mean_square(values)))
    return sorted(found, key=lambda choice: choice.distance)


@dataclass(frozen=True)
class Agreement:
    """Agreement with the paper on where methods fail, and on their numbers.

    Attributes:
        agreeing: Grounds and methods that are walked to the end in both, or in neither.
        asked: Grounds and methods in all.
        met: Numbers of the paper's that ours are to the last digit.
        numbers: Numbers that the paper has.
        distance: Root mean square of ln(ours / paper's) where both have a number; NaN where that is nowhere.
        source: Slope source, where all of them have the same.
    """

    agreeing: int
    asked: int
    met: int
    numbers: int
    distance: float
    source: str = ""

    @property
    def rank(self) -> tuple[int, float]:
        """Sort key, smaller for better ones: first the number of X and numbers that stand where the paper's do."""
        return -self.agreeing, self.distance if self.distance == self.distance else math.inf


def agreement(costs: Iterable[tuple[str, str, float]], source: str = "") -> Agreement:
    """Compare costs with the paper's Table II.

    Args:
        costs: Method, ground, and c_mt, which is NaN where the robot did not come to the end.
        source: Slope source, where all have the same.
    """
    agreeing, met, logs = [], [], []
    for method, ground, ours in costs:
        paper = TABLE_2[method][ground]
        agreeing.append((paper is None) == math.isnan(ours))
        if paper is not None:
            met.append(meets(ours, paper))
            if ours > 0.0:
                logs.append(_log(ours, paper))
    distance = root_mean_square(logs) if logs else math.nan
    return Agreement(sum(agreeing), len(agreeing), sum(met), len(met), distance, source)


def walks_read(rows: Iterable[Row], choice: Choice, part: str, engine: str, source: str | None = None) -> list[Row]:
    """Find the energy-based methods' walks on a reading's grounds.

    Args:
        rows: Rows of the report.
        choice: The reading.
        part: "table 2" for the gains that settle, "blind" for those with the source that is chosen without the table,
            "fitted" for those nearest to the table.
        engine: "hybrid" or "mujoco".
        source: Slope source; any unless given.
    """
    wanted = {"part": part, "engine": engine, **({} if source is None else {"slope_source": source})}
    return [row for row in select(rows, **wanted) if row.method in ENERGY_BASED and choice.reads(row)]


def agreement_of(walks: Iterable[Row], choice: Choice, source: str = "") -> Agreement:
    """Compare walks with the paper, by the reading's kind of work and number of steps."""
    return agreement(((row.method, row.ground, row.cost[choice.kind, choice.length]) for row in walks), source)


def agreements(rows: Sequence[Row], choice: Choice) -> list[Agreement]:
    """Compare the energy-based methods with gains that settle, in the hybrid engine; the best slope source first."""
    found = [
        agreement_of(walks_read(rows, choice, "table 2", "hybrid", source), choice, source) for source in SLOPE_SOURCES
    ]
    return sorted(found, key=lambda each: each.rank)


def side_distances(
    rows: Iterable[Row], pair: Sequence[str]
) -> Iterator[tuple[float, float | None, str, int, str, float]]:
    """List readings of the stairs or of the slopes alone: distance, zeta, kind, steps, pattern, first change."""
    known = logs(rows)
    for delay, kind, length, ground, pattern, first in known:
        if ground == pair[0]:
            values = [known[delay, kind, length, each, pattern, first] for each in pair]
            yield root_mean_square(values), delay, kind, length, pattern, first


def logs(rows: Iterable[Row]) -> dict[tuple[float | None, str, int, str, str, float], float]:
    """ln(ours / paper's) of the hybrid engine's walks of the adaptive controller on uneven ground.

    By zeta, kind of work, number of steps, ground, pattern and first change.
    """
    return {
        (row.delay, kind, length, *row.place_read): _log(row.cost[kind, length], TABLE_2["adaptive"][row.ground])
        for row in select(rows, part="table 2", engine="hybrid", method="adaptive")
        if row.ground in UNEVEN
        for kind, length in itertools.product(WORK_KINDS, LENGTHS)
    }


def root_mean_square(values: Sequence[float]) -> float:
    """Compute the root mean square of some values."""
    return math.sqrt(sum(value**2 for value in values) / len(values))


def _log(ours: float, paper: float | None) -> float:
    """ln(ours / paper's); infinite where ours does not exist or is not positive."""
    return math.log(ours / paper) if paper is not None and ours > 0.0 else math.inf
