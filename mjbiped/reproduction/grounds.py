"""The paper's tables II and III as printed, and the grounds of section V.

Of Table II's grounds the paper gives the treads' depth, the steps' height, the slopes' length and change. It does not
say whether each step goes the same way, nor where the first one lies: every reading is walked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import TypeAlias

from mjbiped.terrain.terrain import Terrain

IMITATED_SLOPE = math.radians(2.0)
"""Slope of the imitated gait in every simulation of section V, rad."""

STAIRS, SLOPES = ("stair 1", "stair 2"), ("slope 1", "slope 2")
UNEVEN = (*STAIRS, *SLOPES)
GROUNDS = ("level", *UNEVEN)

TREAD = 1.8
"""Depth of the treads of stair 1 and 2, m."""

SLOPE_LENGTH = 1.5
"""Length of the segments of slope 1 and 2, m."""

CHANGES: Mapping[str, float] = {"stair 1": 0.006, "stair 2": 0.06, "slope 1": 0.3, "slope 2": -1.0}
"""Height of a step (m) and change of slope (degrees), with the sign that the paper prints."""

TABLE_2: Mapping[str, Mapping[str, float | None]] = {
    "PBC": {"level": 0.0342, "stair 1": 0.0362, "stair 2": None, "slope 1": 0.0336, "slope 2": None},
    "ECC": {"level": 0.0352, "stair 1": 0.0361, "stair 2": None, "slope 1": 0.0338, "slope 2": 0.0353},
    "KETC": {"level": 0.0350, "stair 1": 0.0363, "stair 2": None, "slope 1": 0.0339, "slope 2": None},
    "adaptive": {"level": 0.0350, "stair 1": 0.0357, "stair 2": 0.0831, "slope 1": 0.0336, "slope 2": 0.0335},
}
"""c_mt by method and ground; None where the paper has an X (instability)."""

ENERGY_BASED = tuple(method for method in TABLE_2 if method != "adaptive")
"""The methods that Table II compares the adaptive controller with."""

DIGITS = 4
"""Decimals of c_mt in the paper's tables."""


def meets(ours: float, paper: float) -> bool:
    """Whether a c_mt agrees with a printed one within half a unit of the last digit."""
    return abs(ours - paper) <= 0.5 * 10.0**-DIGITS


TABLE_3: Mapping[float | None, tuple[float, float]] = {
    None: (98.29, 0.1362),
    0.1: (1141.8, 1.1312),
    0.2: (330.4, 0.3343),
    0.3: (171.2, 0.2058),
    0.4: (112.4, 0.1691),
    0.5: (84.19, 0.1554),
    0.6: (68.48, 0.1486),
    0.7: (58.73, 0.1448),
    0.8: (52.13, 0.1438),
    0.9: (47.43, 0.1459),
    1.0: (46.42, 0.1742),
}
"""Greatest torque (N m) and c_mt by zeta; None: no re-planning."""


Segments = Sequence[tuple[float, float, float]]
"""(length in m, slope in degrees, step up in m) each, as `Terrain.from_segments` takes them."""

Place: TypeAlias = tuple[str, str, float]
"""A ground of Table II as it is read: the ground, its pattern, and its first change, m."""

COUNT = 30
"""Number of steps or changes of slope of a ground: more than 100 steps of 0.38 m can reach."""

FIRST_RISERS = (0.9, 1.8)
"""Positions of the first riser, m: after half a tread, and after a whole one."""

FIRST_CHANGES = (1.5, 0.9)
"""Lengths of the first slope segment, m: as long as the others, and as on the stairs."""

STAIR_PATTERNS: dict[str, Sequence[float]] = {
    "descending": [-1] * COUNT,
    "ascending": [1] * COUNT,
    "alternating, down first": [-1, 1] * (COUNT // 2),
    "alternating, up first": [1, -1] * (COUNT // 2),
}
"""Heights of the risers in units of the step's height."""

SLOPE_PATTERNS: dict[str, Sequence[float]] = {
    "accumulating downhill": range(COUNT),
    "accumulating uphill": [-k for k in range(COUNT)],
    "level and downhill in turn": [0, 1] * (COUNT // 2),
    "level and uphill in turn": [0, -1] * (COUNT // 2),
    "down and up in turn, ±Δ": [1, -1] * (COUNT // 2),
    "up and down in turn, ±Δ": [-1, 1] * (COUNT // 2),
    "down and up in turn, ±Δ/2": [0.5, -0.5] * (COUNT // 2),
    "up and down in turn, ±Δ/2": [-0.5, 0.5] * (COUNT // 2),
}
"""Slopes of the segments in units of the change Δ, downhill positive."""


def changes_of(ground: str) -> tuple[Sequence[float], Mapping[str, Sequence[float]]]:
    """Return the positions of the first change, and the patterns, in which an uneven ground is read."""
    return (FIRST_RISERS, STAIR_PATTERNS) if ground in STAIRS else (FIRST_CHANGES, SLOPE_PATTERNS)


PRINTED: Sequence[Place] = (
    ("stair 1", "ascending", FIRST_RISERS[0]),
    ("stair 2", "ascending", FIRST_RISERS[0]),
    ("slope 1", "accumulating downhill", FIRST_CHANGES[0]),
    ("slope 2", "accumulating uphill", FIRST_CHANGES[0]),
)
"""Readings by the signs of the paper's Fig. 4: steps up positive, slopes downhill positive, each change added."""


@dataclass(frozen=True)
class Reading:
    """A ground of Table II, read in one way.

    Attributes:
        ground: The paper's name of the ground.
        pattern: Pattern of the changes; empty for level ground.
        first: Position of the first change, m; 0 for level ground.
        terrain: The ground.
    """

    ground: str
    pattern: str
    first: float
    terrain: Terrain

    @property
    def place(self) -> Place:
        """Ground, pattern and first change, which identify the reading."""
        return self.ground, self.pattern, self.first


def readings(ground: str) -> list[Reading]:
    """List all readings of a ground of Table II.

    Args:
        ground: One of `mjbiped.reproduction.grounds.GROUNDS`.
    """
    if ground == "level":
        return [Reading(ground, "", 0.0, Terrain.level())]
    change = abs(CHANGES[ground])

    def segments(first: float, factors: Sequence[float]) -> Segments:
        if ground in STAIRS:
            return [(first, 0.0, 0.0), *((TREAD, 0.0, factor * change) for factor in factors)]
        return [(SLOPE_LENGTH if k else first, factor * change, 0.0) for k, factor in enumerate(factors)]

    firsts, patterns = changes_of(ground)
    return [
        Reading(ground, pattern, first, Terrain.from_segments(segments(first, factors), name=ground))
        for first in firsts
        for pattern, factors in patterns.items()
    ]


def reading_at(place: Place) -> Reading:
    """Return the reading with a ground, a pattern and a first change."""
    return next(found for found in readings(place[0]) if found.place == place)


def found_terrain() -> Terrain:
    """Read the mixed ground that comes nearest to Table III from the data file beside this module.

    `scripts/paper/search_table_3.py` found it.
    """
    with resources.as_file(resources.files("mjbiped.reproduction") / "table_3_terrain.toml") as path:
        return Terrain.from_file(path)


def found_segments() -> Segments:
    """Return the segments of the ground that `found_terrain` reads."""
    segments: Segments = dict(found_terrain().parameters)["segments"]
    return segments


def end_of(segments: Segments) -> float:
    """Position x of the end of the last segment, m, at which the walk is finished."""
    return math.fsum(length * math.cos(math.radians(slope)) for length, slope, _ in segments)
