"""Grounds of the family in which Table III's ground was searched, drawn at random, and their own Tables III.

They show what it is worth that a ground meets the table: see `mjbiped.reproduction.placebo`. The search itself is the
program `scripts/paper/search_table_3.py`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjbiped.reproduction.cell import Cell, Walks
from mjbiped.reproduction.grounds import Segments, end_of
from mjbiped.reproduction.methods import adaptive
from mjbiped.reproduction.published import TABLE_3
from mjbiped.reproduction.rows import as_csv, rounded
from mjbiped.terrain.terrain import Terrain

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
        segments: Of the ground.
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
    """Parameters as segments, rounded as a page can print them; the first has no step."""
    table = np.insert(parameters, 2, 0.0).reshape(SEGMENTS, 3)
    return tuple(
        (round(length, 2), round(slope, 1) + 0.0, round(step, 3) + 0.0) for length, slope, step in table.tolist()
    )


def cells(segments: Segments) -> list[Cell]:
    """The walks of a ground in the hybrid engine: to its end from rest, one for each zeta of Table III."""
    terrain, end = Terrain.from_segments(segments), end_of(segments)
    return [Cell("hybrid", adaptive(delay), terrain, initial="rest", steps=None, distance=end) for delay in TABLE_3]


def drawn(count: int = COUNT, seed: int = SEED) -> list[Segments]:
    """Draw grounds whose numbers are uniform between the bounds, and rounded."""
    least, greatest = np.array(bounds()).T
    numbers = np.random.default_rng(seed).uniform(least, greatest, (count, least.size))
    return [segments_of(each) for each in numbers]


def walked(grounds: Iterable[Segments], kept: Walks) -> list[RandomGround]:
    """Walk grounds with every zeta."""
    planned = [(segments, cells(segments)) for segments in grounds]
    results = kept.results(cell for _, walks in planned for cell in walks)
    found = []
    for segments, walks in planned:
        ended = [results[cell.key] for cell in walks]
        if all(each["outcome"] == "finished" for each in ended):
            torques = tuple(rounded(max(each["ankle"], each["hip"])) for each in ended)
            found.append(RandomGround(segments, torques, tuple(rounded(each["absolute_end"]) for each in ended)))
        else:
            found.append(RandomGround(segments))
    return found


def write_grounds(grounds: Iterable[RandomGround]) -> str:
    """Grounds as CSV, a heading first; length (m), slope (degrees) and step (m) of each segment, then their tables."""
    names = [f"{name}_{number}" for number in range(1, SEGMENTS + 1) for name in ("length", "slope", "step")]
    zetas = ["none" if zeta is None else f"{zeta:g}" for zeta in TABLE_3]
    names += [f"{name}_{zeta}" for name in ("torque", "c_mt") for zeta in zetas]
    missing = [""] * len(TABLE_3)
    lines = (
        [*(value for row in each.segments for value in row), *(each.torques or missing), *(each.costs or missing)]
        for each in grounds
    )
    return as_csv(names, lines)
