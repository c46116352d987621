"""The walks of the reproduction: the cells behind each table and figure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from mjbiped.reproduction.cell import LENGTHS, Cell
from mjbiped.reproduction.grounds import (
    GROUNDS,
    TABLE_3,
    Place,
    Reading,
    end_of,
    found_segments,
    found_terrain,
    reading_at,
    readings,
)
from mjbiped.reproduction.methods import METHODS, Variant, adaptive, variants
from mjbiped.reproduction.rows import Entry
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


def table_2(grounds: Iterable[str] = GROUNDS, methods: Iterable[str] = METHODS) -> list[Entry]:
    """List the walks of every variant of every method on every reading of every ground, in the hybrid engine."""
    chosen = [variant for method in methods for variant in variants(method)]
    return [
        _walked("table 2", "hybrid", reading, variant, max(LENGTHS))
        for ground in grounds
        for reading in readings(ground)
        for variant in chosen
    ]


def table_2_in_mujoco(places: Iterable[Place], chosen: Iterable[Variant], steps: int) -> list[Entry]:
    """List the walks of some variants on some readings, given by ground, pattern and first change, in MuJoCo."""
    chosen = list(chosen)
    return [
        _walked("table 2", "mujoco", reading, variant, steps) for reading in _readings(places) for variant in chosen
    ]


def compared(part: str, choice: Choice, chosen: Iterable[Variant], engine: str, steps: int) -> list[Entry]:
    """List the walks of the comparison methods on the grounds of the chosen reading.

    Args:
        part: "fitted" for those nearest to Table II, "blind" for `mjbiped.reproduction.methods.BLIND`, "misjudged" for
            those that are told a wrong slope at the start.
        choice: The reading.
        chosen: The settings.
        engine: "hybrid" or "mujoco".
        steps: Number of steps of each walk.
    """
    chosen = list(chosen)
    return [_walked(part, engine, reading_at(place), variant, steps) for place in choice.places for variant in chosen]


def misjudged(choice: Choice, chosen: Iterable[Variant]) -> list[Entry]:
    """List the walks with a start slope wrong by `START_ERROR` either way, in the hybrid engine."""
    wrong = [replace(variant, start_error=sign * START_ERROR) for variant in chosen for sign in (1.0, -1.0)]
    return compared("misjudged", choice, wrong, "hybrid", max(LENGTHS))


def gravity(places: Iterable[Place], delay: float | None) -> list[Entry]:
    """List the adaptive controller's walks on some readings with g = 9.8 m/s²."""
    mine, robot = Variant("adaptive", delay), Compass(gravity=OTHER_GRAVITY)
    return [_walked("gravity", "hybrid", reading, mine, max(LENGTHS), robot) for reading in _readings(places)]


def table_3(engine: str) -> list[Entry]:
    """List the walks of Table III on our mixed ground and on the one found; those of Fig. 6 keep records."""
    mixed = ("mixed", Terrain.mixed(), MIXED_STEPS, None)
    found = ("found", found_terrain(), None, end_of(found_segments()))
    entries = []
    for ground, terrain, steps, distance in (mixed, found):
        for delay in TABLE_3:
            cell = Cell(engine, adaptive(delay), terrain, "rest", steps, distance, record=delay in DRAWN_DELAYS)
            entries.append(Entry("table 3", ground, "adaptive", cell))
    return entries


def start() -> list[Entry]:
    """List the first step alone of Table III's walks: from rest on level ground, in the hybrid engine."""
    cells = [Cell("hybrid", adaptive(delay), Terrain.level(), "rest", 1) for delay in TABLE_3]
    return [Entry("start", "level", "adaptive", cell) for cell in cells]


def figure_5(engine: str, gains: Iterable[float] = ADAPTATION_GAINS) -> list[Entry]:
    """List the walks of Fig. 5: with and without the estimate update, from estimates that are wrong either way.

    From a right one the adaptive law (17) would have nothing to do, for the update (27) keeps it right.
    """
    laws = [
        adaptive(DRAWN_DELAYS[1], adaptation_gain=gain, estimate_update=update, initial_slope_estimate_deg=start)
        for gain in gains
        for start in START_ESTIMATES
        for update in (True, False)
    ]
    cells = [Cell(engine, law, Terrain.mixed(), "rest", MIXED_STEPS, record=True) for law in laws]
    return [Entry("figure 5", "mixed", "adaptive", cell) for cell in cells]


def _readings(places: Iterable[Place]) -> list[Reading]:
    """List the readings at some places, in the order of the table."""
    wanted = set(places)
    return [reading for ground in GROUNDS for reading in readings(ground) if reading.place in wanted]


def _walked(
    part: str, engine: str, reading: Reading, variant: Variant, steps: int, robot: Compass | None = None
) -> Entry:
    controller = variant.controller(reading.terrain, robot)
    cell = Cell(engine, controller, reading.terrain, steps=steps)
    return Entry(part, reading.ground, variant.method, cell, reading.pattern, reading.first)
