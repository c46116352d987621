"""The reading of Table II's grounds nearest to its numbers, and the agreement of walks with the table."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.grounds import ENERGY_BASED, LEVEL, SLOPES, STAIRS, TABLE_2, UNEVEN, Place, meets
from mjbiped.reproduction.methods import SLOPE_SOURCES
from mjbiped.reproduction.rows import LENGTHS, Row, find, select


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
        """Table II's grounds as they are read, in its order."""
        stairs, slopes = (self.stairs, STAIRS), (self.slopes, SLOPES)
        return [LEVEL, *((ground, *change) for change, pair in (stairs, slopes) for ground in pair)]

    def cost(self, walk: Row) -> float:
        """c_mt of this kind of work after so many steps; NaN where the robot did not come so far."""
        return float(getattr(walk, f"{self.kind}_{self.length}"))


def choices(rows: Iterable[Row]) -> list[Choice]:
    """List all readings by the adaptive controller's walks in the hybrid engine, the nearest to the paper first."""
    known, found = logs(rows), []
    for delay, kind, length in dict.fromkeys(key[:3] for key in known):
        sides = ([key[4:] for key in known if key[:4] == (delay, kind, length, pair[0])] for pair in (STAIRS, SLOPES))
        for stairs, slopes in itertools.product(*sides):
            choice = Choice(delay, kind, length, stairs, slopes, math.inf)
            distance = root_mean_square([known[delay, kind, length, *place] for place in choice.places[1:]])
            found.append(Choice(delay, kind, length, stairs, slopes, distance))
    return sorted(found, key=lambda choice: choice.distance)


def walk_on(rows: Iterable[Row], best: Choice, engine: str, place: Place, method: str, settings: str) -> Row:
    """Find a method's walk on a ground of Table II; `NO_WALK` where there is none.

    Args:
        rows: Rows of the report.
        best: The reading, whose zeta the adaptive controller has.
        engine: "hybrid" or "mujoco".
        place: The ground.
        method: One of `mjbiped.reproduction.methods.METHODS`.
        settings: "blind", "fitted", or the slope source of gains that settle.
    """
    of_method: dict[str, object] = {"part": "table 2", "slope_source": settings}
    if method == "adaptive":
        of_method = {"part": "table 2", "delay": best.delay}
    elif settings in ("blind", "fitted"):
        of_method = {"part": settings}
    return find(rows, method=method, engine=engine, place_read=place, **of_method)


@dataclass(frozen=True)
class Agreement:
    """Agreement with the paper on where methods fail, and on their numbers.

    Attributes:
        agreeing: Grounds and methods that are walked to the end in both, or in neither.
        asked: Grounds and methods in all.
        met: Numbers of the paper's that ours are to the last digit.
        numbers: Numbers that the paper has.
        distance: Root mean square of ln(ours / paper's) where both have a number; NaN where that is nowhere.
    """

    agreeing: int
    asked: int
    met: int
    numbers: int
    distance: float

    @property
    def rank(self) -> tuple[int, float]:
        """Sort key, smaller for better ones: first the number of X and numbers that stand where the paper's do."""
        return -self.agreeing, self.distance if self.distance == self.distance else math.inf


def agreement(costs: Iterable[tuple[str, str, float]]) -> Agreement:
    """Compare costs with the paper's Table II.

    Args:
        costs: Method, ground, and c_mt, which is NaN where the robot did not come to the end.
    """
    both = [(ours, TABLE_2[method][ground]) for method, ground, ours in costs]
    agreeing = sum((paper is None) == math.isnan(ours) for ours, paper in both)
    numbers = [(ours, paper) for ours, paper in both if paper is not None]
    logs = [_log(ours, paper) for ours, paper in numbers if ours > 0.0]
    distance = root_mean_square(logs) if logs else math.nan
    return Agreement(agreeing, len(both), sum(meets(*each) for each in numbers), len(numbers), distance)


def agreement_of(rows: Iterable[Row], best: Choice, engine: str, settings: str) -> Agreement:
    """Compare the energy-based methods' walks with the paper; arguments as in `walk_on`."""
    walks = [walk_on(rows, best, engine, place, name, settings) for place in best.places for name in ENERGY_BASED]
    return agreement((walk.method, walk.ground, best.cost(walk)) for walk in walks if walk.outcome)


def sources_ranked(rows: Iterable[Row], best: Choice) -> list[str]:
    """List the slope sources of gains that settle, the one that agrees best in the hybrid engine first."""
    return sorted(SLOPE_SOURCES, key=lambda source: agreement_of(rows, best, "hybrid", source).rank)


def side_distances(rows: Iterable[Row], pair: Sequence[str]) -> Iterator[Choice]:
    """List readings of the stairs or of the slopes alone, with their distances."""
    known = logs(rows)
    for delay, kind, length, ground, pattern, first in known:
        if ground == pair[0]:
            distance = root_mean_square([known[delay, kind, length, each, pattern, first] for each in pair])
            yield Choice(delay, kind, length, (pattern, first), (pattern, first), distance)


def logs(rows: Iterable[Row]) -> dict[tuple[float | None, str, int, str, str, float], float]:
    """ln(ours / paper's) of the hybrid engine's walks of the adaptive controller on uneven ground.

    By zeta, kind of work, number of steps, ground, pattern and first change.
    """
    return {
        (row.delay, kind, length, *row.place_read): _log(
            getattr(row, f"{kind}_{length}"), TABLE_2["adaptive"][row.ground]
        )
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
