"""The mixed ground on which Table III comes out nearest; `mjbiped.reproduction.search` found it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib import resources

from mjbiped.terrain.terrain import Terrain

Segments = Sequence[tuple[float, float, float]]
"""(length in m, slope in degrees, step up in m) each, as `Terrain.from_segments` takes them."""


def found_terrain() -> Terrain:
    """The ground, of the data file beside this module."""
    with resources.as_file(resources.files("mjbiped.reproduction") / "table_3_terrain.toml") as path:
        return Terrain.from_file(path)


def found_segments() -> Segments:
    """Its segments."""
    segments: Segments = dict(found_terrain().parameters)["segments"]
    return segments


def end_of(segments: Segments) -> float:
    """Place x of the end of the last segment, m: where the ground has been walked."""
    return math.fsum(length * math.cos(math.radians(slope)) for length, slope, _ in segments)
