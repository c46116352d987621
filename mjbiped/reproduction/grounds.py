"""The paper's tables II and III as printed, and the grounds of section V.

Of Table II's grounds the paper gives the treads' depth, the steps' height, the slopes' length and change. It does not
say whether each step goes the same way, nor where the first one lies: every reading is walked.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from importlib import resources
from itertools import cycle, islice
from typing import Any, TypeAlias

from mjbiped.terrain.terrain import Terrain

FILES = resources.files("mjbiped.reproduction")
SECTION_5: Mapping[str, Any] = tomllib.loads((FILES / "section_5.toml").read_text(encoding="utf-8"))
"""The paper's tables and the methods' settings."""

IMITATED_SLOPE = math.radians(2.0)
"""Slope of the imitated gait in every simulation of section V, rad."""

STAIRS, SLOPES = ("stair 1", "stair 2"), ("slope 1", "slope 2")
UNEVEN = (*STAIRS, *SLOPES)
GROUNDS = ("level", *UNEVEN)

CHANGES: Mapping[str, float] = SECTION_5["grounds"]["changes"]
"""Height of a step (m) and size of a change of slope (degrees), by ground."""

TABLE_2: Mapping[str, Mapping[str, float | None]] = {
    method: {ground: None if cost == "X" else cost for ground, cost in zip(GROUNDS, costs, strict=True)}
    for method, costs in SECTION_5["table_2"].items()
}
"""c_mt by method and ground; None where the paper has an X (instability)."""

ENERGY_BASED = tuple(method for method in TABLE_2 if method != "adaptive")
"""The methods that Table II compares the adaptive controller with."""

TABLE_3: Mapping[float | None, tuple[float, float]] = {
    None if zeta == "none" else zeta: (torque, cost) for zeta, torque, cost in SECTION_5["table_3"]["rows"]
}
"""Greatest torque (N m) and c_mt by zeta; None: no re-planning."""

DIGITS = 4
"""Decimals of c_mt in the paper's tables."""

Segments = Sequence[tuple[float, float, float]]
"""(length in m, slope in degrees, step up in m) each, as `Terrain.from_segments` takes them."""

PLACE = ("ground", "pattern", "first")
Place: TypeAlias = tuple[str, str, float]
"""A ground of Table II as it is read: the ground, its pattern, and the position of its first change, m."""

LEVEL: Place = ("level", "", 0.0)

COUNT = 30
"""Number of steps or changes of slope of a ground: more than 100 steps of 0.38 m can reach."""

FIRST_RISERS, FIRST_CHANGES = (SECTION_5[kind]["first"] for kind in ("stairs", "slopes"))
"""Positions of the first riser, and lengths of the first slope segment, m."""

STAIR_PATTERNS, SLOPE_PATTERNS = (
    {name: [*islice(cycle(turns), COUNT)] for name, turns in SECTION_5[kind]["patterns"].items()}
    for kind in ("stairs", "slopes")
)
"""Heights of the risers in units of the step's height, and slopes of the segments in units of the change Δ, downhill
positive."""

READINGS: Sequence[Place] = [
    LEVEL,
    *((ground, pattern, x) for ground in STAIRS for x in FIRST_RISERS for pattern in STAIR_PATTERNS),
    *((ground, pattern, x) for ground in SLOPES for x in FIRST_CHANGES for pattern in SLOPE_PATTERNS),
]
"""All readings of Table II's grounds."""

PRINTED: Sequence[Place] = [(ground, pattern, first) for ground, pattern, first in SECTION_5["grounds"]["printed"]]
"""Readings by the signs of the paper's Fig. 4: steps up positive, slopes downhill positive, each change added."""


def meets(ours: float, paper: float) -> bool:
    """Whether a c_mt agrees with a printed one within half a unit of the last digit."""
    return abs(ours - paper) <= 0.5 * 10.0**-DIGITS


def terrain_of(place: Place) -> Terrain:
    """Make a ground of Table II as it is read."""
    ground, pattern, first = place
    if place == LEVEL:
        return Terrain.level()
    change = CHANGES[ground]
    if ground in STAIRS:
        risers = ((SECTION_5["stairs"]["length"], 0.0, factor * change) for factor in STAIR_PATTERNS[pattern])
        return Terrain.from_segments([(first, 0.0, 0.0), *risers], name=ground)
    lengths = [first, *[SECTION_5["slopes"]["length"]] * (COUNT - 1)]
    slopes = zip(lengths, SLOPE_PATTERNS[pattern], strict=True)
    return Terrain.from_segments([(length, factor * change, 0.0) for length, factor in slopes], name=ground)


def found_terrain() -> Terrain:
    """Read the mixed ground that comes nearest to Table III, which `scripts/paper/search_table_3.py` found."""
    with resources.as_file(FILES / "table_3_terrain.toml") as path:
        return Terrain.from_file(path)


def found_segments() -> Segments:
    """Return the segments of the ground that `found_terrain` reads."""
    segments: Segments = dict(found_terrain().parameters)["segments"]
    return segments


def end_of(segments: Segments) -> float:
    """Position x of the end of the last segment, m, at which the walk is finished."""
    return math.fsum(length * math.cos(math.radians(slope)) for length, slope, _ in segments)
