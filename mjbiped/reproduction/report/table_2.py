"""The part of the report on Table II."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.grounds import (
    AS_PRINTED,
    FIRST_CHANGES,
    FIRST_RISERS,
    GROUNDS,
    SLOPE_PATTERNS,
    STAIR_PATTERNS,
    TABLE_2,
    Place,
)
from mjbiped.reproduction.methods import DELAYS, METHODS, SETTLED, SLOPE_SOURCES
from mjbiped.reproduction.report.markdown import NONE, cost, delay, ending, number, paper, percent, table
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import UNEVEN, Choice, agreements, choices, side_distances, walks_read

_NEAREST = 10  # readings that are listed

Walks: TypeAlias = Mapping[str, Row | None]
"""By method; None where it was not walked."""


def sections(rows: Sequence[Row]) -> dict[str, str]:
    """Fill the template's places about Table II, by name."""
    found = choices(rows)
    best = found[0]
    source = agreements(rows, best)[0].source
    return {
        "readings": str(len(found)),
        "best": _words(best),
        "best_distance": number(100 * best.distance, ".1f"),
        "best_kind": best.kind,
        "best_length": str(best.length),
        "best_delay": delay(best.delay),
        "source": source,
        "stair_patterns": str(len(STAIR_PATTERNS)),
        "slope_patterns": str(len(SLOPE_PATTERNS)),
        "delays_tried": str(len(DELAYS)),
        "lengths": str(len(LENGTHS)),
        "hybrid_steps": str(max(LENGTHS)),
        "nearest": _nearest(found),
        "stairs": _sides(rows, UNEVEN[:2]),
        "slopes": _sides(rows, UNEVEN[2:]),
        "delays": _delays(rows, best),
        "sources": _sources(rows, best),
        "printed": _printed(rows, best),
        "engines": _engines(rows),
        "parted": _parted(rows),
        "engines_apart": _apart(rows),
        "gravity": _gravity(rows, best),
        "every_reading": _every(rows, best, source),
    }


def walk_of(
    rows: Iterable[Row],
    engine: str,
    place: Place,
    method: str,
    zeta: float | None = None,
    source: str = "",
    part: str = "table 2",
) -> Row | None:
    """Find a method's walk on a ground: the adaptive controller's by zeta, others' by slope source."""
    for row in rows:
        right = row.delay == zeta if method == "adaptive" else row.slope_source == source
        if right and (row.part, row.engine, row.method, row.place_read) == (part, engine, method, place):
            return row
    return None


def walks_asked(rows: Sequence[Row], best: Choice, engine: str, ground: str, part: str) -> Walks:
    """Find the walks on which Table II's claims are tested, on a ground as the best reading has it.

    Args:
        rows: Rows of the report.
        best: The reading.
        engine: "hybrid" or "mujoco".
        ground: A ground of the table.
        part: Part of the comparison methods' walks, "blind" or "fitted".
    """
    place = next(place for place in best.places if place[0] == ground)
    walks: dict[str, Row | None] = dict.fromkeys(TABLE_2)
    walks |= {row.method: row for row in walks_read(rows, best, part, engine) if row.ground == ground}
    return {**walks, "adaptive": walk_of(rows, engine, place, "adaptive", best.delay)}


def _words(choice: Choice) -> str:
    """Describe a reading in words."""
    replanned = "no re-planning" if choice.delay is None else f"ζ = {choice.delay:g}"
    return (
        f"{choice.kind} work over the first {choice.length} steps, {replanned}; stairs {choice.stairs[0]}, first riser "
        f"at {choice.stairs[1]:g} m; slopes {choice.slopes[0]}, first change after {choice.slopes[1]:g} m"
    )


def _nearest(found: Sequence[Choice]) -> str:
    lines = [
        [
            f"{choice.stairs[0]}, {choice.stairs[1]:g} m",
            f"{choice.slopes[0]}, {choice.slopes[1]:g} m",
            delay(choice.delay),
            choice.kind,
            str(choice.length),
            number(100 * choice.distance, ".2f"),
        ]
        for choice in found[:_NEAREST]
    ]
    return table(("stairs, first riser", "slopes, first change", "ζ", "work", "steps", "distance %"), lines)


