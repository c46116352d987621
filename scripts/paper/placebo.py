"""Placebo tests of the fits: how near the same settings come to rows of random numbers.

A random row has its X where the paper's has them, and its numbers are drawn log-uniformly, except those that no setting
varies: there a random row has the paper's number. If most random rows are met as near as the paper's, meeting the
paper's shows that there were many settings, and nothing else. For Table III,
grounds are drawn at random from the family in which its ground was searched by `scripts/paper/search_table_3.py`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mjbiped.studies.cell import Cell
from mjbiped.studies.reproduction import reproduce
from mjbiped.studies.reproduction.cell import cell
from mjbiped.studies.reproduction.results import Results, as_csv, logs
from mjbiped.studies.reproduction.section_5 import TABLE_2, TABLE_3, UNEVEN, Segments, adaptive, end_of
from mjbiped.terrain.terrain import Terrain
from scripts.paper.gain_scan import Tried

SEGMENTS = 6
"""Number of segments of a ground."""

LENGTHS = (1.0, 3.0)
"""Bounds of a segment's length, m."""

SLOPES = (-5.0, 5.0)
"""Bounds of a segment's slope, degrees, downhill positive."""

RISES = (-0.12, 0.02)
"""Bounds of the step at the start of each segment but the first, m, up positive."""

COUNT = 300
SEED = 0


@dataclass(frozen=True)
class RandomGround:
    """A ground, and how the adaptive controller walks it from rest in the hybrid engine.

    Attributes:
        segments: Segments of the ground.
        torques: Greatest torque of either joint by zeta, in Table III's order, N m, six digits; empty where one of the
            walks did not come to its end.
        costs: c_mt by zeta, six digits; empty in the same case.
    """

    segments: Segments
    torques: tuple[float, ...] = ()
    costs: tuple[float, ...] = ()


def bounds() -> list[tuple[float, float]]:
    """Bounds of every number of a ground of the family: of each segment its length, its slope and, later, its step."""
    return [bound for place in range(SEGMENTS) for bound in (LENGTHS, SLOPES, RISES)[: 3 if place else 2]]


def segments_of(parameters: NDArray[np.float64]) -> tuple[tuple[float, float, float], ...]:
    """Convert parameters to segments, rounded for printing; the first segment has no step."""
    table = np.insert(parameters, 2, 0.0).reshape(SEGMENTS, 3)
    return tuple(
        (round(length, 2), round(slope, 1) + 0.0, round(step, 3) + 0.0) for length, slope, step in table.tolist()
    )


def cells(segments: Segments) -> list[Cell]:
    """The walks of a ground in the hybrid engine: to its end from rest, one for each zeta of Table III."""
    terrain, end = Terrain.from_segments(segments), end_of(segments)
    role: dict[str, Any] = {"engine": "hybrid", "initial": "rest"}
    return [cell(terrain, adaptive(delay), distance=end, **role) for delay in TABLE_3]


def drawn(count: int = COUNT, seed: int = SEED) -> list[Segments]:
    """Draw grounds whose numbers are uniform between the bounds, and round the numbers."""
    least, greatest = np.array(bounds()).T
    numbers = np.random.default_rng(seed).uniform(least, greatest, (count, least.size))
    return [segments_of(each) for each in numbers]


def walked(grounds: Iterable[Segments], folder: Path) -> list[RandomGround]:
    """Walk grounds with every zeta; finished walks are kept in a folder."""
    planned = [*grounds]
    walks = iter(reproduce.walked([each for segments in planned for each in cells(segments)], folder, progress=True))
    found = []
    for segments in planned:
        ended = [next(walks) for _ in TABLE_3]
        if all(row.finished for row in ended):
            torques = tuple(row.torque for row in ended)
            found.append(RandomGround(segments, torques, tuple(row.absolute_end for row in ended)))
        else:
            found.append(RandomGround(segments))
    return found


def write_grounds(grounds: Iterable[RandomGround]) -> str:
    """Write grounds as CSV: length (m), slope (degrees) and step (m) of each segment, then their tables."""
    names = [f"{name}_{number}" for number in range(1, SEGMENTS + 1) for name in ("length", "slope", "step")]
    zetas = ["none" if zeta is None else f"{zeta:g}" for zeta in TABLE_3]
    names += [f"{name}_{zeta}" for name in ("torque", "c_mt") for zeta in zetas]
    missing = [""] * len(TABLE_3)
    lines = (
        [*(value for row in each.segments for value in row), *(each.torques or missing), *(each.costs or missing)]
        for each in grounds
    )
    return as_csv(names, lines)


