"""The part of the report on Table II: how its grounds are read, and the walks on them in both engines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.grounds import GROUNDS, PRINTED, SLOPES, STAIRS, TABLE_2
from mjbiped.reproduction.methods import DELAYS, METHODS, SETTLED, SLOPE_SOURCES
from mjbiped.reproduction.report.markdown import (
    ENGINES,
    NONE,
    best_cost,
    body,
    cost,
    delay,
    ending,
    excess,
    number,
    paper,
)
from mjbiped.reproduction.rows import LENGTHS, Row, find, select
from mjbiped.reproduction.table_2 import Choice, side_distances, sources_ranked, walk_on

_NEAREST = 10  # readings that are listed

Lines = Iterator[list[str]]


def sections(rows: Sequence[Row], found: Sequence[Choice]) -> dict[str, str]:
    """Fill the template's places about Table II, by name.

    Args:
        rows: Rows of the report.
        found: The readings, the best one first.
    """
    best = found[0]
    source = sources_ranked(rows, best)[0]
    pairs = _pairs(rows)
    tables = {
        "nearest": _nearest(found),
        "stairs": _sides(rows, STAIRS),
        "slopes": _sides(rows, SLOPES),
        "delays": _delays(rows, best),
        "sources": _sources(rows, best),
        "printed": _printed(rows, best),
        "engines": _engines(pairs),
        "gravity": _gravity(rows, best),
        "every_reading": _every(rows, best, source),
    }
    return {
        "best": _words(best),
        "best_distance": number(100 * best.distance, ".1f"),
        "best_kind": best.kind,
        "best_length": str(best.length),
        "best_delay": delay(best.delay),
        "source": source,
        "parted": _parted(pairs),
        "engines_apart": _apart(pairs),
        **{name: body(lines) for name, lines in tables.items()},
    }


def _words(choice: Choice) -> str:
    """Describe a reading in words."""
    replanned = "no re-planning" if choice.delay is None else f"ζ = {choice.delay:g}"
    return (
        f"{choice.kind} work over the first {choice.length} steps, {replanned}; stairs {choice.stairs[0]}, first riser "
        f"at {choice.stairs[1]:g} m; slopes {choice.slopes[0]}, first change after {choice.slopes[1]:g} m"
    )


def _nearest(found: Sequence[Choice]) -> Lines:
    for choice in found[:_NEAREST]:
        changes = (f"{pattern}, {first:g} m" for pattern, first in (choice.stairs, choice.slopes))
        distance = number(100 * choice.distance, ".2f")
        yield [*changes, delay(choice.delay), choice.kind, str(choice.length), distance]


def _sides(rows: Sequence[Row], pair: Sequence[str]) -> Lines:
    """Tabulate the nearest reading of each pattern of the stairs or of the slopes."""
    nearest: dict[str, Choice] = {}
    for side in sorted(side_distances(rows, pair), key=lambda side: side.distance):
        nearest.setdefault(side.stairs[0], side)
    for pattern, side in nearest.items():
        if not math.isfinite(side.distance):  # a fall, however it is read: in which step is shown for one setting
            side = replace(side, delay=0.8, kind="absolute", length=max(LENGTHS))
        walks = (walk_on(rows, side, "hybrid", (ground, *side.stairs), "adaptive", "") for ground in pair)
        cells = [f"{side.stairs[1]:g} m", delay(side.delay), side.kind, str(side.length)]
        yield [pattern, *cells, *(best_cost(walk, side) for walk in walks), number(100 * side.distance, ".1f")]


def _delays(rows: Sequence[Row], best: Choice) -> Lines:
    """Tabulate all zeta on the grounds of the best reading."""
    for zeta in DELAYS:
        mine = replace(best, delay=zeta)
        walks = [walk_on(rows, mine, "hybrid", place, "adaptive", "") for place in best.places]
        torques = "; ".join(number(walk.torque, ".1f") for walk in walks)
        forces = "; ".join(number(walk.least_force, ".2f") for walk in walks)
        yield [delay(zeta), *(best_cost(walk, best) for walk in walks), torques, forces]
    yield ["paper", *(paper("adaptive", ground) for ground in GROUNDS), NONE, NONE]


def _sources(rows: Sequence[Row], best: Choice) -> Lines:
    """Tabulate all slope sources of the comparison controllers with gains that settle, on the reading's grounds."""
    for method, variant in SETTLED.items():
        for source in SLOPE_SOURCES:
            walks = (walk_on(rows, best, "hybrid", place, method, source) for place in best.places)
            name = source + " *" * (source == variant.slope_source)
            yield [method, name, *(best_cost(walk, best) for walk in walks)]
        if method in TABLE_2:
            yield [method, "paper", *(paper(method, ground) for ground in GROUNDS)]


