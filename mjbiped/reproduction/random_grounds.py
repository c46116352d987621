"""Grounds drawn at random from the family in which Table III's ground was searched, and their own Tables III.

They tell what it is worth that a ground meets the table: see `mjbiped.reproduction.placebo`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mjbiped.reproduction import search
from mjbiped.reproduction.grounds import Segments
from mjbiped.reproduction.published import TABLE_3
from mjbiped.reproduction.rows import as_csv, rounded
from mjbiped.reproduction.walks import Walks

COUNT = 300
SEED = 0


@dataclass(frozen=True)
class RandomGround:
    """A ground and what the adaptive controller makes of it from rest, in the hybrid engine.

    Attributes:
        segments: Of the ground.
        torques: Greatest torque of either joint by zeta, in Table III's order, N m, six digits; empty where one of the
            walks did not come to its end.
        costs: c_mt, likewise.
    """

    segments: Segments
    torques: tuple[float, ...] = ()
    costs: tuple[float, ...] = ()


def drawn(count: int = COUNT, seed: int = SEED) -> list[Segments]:
    """Grounds whose numbers are uniform between the bounds of the search, and rounded as its are."""
    least, greatest = np.array(search.bounds()).T
    numbers = np.random.default_rng(seed).uniform(least, greatest, (count, least.size))
    return [search.segments_of(each) for each in numbers]


def walked(
    grounds: Iterable[Segments], kept: Walks, *, workers: int | None = None, progress: bool = False
) -> list[RandomGround]:
    """Let the adaptive controller walk them with every zeta; arguments as of `Walks.results`."""
    cells = [(segments, search.cells(segments)) for segments in grounds]
    every = (cell for _, walks in cells for cell in walks)
    results = kept.results(every, workers=workers, progress=progress)
    found = []
    for segments, walks in cells:
        ended = [results[cell.key] for cell in walks]
        if all(each.outcome == "finished" for each in ended):
            torques = tuple(rounded(max(each.peak_torque)) for each in ended)
            costs = tuple(rounded(each.cost_of_transport("absolute")) for each in ended)
            found.append(RandomGround(segments, torques, costs))
        else:
            found.append(RandomGround(segments))
    return found


def write_grounds(grounds: Iterable[RandomGround]) -> str:
    """Grounds as CSV, a heading first; length (m), slope (degrees) and step (m) of each segment, then their tables."""
    names = [f"{name}_{number}" for number in range(1, search.SEGMENTS + 1) for name in ("length", "slope", "step")]
    zetas = ["none" if zeta is None else f"{zeta:g}" for zeta in TABLE_3]
    names += [f"{name}_{zeta}" for name in ("torque", "c_mt") for zeta in zetas]
    missing = [""] * len(TABLE_3)
    lines = (
        [*(value for row in each.segments for value in row), *(each.torques or missing), *(each.costs or missing)]
        for each in grounds
    )
    return as_csv(names, lines)