ROWS = 2000

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Placebo:
    """A fit to the paper's numbers, compared with fits to random rows.

    Attributes:
        numbers: Number of values that are fitted.
        varied: Number of these values that the settings vary. Only these are drawn in the random rows.
        tried: Number of settings that can fit them: those whose X stand where the paper's do.
        distance: Root mean square of ln(ours / paper's) of the nearest setting.
        random: Median distance of the random rows from their nearest settings.
        share: Share of the random rows that are fitted as closely as the paper's, or more closely.
    """

    numbers: int
    varied: int
    tried: int
    distance: float
    random: float
    share: float


ALIKE = 1e-3
"""Settings whose numbers differ relatively by less give them alike; a last digit of Table II is more than this."""


def placebo(paper: Array, tried: Array, rows: Array) -> Placebo:
    """Compare a fit with fits to random rows.

    A number that every setting gives alike is the paper's in each random row: how near it is says nothing of the
    settings, and a random row with another number there would be met by none of them.

    Args:
        paper: Logarithms of the paper's numbers, shape (n,).
        tried: Logarithms of each setting's numbers, finite, shape (settings, n).
        rows: Logarithms of the random rows, shape (rows, n).
    """
    varied = np.ptp(tried, axis=0) > ALIKE
    nearest, scale = cKDTree(tried), math.sqrt(paper.size)
    own = float(nearest.query(paper)[0]) / scale
    random = nearest.query(np.where(varied, rows, paper))[0] / scale
    share = float(np.mean(random <= own))
    return Placebo(paper.size, int(varied.sum()), len(tried), own, float(np.median(random)), share)


def span(ground: str) -> tuple[float, float]:
    """Bounds between which a random number is drawn for a ground of Table II.

    The least and greatest number that the table has on all grounds but stair 2. On that one it has a single number:
    there the ends are that number's neighbours, and as far apart in proportion.
    """
    mild = [value for row in TABLE_2.values() for name, value in row.items() if value > 0.0 and name != "stair 2"]
    low, high = min(mild), max(mild)
    if ground != "stair 2":
        return low, high
    (only,) = (row[ground] for row in TABLE_2.values() if row[ground] > 0.0)
    return only * math.sqrt(low / high), only * math.sqrt(high / low)


def of_method(tried: Sequence[Tried], method: str) -> Placebo:
    """Test the fit of a comparison method's settings to its row of Table II."""
    mine = [each for each in tried if each.variant.method == method]
    most = max(each.agreement.agreeing for each in mine)
    printed = {ground: value for ground, value in TABLE_2[method].items() if value > 0.0}
    costs = [[each.cost[ground] for ground in printed] for each in mine if each.agreement.agreeing == most]
    return placebo(np.log([*printed.values()]), np.log(costs), _random([span(ground) for ground in printed]))


def of_readings(results: Results) -> Placebo:
    """Test the fit of the readings of uneven grounds to the adaptive controller's four numbers there."""
    paper = np.log([TABLE_2["adaptive"][ground] for ground in UNEVEN])
    off = logs(results.rows)
    every = [[off[each.delay, each.kind, each.length, place] for place in each.places[1:]] for each in results.readings]
    walked = np.array(every)[np.isfinite(every).all(axis=1)]
    return placebo(paper, paper + walked, _random([span(ground) for ground in UNEVEN]))


def of_table_3(grounds: Sequence[RandomGround]) -> Placebo:
    """Test the fit of random grounds to Table III.

    A random table has eleven torques and eleven c_mt between the least and the greatest of the paper's, each in the
    paper's order of zeta.
    """
    generator = np.random.default_rng(SEED)
    columns = np.log([*TABLE_3.values()]).T
    tables = [
        np.sort(generator.uniform(column.min(), column.max(), (ROWS, column.size)))[:, column.argsort().argsort()]
        for column in columns
    ]
    return placebo(columns.ravel(), _tables(grounds), np.hstack(tables))


def to_another(grounds: Sequence[RandomGround]) -> Array:
    """Distance of each random ground's table from the nearest table of another one, shape (grounds,)."""
    tables = _tables(grounds)
    itself_and_next = np.asarray(cKDTree(tables).query(tables, k=2)[0], dtype=np.float64)
    found: Array = itself_and_next[:, 1] / math.sqrt(tables.shape[1])
    return found


def _tables(grounds: Sequence[RandomGround]) -> Array:
    """Logarithms of the tables of all random grounds that are walked to their end."""
    return np.log([[*each.torques, *each.costs] for each in grounds if each.torques])


def _random(spans: Sequence[tuple[float, float]]) -> Array:
    """Draw logarithms of random rows between bounds, shape (rows, n)."""
    low, high = np.log(spans).T
    return np.random.default_rng(SEED).uniform(low, high, (ROWS, low.size))
