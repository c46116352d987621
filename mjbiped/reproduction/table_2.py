"""Table II: which reading of its grounds fits the paper's numbers, and what the methods do on it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.grounds import Place
from mjbiped.reproduction.methods import SLOPE_SOURCES
from mjbiped.reproduction.published import TABLE_2, meets
from mjbiped.reproduction.rows import Row

UNEVEN = ("stair 1", "stair 2", "slope 1", "slope 2")


@dataclass(frozen=True)
class Choice:
    """One consistent reading of Table II's uneven grounds for the adaptive controller.

    zeta, kind of work and number of steps are shared by all grounds; pattern and place of the first change by the two
    stairs and by the two slopes.

    Attributes:
        delay: zeta; None without re-planning.
        kind: Of work.
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
        """Ground, pattern and first change of every ground of the table."""
        uneven = [(ground, *(self.stairs if ground.startswith("stair") else self.slopes)) for ground in UNEVEN]
        return [("level", "", 0.0), *uneven]

    def reads(self, entry: Row) -> bool:
        """Whether a walk is on one of the grounds as they are read here."""
        return entry.place_read in self.places


def choices(rows: Iterable[Row]) -> list[Choice]:
    """All readings of the hybrid engine's walks of the adaptive controller, the nearest to the paper first."""
    known, found = logs(rows), []
    for delay, kind, length in dict.fromkeys(key[:3] for key in known):
        sides = []
        for pair in (UNEVEN[:2], UNEVEN[2:]):
            places = dict.fromkeys(key[4:] for key in known if key[3] == pair[0])
            sides.append([(place, [known[(delay, kind, length, g, *place)] for g in pair]) for place in places])
        for (stairs, first), (slopes, second) in itertools.product(*sides):
            found.append(Choice(delay, kind, length, stairs, slopes, _root_mean_square(first + second)))
    return sorted(found, key=lambda choice: choice.distance)


@dataclass(frozen=True)
class Agreement:
    """Where methods fail, beside where the paper's do, and how far their numbers are from its.

    Attributes:
        agreeing: Grounds and methods that are walked to the end in both, or in neither.
        asked: Grounds and methods in all.
        met: Numbers of the paper's that ours are to the last digit.
        numbers: Numbers that the paper has.
        distance: Root mean square of ln(ours / paper's) where both have a number; NaN where that is nowhere.
        source: Of the slope, where all of them have the same.
    """

    agreeing: int
    asked: int
    met: int
    numbers: int
    distance: float
    source: str = ""

    @property
    def rank(self) -> tuple[int, float]:
        """Smaller for better ones: first as many X and numbers as possible where the paper has them."""
        return -self.agreeing, self.distance if self.distance == self.distance else math.inf


def agreement(costs: Iterable[tuple[str, str, float]], source: str = "") -> Agreement:
    """Compare with the paper's Table II.

    Args:
        costs: Method, ground, and c_mt, which is NaN where the robot did not come to the end.
        source: Of the slope, where all have the same.
    """
    agreeing, met, logs = [], [], []
    for method, ground, ours in costs:
        paper = TABLE_2[method][ground]
        agreeing.append((paper is None) == math.isnan(ours))
        if paper is not None:
            met.append(meets(ours, paper))
            if ours > 0.0:
                logs.append(_log(ours, paper))
    distance = _root_mean_square(logs) if logs else math.nan
    return Agreement(sum(agreeing), len(agreeing), sum(met), len(met), distance, source)


def walks_read(rows: Iterable[Row], choice: Choice, part: str, engine: str, source: str | None = None) -> list[Row]:
    """The energy-based methods' walks on a reading's grounds.

    Args:
        rows: Of the report.
        choice: The reading.
        part: "table 2" for the gains that settle, "blind" for those with the source that is chosen without the table,
            "fitted" for those nearest to the table.
        engine: "hybrid" or "mujoco".
        source: Of the slope; any unless given.
    """
    return [
        row
        for row in rows
        if (row.part, row.engine) == (part, engine)
        and row.method in TABLE_2
        and row.method != "adaptive"
        and source in (None, row.slope_source)
        and choice.reads(row)
    ]


def agreement_of(walks: Iterable[Row], choice: Choice, source: str = "") -> Agreement:
    """How far walks agree with the paper, by the reading's kind of work and number of steps."""
    return agreement(((row.method, row.ground, row.cost[choice.kind, choice.length]) for row in walks), source)


def agreements(rows: Sequence[Row], choice: Choice) -> list[Agreement]:
    """How far the energy-based methods, with gains that settle, agree in the hybrid engine, the best source first."""
    found = [
        agreement_of(walks_read(rows, choice, "table 2", "hybrid", source), choice, source) for source in SLOPE_SOURCES
    ]
    return sorted(found, key=lambda each: each.rank)


def side_distances(
    rows: Iterable[Row], pair: Sequence[str]
) -> Iterator[tuple[float, float | None, str, int, str, float]]:
    """Readings of the two stairs or of the two slopes alone: distance, zeta, kind, steps, pattern, first change."""
    by_key: dict[tuple[float | None, str, int, str, float], list[float]] = {}
    for (delay, kind, length, ground, pattern, first), value in logs(rows).items():
        if ground in pair:
            by_key.setdefault((delay, kind, length, pattern, first), []).append(value)
    for key, values in by_key.items():
        yield _root_mean_square(values), *key


def logs(rows: Iterable[Row]) -> dict[tuple[float | None, str, int, str, str, float], float]:
    """ln(ours / paper's) of the hybrid engine's walks of the adaptive controller on uneven ground.

    By zeta, kind of work, number of steps, ground, pattern and first change.
    """
    return {
        (row.delay, kind, length, *row.place_read): _log(row.cost[kind, length], TABLE_2["adaptive"][row.ground])
        for row in rows
        if (row.part, row.engine, row.method) == ("table 2", "hybrid", "adaptive") and row.ground in UNEVEN
        for kind, length in itertools.product(WORK_KINDS, LENGTHS)
    }


def _root_mean_square(values: Sequence[float]) -> float:
    return math.sqrt(sum(value**2 for value in values) / len(values))


def _log(ours: float, paper: float | None) -> float:
    """ln(ours / paper's); infinite where ours does not exist or is not positive."""
    return math.log(ours / paper) if paper is not None and ours > 0.0 else math.inf
