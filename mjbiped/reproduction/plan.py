"""The walks of the reproduction: the cells behind each table and figure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

from mjbiped.reproduction.cell import Cell
from mjbiped.reproduction.grounds import READINGS, TABLE_3, Place, end_of, found_segments, found_terrain, terrain_of
from mjbiped.reproduction.methods import FITTED, Variant, adaptive, variants
from mjbiped.reproduction.rows import LENGTHS
from mjbiped.reproduction.table_2 import Choice
from mjbiped.robots.compass import Compass
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
    chosen: Iterable[Variant],
    steps: int = max(LENGTHS),
    robot: Compass | None = None,
) -> list[Cell]:
    """List the walks of some variants of the methods on some of Table II's grounds as they are read."""
    chosen = list(chosen)
    return [
        Cell(engine, law(terrain, robot), terrain, "gait", steps, None, False, method, part, *place)
        for place, terrain in ((place, terrain_of(place)) for place in places)
        for law, method in ((variant.controller, variant.method) for variant in chosen)
    ]


def table_2() -> list[Cell]:
    """List the walks of every variant of every method on every reading of every ground, in the hybrid engine."""
    return on_table_2("table 2", "hybrid", READINGS, variants())


def misjudged(best: Choice) -> list[Cell]:
    """List the fitted settings' walks with a start slope wrong by `START_ERROR` either way, in the hybrid engine."""
    wrong = [replace(each, start_error=sign * START_ERROR) for each in FITTED.values() for sign in (1.0, -1.0)]
    return on_table_2("misjudged", "hybrid", best.places, wrong)


def gravity(best: Choice) -> list[Cell]:
    """List the adaptive controller's walks on the best reading with g = 9.8 m/s²."""
    mine, robot = [Variant("adaptive", best.delay)], Compass(gravity=OTHER_GRAVITY)
    return on_table_2("gravity", "hybrid", best.places, mine, robot=robot)


def table_3(engine: str) -> list[Cell]:
    """List the walks of Table III on our mixed ground and on the one found; those of Fig. 6 keep records."""
    mixed = ("mixed", Terrain.mixed(), MIXED_STEPS, None)
    found = ("found", found_terrain(), None, end_of(found_segments()))
    return [
        Cell(engine, adaptive(delay), terrain, "rest", steps, to, delay in DRAWN_DELAYS, "adaptive", "table 3", ground)
        for ground, terrain, steps, to in (mixed, found)
        for delay in TABLE_3
    ]


def start() -> list[Cell]:
    """List the first step alone of Table III's walks: from rest on level ground, in the hybrid engine."""
    first = partial(Cell, part="start", ground="level")
    return [first("hybrid", adaptive(delay), Terrain.level(), "rest", 1) for delay in TABLE_3]


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
    drawn = partial(Cell, record=True, part="figure 5", ground="mixed")
    return [drawn(engine, law, Terrain.mixed(), "rest", MIXED_STEPS) for law in laws]