def _sides(rows: Sequence[Row], pair: Sequence[str]) -> str:
    """Tabulate the nearest reading of each pattern of the stairs or of the slopes."""
    nearest: dict[str, tuple[float, float | None, str, int, str, float]] = {}
    for side in sorted(side_distances(rows, pair), key=lambda values: values[0]):
        nearest.setdefault(side[4], side)
    lines = []
    for distance, zeta, kind, length, pattern, first in nearest.values():
        if not math.isfinite(distance):  # a fall, however it is read: in which step is shown for one setting
            zeta, kind, length = 0.8, "absolute", max(LENGTHS)
        walks = [walk_of(rows, "hybrid", (ground, pattern, first), "adaptive", zeta) for ground in pair]
        cells = [f"{first:g} m", delay(zeta), kind, str(length), *(cost(walk, kind, length) for walk in walks)]
        lines.append([pattern, *cells, number(100 * distance, ".1f")])
    papers = [f"{ground}, paper {paper('adaptive', ground)}" for ground in pair]
    return table(("pattern", "first", "ζ", "work", "steps", *papers, "distance %"), lines)


def _delays(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate all zeta on the grounds of the best reading."""
    lines = []
    for zeta in DELAYS:
        walks = [walk_of(rows, "hybrid", place, "adaptive", zeta) for place in best.places]
        torques = "; ".join(NONE if walk is None else number(walk.torque, ".1f") for walk in walks)
        forces = "; ".join(NONE if walk is None else number(walk.least_force, ".2f") for walk in walks)
        lines.append([delay(zeta), *(cost(walk, best.kind, best.length) for walk in walks), torques, forces])
    lines.append(["paper", *(paper("adaptive", ground) for ground in GROUNDS), NONE, NONE])
    return table(("ζ", *GROUNDS, "greatest torques, N m", "least normal forces, weights"), lines)


def _sources(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate all slope sources of the comparison controllers with gains that settle, on the reading's grounds."""
    lines = []
    for method in METHODS[1:]:
        for source in SLOPE_SOURCES:
            walks = [walk_of(rows, "hybrid", place, method, source=source) for place in best.places]
            cells = (cost(walk, best.kind, best.length) for walk in walks)
            lines.append([method, source + (" *" if source == SETTLED[method].slope_source else ""), *cells])
        if method in TABLE_2:
            lines.append([method, "paper", *(paper(method, ground) for ground in GROUNDS)])
    return table(("method", "slope", *GROUNDS), lines)


def _printed(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the grounds with the signs that the paper prints, each change added to the last."""
    lines = []
    for ground in UNEVEN:
        first = FIRST_RISERS[0] if ground.startswith("stair") else FIRST_CHANGES[0]
        place = (ground, AS_PRINTED[ground], first)
        walks = [walk_of(rows, engine, place, "adaptive", best.delay) for engine in ("hybrid", "mujoco")]
        cells = [
            NONE if walk is None else ending(walk) if not walk.finished else cost(walk, best.kind, best.length)
            for walk in walks
        ]
        lines.append([ground, AS_PRINTED[ground], paper("adaptive", ground), *cells])
    return table(("ground", "pattern", "paper", "hybrid", "MuJoCo"), lines)


def _pairs(rows: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Pair the walks of Table II that were made in both engines, the hybrid one first."""
    mine = [row for row in rows if row.part in ("table 2", "blind", "fitted")]
    hybrid = {_identity(row): row for row in mine if row.engine == "hybrid"}
    there = [row for row in mine if row.engine == "mujoco"]
    return [(hybrid[_identity(row)], row) for row in there if _identity(row) in hybrid]


def _ended_alike(here: Row, there: Row) -> bool:
    """Whether both engines walked as far as the shorter walk was to go, or ended in the same step."""
    if there.finished:
        return here.steps >= there.steps
    return not here.finished and here.steps == there.steps


def _parted(rows: Sequence[Row]) -> str:
    """Count the walks that ended differently in the two engines, in words."""
    pairs = _pairs(rows)
    apart = [there for here, there in pairs if not _ended_alike(here, there)]
    if not apart:
        return f"All {len(pairs)} end alike."
    named = "; ".join(dict.fromkeys(f"{row.method} on {row.ground} {row.pattern}" for row in apart))
    return f"{len(apart)} of {len(pairs)} end in another step than in the other engine: {named}."


def _both_costs(here: Row, there: Row) -> list[float]:
    """Return c_mt in both engines over the steps of MuJoCo's walk; empty where one did not come so far."""
    length = there.steps
    if there.finished and here.steps >= length and ("absolute", length) in there.cost:
        return [walk.cost["absolute", length] for walk in (here, there)]
    return []


def _apart(rows: Sequence[Row]) -> str:
    """Describe the difference of the engines' c_mt: median, ninth decile, and the walk that differs most."""
    compared = [(costs, there) for here, there in _pairs(rows) if (costs := _both_costs(here, there))]
    if not compared:
        return "no walk was compared"
    off = np.abs([there / here - 1.0 for (here, there), _ in compared])
    middle, nine_tenths, most = (number(100 * float(np.quantile(off, share)), ".2g") for share in (0.5, 0.9, 1.0))
    last = compared[int(off.argmax())][1]
    named = f"{_law(last)}, on {last.ground} {last.pattern}"
    return (
        f"c_mt of the {len(off)} walks of Table II that come to their end in both differs by {middle} % in the median, "
        f"by up to {nine_tenths} % in nine of ten, and by {most} % at most ({named})"
    )


def _engines(rows: Sequence[Row]) -> str:
    """Tabulate every walk of Table II that was made in both engines."""
    lines = []
    for here, there in _pairs(rows):
        if costs := _both_costs(here, there):
            cells = [*(number(value) for value in costs), percent(costs[1], costs[0], "+.2f")]
        else:
            cells = [*(f"{walk.outcome}, {walk.steps} steps" for walk in (here, there)), NONE]
        lines.append([f"{there.ground} {there.pattern}".strip(), _law(there), *cells])
    return table(("ground", "method", "hybrid", "MuJoCo", "%"), lines) if lines else "No walks in MuJoCo yet."


def _law(row: Row) -> str:
    """Name a method with its settings."""
    if row.method == "adaptive":
        return f"adaptive, ζ = {delay(row.delay)}"
    return f"{row.method}, {row.gains.replace('-', '−')}, {row.slope_source}"


def _identity(row: Row) -> tuple[object, ...]:
    return row.part, row.place_read, row.method, row.delay, row.slope_source


def _gravity(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the best reading with g = 9.8 m/s²."""
    lines = []
    for place in best.places:
        here, there = (
            walk_of(rows, "hybrid", place, "adaptive", best.delay, part=part) for part in ("table 2", "gravity")
        )
        costs = [math.nan if walk is None else walk.cost[best.kind, best.length] for walk in (here, there)]
        printed = paper("adaptive", place[0])
        lines.append(
            [place[0], printed, *(number(value, ".6f") for value in costs), percent(costs[1], costs[0], "+.4f")]
        )
    return table(("ground", "paper", "g = 9.81", "g = 9.8", "%"), lines)


def _every(rows: Sequence[Row], best: Choice, source: str) -> str:
    """Tabulate all readings: the adaptive controller's in full, the others' at the best reading's kind and length."""
    lines = []
    places = dict.fromkeys(row.place_read for row in rows if row.part == "table 2")
    for place in places:
        walks = {method: walk_of(rows, "hybrid", place, method, best.delay, source) for method in METHODS}
        ours = walks["adaptive"]
        kinds = (
            " ".join(cost(ours, kind, length) for length in LENGTHS) if ours is not None else NONE
            for kind in ("absolute", "net", "positive")
        )
        others = (cost(walks[method], best.kind, best.length) for method in METHODS[1:])
        lines.append([f"{place[0]} {place[1]}".strip(), f"{place[2]:g}" if place[1] else NONE, *kinds, *others])
    steps = " ".join(str(length) for length in LENGTHS)
    headings = ("ground", "first, m", *(f"adaptive, {kind}: {steps}" for kind in ("absolute", "net", "positive")))
    return table((*headings, *METHODS[1:]), lines)