def _printed(rows: Sequence[Row], best: Choice) -> Lines:
    """Tabulate the grounds with the signs that the paper prints, each change added to the last."""
    for place in PRINTED:
        walks = [walk_on(rows, best, engine, place, "adaptive", "") for engine in ENGINES]
        yield [*place[:2], paper("adaptive", place[0]), *(ending(walk, best_cost(walk, best)) for walk in walks)]


Pairs = Sequence[tuple[Row, Row]]
"""Walks of Table II that were made in both engines, the hybrid one first."""


def _pairs(rows: Sequence[Row]) -> Pairs:
    mine = [row for row in rows if row.part in ("table 2", "blind", "fitted")]
    here, there = (
        {
            (row.part, row.place_read, row.method, row.delay, row.slope_source): row
            for row in select(mine, engine=engine)
        }
        for engine in ENGINES
    )
    return [(here[key], row) for key, row in there.items()]


def _ended_alike(here: Row, there: Row) -> bool:
    """Whether both engines walked as far as the shorter walk was to go, or ended in the same step."""
    if there.finished:
        return bool(here.steps >= there.steps)
    return not here.finished and bool(here.steps == there.steps)


def _parted(pairs: Pairs) -> str:
    """Count the walks that ended differently in the two engines, in words."""
    apart = [there for here, there in pairs if not _ended_alike(here, there)]
    if not apart:
        return f"All {len(pairs)} end alike."
    named = "; ".join(dict.fromkeys(f"{row.method} on {row.ground} {row.pattern}" for row in apart))
    return f"{len(apart)} of {len(pairs)} end in another step than in the other engine: {named}."


def _both_costs(here: Row, there: Row) -> list[float]:
    """Return c_mt in both engines over the steps of MuJoCo's walk; empty where one did not come so far."""
    if there.finished and here.steps >= there.steps and there.steps in LENGTHS:
        return [float(getattr(walk, f"absolute_{there.steps}")) for walk in (here, there)]
    return []


def _apart(pairs: Pairs) -> str:
    """Describe the difference of the engines' c_mt: median, ninth decile, and the walk that differs most."""
    compared = [(costs, there) for here, there in pairs if (costs := _both_costs(here, there))]
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


def _engines(pairs: Pairs) -> Lines:
    """Tabulate every walk of Table II that was made in both engines."""
    for here, there in pairs:
        cells = [*(f"{walk.outcome}, {walk.steps} steps" for walk in (here, there)), NONE]
        if costs := _both_costs(here, there):
            cells = [*map(number, costs), excess(costs[1], costs[0], "+.2f")]
        yield [f"{there.ground} {there.pattern}".strip(), _law(there), *cells]


def _law(row: Row) -> str:
    """Name a method with its settings."""
    if row.method == "adaptive":
        return f"adaptive, ζ = {delay(row.delay)}"
    return f"{row.method}, {row.gains.replace('-', '−')}, {row.slope_source}"


def _gravity(rows: Sequence[Row], best: Choice) -> Lines:
    """Tabulate the best reading with g = 9.8 m/s²."""
    for place in best.places:
        here = best.cost(walk_on(rows, best, "hybrid", place, "adaptive", ""))
        there = best.cost(find(rows, part="gravity", place_read=place))
        cells = number(here, ".6f"), number(there, ".6f"), excess(there, here, "+.4f")
        yield [place[0], paper("adaptive", place[0]), *cells]


def _every(rows: Sequence[Row], best: Choice, source: str) -> Lines:
    """Tabulate all readings: the adaptive controller's in full, the others' at the best reading's kind and length."""
    for place in dict.fromkeys(row.place_read for row in select(rows, part="table 2")):
        ours, *walks = (walk_on(rows, best, "hybrid", place, method, source) for method in METHODS)
        kinds = (" ".join(cost(ours, kind, length) for length in LENGTHS) for kind in WORK_KINDS)
        first = f"{place[2]:g}" if place[1] else NONE
        yield [f"{place[0]} {place[1]}".strip(), first, *kinds, *(best_cost(walk, best) for walk in walks)]
