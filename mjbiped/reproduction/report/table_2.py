"""The part of the report on Table II: how its grounds are read, and the walks on them in both engines."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.grounds import GROUNDS, PRINTED, SLOPES, STAIRS, TABLE_2, Place
from mjbiped.reproduction.methods import DELAYS, METHODS, SETTLED, SLOPE_SOURCES
from mjbiped.reproduction.report.markdown import NONE, cost, delay, ending, excess, number, paper
from mjbiped.reproduction.rows import Row, select
from mjbiped.reproduction.table_2 import Choice, agreements, choices, side_distances, walks_read
from mjbiped.utils.markdown import markdown_table

_NEAREST = 10  # readings that are listed

Walks: TypeAlias = Mapping[str, Row | None]
"""By method; None where it was not walked."""


def sections(rows: Sequence[Row]) -> dict[str, str]:
    """Fill the template's places about Table II, by name."""
    found = choices(rows)
    best = found[0]
    source = agreements(rows, best)[0].source
    return {
        "best": _words(best),
        "best_distance": number(100 * best.distance, ".1f"),
        "best_kind": best.kind,
        "best_length": str(best.length),
        "best_delay": delay(best.delay),
        "source": source,
        "nearest": _nearest(found),
        "stairs": _sides(rows, STAIRS),
        "slopes": _sides(rows, SLOPES),
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
    setting: float | str | None,
    part: str = "table 2",
) -> Row | None:
    """Find a method's walk on a ground.

    Args:
        rows: Rows of the report.
        engine: "hybrid" or "mujoco".
        place: Ground, pattern and first change.
        method: One of `METHODS`.
        setting: zeta of the adaptive controller, slope source of another one.
        part: Part of the report that needs the walk.
    """
    name = "delay" if method == "adaptive" else "slope_source"
    walks = select(rows, part=part, engine=engine, method=method, place_read=place, **{name: setting})
    return walks[0] if walks else None


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
    lines = []
    for choice in found[:_NEAREST]:
        changes = (f"{pattern}, {first:g} m" for pattern, first in (choice.stairs, choice.slopes))
        distance = number(100 * choice.distance, ".2f")
        lines.append([*changes, delay(choice.delay), choice.kind, str(choice.length), distance])
    return markdown_table(("stairs, first riser", "slopes, first change", "ζ", "work", "steps", "distance %"), lines, 1)


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
    return markdown_table(("pattern", "first", "ζ", "work", "steps", *papers, "distance %"), lines, 1)


def _delays(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate all zeta on the grounds of the best reading."""
    lines = []
    for zeta in DELAYS:
        walks = [walk_of(rows, "hybrid", place, "adaptive", zeta) for place in best.places]
        torques, forces = (
            "; ".join(NONE if walk is None else number(getattr(walk, name), form) for walk in walks)
            for name, form in (("torque", ".1f"), ("least_force", ".2f"))
        )
        lines.append([delay(zeta), *(cost(walk, best.kind, best.length) for walk in walks), torques, forces])
    lines.append(["paper", *(paper("adaptive", ground) for ground in GROUNDS), NONE, NONE])
    return markdown_table(("ζ", *GROUNDS, "greatest torques, N m", "least normal forces, weights"), lines, 1)


def _sources(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate all slope sources of the comparison controllers with gains that settle, on the reading's grounds."""
    lines = []
    for method in METHODS[1:]:
        for source in SLOPE_SOURCES:
            walks = [walk_of(rows, "hybrid", place, method, source) for place in best.places]
            cells = (cost(walk, best.kind, best.length) for walk in walks)
            lines.append([method, source + (" *" if source == SETTLED[method].slope_source else ""), *cells])
        if method in TABLE_2:
            lines.append([method, "paper", *(paper(method, ground) for ground in GROUNDS)])
    return markdown_table(("method", "slope", *GROUNDS), lines, 1)


def _printed(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the grounds with the signs that the paper prints, each change added to the last."""
    lines = []
    for place in PRINTED:
        walks = [walk_of(rows, engine, place, "adaptive", best.delay) for engine in ("hybrid", "mujoco")]
        ends = (ending(walk, cost(walk, best.kind, best.length)) for walk in walks)
        lines.append([*place[:2], paper("adaptive", place[0]), *ends])
    return markdown_table(("ground", "pattern", "paper", "hybrid", "MuJoCo"), lines, 1)


def _pairs(rows: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Pair the walks of Table II that were made in both engines, the hybrid one first."""
    mine = [row for row in rows if row.part in ("table 2", "blind", "fitted")]
    here, there = (
        {
            (row.part, row.place_read, row.method, row.delay, row.slope_source): row
            for row in select(mine, engine=engine)
        }
        for engine in ("hybrid", "mujoco")
    )
    return [(here[key], row) for key, row in there.items() if key in here]


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
    return (
        f"c_mt of the {len(off)} walks of Table II that come to their end in both differs by {middle} % in the median, "
        f"by up to {nine_tenths} % in nine of ten, and by {most} % at most ({_law(last)}, on {last.ground} "
        f"{last.pattern})"
    )


def _engines(rows: Sequence[Row]) -> str:
    """Tabulate every walk of Table II that was made in both engines."""
    lines = []
    for here, there in _pairs(rows):
        if costs := _both_costs(here, there):
            cells = [*map(number, costs), excess(costs[1], costs[0], "+.2f")]
        else:
            cells = [*(f"{walk.outcome}, {walk.steps} steps" for walk in (here, there)), NONE]
        lines.append([f"{there.ground} {there.pattern}".strip(), _law(there), *cells])
    if not lines:
        return "No walks in MuJoCo yet."
    return markdown_table(("ground", "method", "hybrid", "MuJoCo", "%"), lines, 1)


def _law(row: Row) -> str:
    """Name a method with its settings."""
    if row.method == "adaptive":
        return f"adaptive, ζ = {delay(row.delay)}"
    return f"{row.method}, {row.gains.replace('-', '−')}, {row.slope_source}"


def _gravity(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the best reading with g = 9.8 m/s²."""
    lines = []
    for place in best.places:
        walks = (walk_of(rows, "hybrid", place, "adaptive", best.delay, part) for part in ("table 2", "gravity"))
        here, there = (math.nan if walk is None else walk.cost[best.kind, best.length] for walk in walks)
        cells = number(here, ".6f"), number(there, ".6f"), excess(there, here, "+.4f")
        lines.append([place[0], paper("adaptive", place[0]), *cells])
    return markdown_table(("ground", "paper", "g = 9.81", "g = 9.8", "%"), lines, 1)


def _every(rows: Sequence[Row], best: Choice, source: str) -> str:
    """Tabulate all readings: the adaptive controller's in full, the others' at the best reading's kind and length."""
    lines = []
    for place in dict.fromkeys(row.place_read for row in select(rows, part="table 2")):
        ours = walk_of(rows, "hybrid", place, "adaptive", best.delay)
        kinds = (NONE if ours is None else " ".join(cost(ours, kind, n) for n in LENGTHS) for kind in WORK_KINDS)
        walks = (walk_of(rows, "hybrid", place, method, source) for method in METHODS[1:])
        others = (cost(walk, best.kind, best.length) for walk in walks)
        lines.append([f"{place[0]} {place[1]}".strip(), f"{place[2]:g}" if place[1] else NONE, *kinds, *others])
    steps = " ".join(map(str, LENGTHS))
    kinds = (f"adaptive, {kind}: {steps}" for kind in WORK_KINDS)
    return markdown_table(("ground", "first, m", *kinds, *METHODS[1:]), lines, 1)
