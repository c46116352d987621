"""The walks of the reproduction: the cells behind each table and figure."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import Any

from mjbiped.reproduction.cell import cell
from mjbiped.reproduction.grounds import (
    PLACE,
    READINGS,
    TABLE_3,
    Place,
    end_of,
    found_segments,
    found_terrain,
    terrain_of,
)
from mjbiped.reproduction.methods import FITTED, Variant, adaptive, variants
from mjbiped.reproduction.rows import LENGTHS
from mjbiped.reproduction.table_2 import Choice
from mjbiped.sweeps.cell import Cell
from mjbiped.terrain.terrain import Terrain

DRAWN_DELAYS = (0.4, 0.8, None)
"""Values of zeta in Fig. 6; Fig. 4 has the second."""

PAPER_GAIN = 0.3
"""Value of gamma in section V-B."""

ADAPTATION_GAINS = (0.03, PAPER_GAIN, 3.0, 30.0)
"""Values of gamma in Fig. 5."""

START_ESTIMATES = (3.0, -3.0)
"""Slope estimates at the start of Fig. 5, degrees, on ground that begins level; Fig. 4 has the first."""

START_ERROR = 0.05
"""Error of the start slope that the comparison methods are given, degrees, to test how well a fit bears it."""

MIXED_STEPS = 60
OTHER_GRAVITY = 9.8  # m/s²


def on_table_2(
    part: str,
    engine: str,
    places: Iterable[Place],
    chosen: Collection[Variant],
    steps: int = max(LENGTHS),
    **robot: Any,
) -> list[Cell]:
    """List the walks of some variants of the methods on some of Table II's grounds as they are read."""
    read: list[tuple[Terrain, dict[str, Any]]] = [
        (terrain_of(place), dict(zip(PLACE, place, strict=True))) for place in places
    ]
    return [
        cell(ground, each.law(ground), steps=steps, engine=engine, method=each.method, part=part, **place, **robot)
        for ground, place in read
        for each in chosen
    ]


def table_2() -> list[Cell]:
    """List the walks of every variant of every method on every reading of every ground, in the hybrid engine."""
    return on_table_2("table 2", "hybrid", READINGS, [*variants()])


def misjudged(best: Choice) -> list[Cell]:
    """List the fitted settings' walks with a start slope wrong by `START_ERROR` either way, in the hybrid engine."""
    wrong = [replace(each, start_error=sign * START_ERROR) for each in FITTED.values() for sign in (1.0, -1.0)]
    return on_table_2("misjudged", "hybrid", best.places, wrong)


def gravity(best: Choice) -> list[Cell]:
    """List the adaptive controller's walks on the best reading with g = 9.8 m/s²."""
    mine, robot = [Variant("adaptive", best.delay)], dict[str, Any]({"robot.gravity": OTHER_GRAVITY})
    return on_table_2("gravity", "hybrid", best.places, mine, **robot)


def table_3(engine: str) -> list[Cell]:
    """List the walks of Table III on our mixed ground and on the one found; those of Fig. 6 keep records."""
    role: dict[str, Any] = {"engine": engine, "initial": "rest", "part": "table 3"}
    drawn = {delay: {**role, "record": delay in DRAWN_DELAYS} for delay in TABLE_3}
    mixed, found, end = Terrain.mixed(), found_terrain(), end_of(found_segments())
    return [
        *(cell(mixed, adaptive(delay), steps=MIXED_STEPS, ground="mixed", **mine) for delay, mine in drawn.items()),
        *(cell(found, adaptive(delay), distance=end, ground="found", **mine) for delay, mine in drawn.items()),
    ]


def start() -> list[Cell]:
    """List the first step alone of Table III's walks: from rest on level ground, in the hybrid engine."""
    role: dict[str, Any] = {"engine": "hybrid", "initial": "rest", "part": "start", "ground": "level"}
    return [cell(Terrain.level(), adaptive(delay), steps=1, **role) for delay in TABLE_3]


def figure_5(engine: str) -> list[Cell]:
    """List the walks of Fig. 5: with and without the estimate update, from estimates that are wrong either way.

    From a right one the adaptive law (17) would have nothing to do, for the update (27) keeps it right.
    """
    laws = [
        adaptive(DRAWN_DELAYS[1], adaptation_gain=gain, estimate_update=update, initial_slope_estimate_deg=start)
        for gain in ADAPTATION_GAINS
        for start in START_ESTIMATES
        for update in (True, False)
    ]
    role: dict[str, Any] = {"engine": engine, "initial": "rest", "part": "figure 5", "ground": "mixed", "record": True}
    return [cell(Terrain.mixed(), law, steps=MIXED_STEPS, **role) for law in laws]
