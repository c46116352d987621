"""What a fit is worth: how near the same settings come to rows of numbers that nobody measured.

A random row has its X where the paper's has them, and its numbers are drawn log-uniformly. If most random rows are met
as near as the paper's, meeting the paper's shows that there were many settings, and nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mjbiped.reproduction.published import GROUNDS, TABLE_2, TABLE_3
from mjbiped.reproduction.random_grounds import RandomGround
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.scan import Tried
from mjbiped.reproduction.table_2 import UNEVEN, choices, logs

ROWS = 2000
SEED = 0

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Placebo:
    """A fit beside those of random rows.

    Attributes:
        numbers: Numbers that are met.
        tried: Settings that can meet them: all whose X stand where the paper's do.
        distance: Root mean square of ln(ours / paper's) of the nearest setting.
        random: Distance that half of the random rows are met within.
        share: Of the random rows that are met as near as the paper's, or nearer.
    """

    numbers: int
    tried: int
    distance: float
    random: float
    share: float


def placebo(paper: Array, tried: Array, rows: Array) -> Placebo:
    """Lay a fit beside those of random rows.

    Args:
        paper: Logarithms of the paper's numbers, shape (n,).
        tried: Those of each setting, shape (settings, n), finite.
        rows: Those of the random rows, shape (rows, n).
    """
    nearest, scale = cKDTree(tried), math.sqrt(paper.size)
    own = float(nearest.query(paper)[0]) / scale
    random = nearest.query(rows)[0] / scale
    return Placebo(paper.size, len(tried), own, float(np.median(random)), float(np.mean(random <= own)))


def span(ground: str) -> tuple[float, float]:
    """Between which numbers a random one is drawn for a ground of Table II.

    The least and greatest number that the table has on all grounds but stair 2. On that one it has a single number:
    there the ends are that number's neighbours, and as far apart in proportion.
    """
    mild = [value for row in TABLE_2.values() for name, value in row.items() if value is not None and name != "stair 2"]
    low, high = min(mild), max(mild)
    if ground != "stair 2":
        return low, high
    (only,) = (row[ground] for row in TABLE_2.values() if row[ground] is not None)
    assert only is not None
    return only * math.sqrt(low / high), only * math.sqrt(high / low)


def of_method(tried: Sequence[Tried], method: str) -> Placebo:
    """Of the settings of a comparison method: its row of Table II."""
    mine = [each for each in tried if each.variant.method == method]
    most = max(each.agreement.agreeing for each in mine)
    printed = {ground: value for ground in GROUNDS if (value := TABLE_2[method][ground]) is not None}
    costs = [[each.cost[ground] for ground in printed] for each in mine if each.agreement.agreeing == most]
    return placebo(np.log([*printed.values()]), np.log(costs), _random([span(ground) for ground in printed]))


def of_readings(rows: Sequence[Row]) -> Placebo:
    """Of the readings of Table II's uneven grounds: the adaptive controller's four numbers there."""
    paper = np.log([TABLE_2["adaptive"][ground] or math.nan for ground in UNEVEN])
    off = logs(rows)
    every = [[off[(each.delay, each.kind, each.length, *place)] for place in each.places[1:]] for each in choices(rows)]
    walked = np.array(every)[np.isfinite(every).all(axis=1)]
    return placebo(paper, paper + walked, _random([span(ground) for ground in UNEVEN]))


def of_table_3(grounds: Sequence[RandomGround]) -> Placebo:
    """Of random grounds: Table III.

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
    """How far the table of each random ground is from the nearest of another one, shape (grounds,)."""
    tables = _tables(grounds)
    itself_and_next = np.asarray(cKDTree(tables).query(tables, k=2)[0], dtype=np.float64)
    found: Array = itself_and_next[:, 1] / math.sqrt(tables.shape[1])
    return found


def _tables(grounds: Sequence[RandomGround]) -> Array:
    """Logarithms of the random grounds' own tables, of all that are walked to their end."""
    return np.log([[*each.torques, *each.costs] for each in grounds if each.torques])


def _random(spans: Sequence[tuple[float, float]]) -> Array:
    """Logarithms of random rows between these ends, shape (rows, n)."""
    low, high = np.log(spans).T
    return np.random.default_rng(SEED).uniform(low, high, (ROWS, low.size))
