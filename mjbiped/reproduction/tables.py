"""The report's tables about Table II and the claims, which the templates of its pages name."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction import section_5 as paper
from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.claims import COUNTING, GROUPS, Answer, by_claim, missed
from mjbiped.reproduction.rows import (
    ENGINES,
    NO_WALK,
    NONE,
    Row,
    body,
    excess,
    find,
    in_words,
    number,
    select,
)
from mjbiped.reproduction.table_2 import Choice, Results, side_distances

_NEAREST = 10  # readings that are listed

Lines = Iterator[Sequence[str]]
Pairs = Sequence[tuple[Row, Row, list[float]]]
"""Walks of Table II that were made in both engines, the hybrid one first, and their c_mt if both came so far."""


def printed(method: str, ground: str) -> str:
    """Write c_mt of Table II: X for a walk that did not come to its end, a dash for a method that it lacks."""
    value = paper.TABLE_2.get(method, {}).get(ground)
    return NONE if value is None else "X" if math.isnan(value) else number(value)


def of_claims(answers: Sequence[Answer]) -> dict[str, str]:
    """Fill the templates' places about the claims, by name."""
    parts = {"missed_without_the_table": missed(answers, *COUNTING)}
    for group in GROUPS:
        mine = by_claim(answers, [group])
        parts[f"missed_{group}"] = missed(answers, group)
        parts[f"checks_{group}"] = body([*key[1:], *(each.verdict for each in said)] for key, said in mine.items())
    denied = {
        key[1:]: " and ".join(ENGINES[each.engine] for each in said if each.holds is False)
        for key, said in by_claim(answers, COUNTING).items()
    }
    parts["denied"] = body([*key, engines] for key, engines in denied.items() if engines)
    both = {key: {each.holds for each in said} for key, said in by_claim(answers).items()}
    both = {key: holds for key, holds in both.items() if None not in holds}
    apart = [f"\n* {claim}" for (_, claim, _), holds in both.items() if len(holds) == 2]
    alike = f"{len(both) - len(apart)} of {len(both)}"
    return {**parts, "claims_alike": alike + (f"; they differ on\n{''.join(apart)}" if apart else ".")}


def of_table_2(results: Results) -> dict[str, str]:
    """Fill the templates' places about Table II, by name."""
    best, pairs = results.best, _pairs(results.rows)
    whole = [*_numbers(results)]
    tables: dict[str, Iterable[Sequence[str]]] = {
        "table_2": ([*line[:4], line[9]] for line in whole if line[1] in paper.TABLE_2),  # blind and fitted, hybrid
        "table_2_whole": whole,
        "ends": _ends(results),
        "agreement": _agreement(results),
        "misjudged": _misjudged(results),
        "nearest": _nearest(results.readings),
        "stairs": _sides(results, paper.STAIRS),
        "slopes": _sides(results, paper.SLOPES),
        "delays": _delays(results),
        "sources": _sources(results),
        "printed": _printed(results),
        "engines": _engines(pairs),
        "gravity": _gravity(results),
        "every_reading": _every(results),
    }
    replanned = "no re-planning" if best.delay is None else f"ζ = {best.delay:g}"
    return {
        **{name: body(lines) for name, lines in tables.items()},
        "best": f"{best.kind} work over the first {best.length} steps, {replanned}; stairs {best.stairs[0]}, first "
        f"riser at {best.stairs[1]:g} m; slopes {best.slopes[0]}, first change after {best.slopes[1]:g} m",
        "best_distance": number(100 * best.distance, ".1f"),
        "best_kind": best.kind,
        "best_length": str(best.length),
        "best_delay": in_words(best.delay),
        "source": results.sources[0],
        "misjudged_turned": _turned(results),
        "parted": _parted(pairs),
        "engines_apart": _apart(pairs),
    }


def _shown(results: Results) -> Iterator[tuple[str, str, list[Row]]]:
    """Of each number of Table II: ground, method, and the walks of both engines, blind, settled and fitted in turn.

    The adaptive controller has the paper's gains, and its zeta was chosen with the reading: its walks are "fitted".
    """
    for (k, ground), method in product(enumerate(paper.GROUNDS), paper.METHODS):
        settings = ("blind", results.sources[0], "fitted")
        walks = [results.walks(method, given, engine)[k] for given in settings for engine in ENGINES]
        yield ground, method, [NO_WALK] * 4 + walks[4:] if method == "adaptive" else walks


def _numbers(results: Results) -> Lines:
    """Tabulate every number of Table II beside ours."""
    best = results.best
    for ground, method, walks in _shown(results):
        cells, known = [ground, method, printed(method, ground)], paper.TABLE_2.get(method, {}).get(ground, math.nan)
        for here, there in zip(walks[::2], walks[1::2], strict=True):
            cells += [best.written(here), best.written(there), excess(best.cost(here), known)]
        yield cells


def _ends(results: Results) -> Lines:
    """Tabulate the walks that did not come to their end."""
    for ground, method, walks in _shown(results):
        if any(walk.outcome and not walk.finished for walk in walks):
            yield [ground, method, printed(method, ground), *(walk.ending(f"{walk.steps} steps") for walk in walks)]


def _agreement(results: Results) -> Lines:
    """Tabulate the agreement with the paper by gains, slope source and engine."""
    names = {f"blind, {paper.BLIND_SOURCE}": "blind", "fitted, each method's own": "fitted"}
    names |= {f"settled, {source}": source for source in results.sources}
    for (name, settings), engine in product(names.items(), ENGINES):
        found = results.agreement(engine, settings)
        if found.asked == results.agreement("hybrid", settings).asked:
            met, distance = f"{found.met} of {found.numbers}", number(100 * found.distance, ".1f")
            yield [name, ENGINES[engine], found.in_kind, met, distance]


def _started(results: Results) -> Iterator[tuple[str, str, list[Row]]]:
    """Of each method: its name, the error of the slope told at the start, in words, and its fitted walks."""
    for method in paper.ENERGY_BASED:
        wrong = select(results.rows, part="misjudged", method=method)
        yield method, "right", results.walks(method)
        yield method, f"{number(paper.START_ERROR, '+g')}°", wrong[::2]
        yield method, f"{number(-paper.START_ERROR, '+g')}°", wrong[1::2]


def _misjudged(results: Results) -> Lines:
    """Tabulate the fitted settings with the right and with a wrong slope at the start."""
    for method, told, walks in _started(results):
        yield [method, told, *map(results.best.written, walks)]


def _turned(results: Results) -> str:
    """List where a wrong slope at the start turns a number into an X, or an X into a number, in words."""
    cost = results.best.cost
    found = [
        f"{method} on {walk.ground} ({told})"
        for method, told, walks in _started(results)
        for right, walk in zip(results.walks(method), walks, strict=True)
        if math.isnan(cost(right)) != math.isnan(cost(walk))
    ]
    return ", ".join(found) or "nowhere"


def _nearest(readings: Sequence[Choice]) -> Lines:
    """Tabulate the readings that are nearest to the paper."""
    for choice in readings[:_NEAREST]:
        changes = (f"{pattern}, {first:g} m" for pattern, first in (choice.stairs, choice.slopes))
        distance = number(100 * choice.distance, ".2f")
        yield [*changes, in_words(choice.delay), choice.kind, str(choice.length), distance]


def _sides(results: Results, pair: Sequence[str]) -> Lines:
    """Tabulate the nearest reading of each pattern of the stairs or of the slopes."""
    nearest: dict[str, Choice] = {}
    for side in sorted(side_distances(results.rows, pair), key=lambda side: side.distance):
        nearest.setdefault(side.stairs[0], side)
    for (pattern, first), side in ((side.stairs, side) for side in nearest.values()):
        if not math.isfinite(side.distance):  # a fall, however it is read: in which step is shown for one setting
            side = replace(side, delay=0.8, kind="absolute", length=max(LENGTHS))
        walks = results.walks("adaptive", side.delay, places=[paper.Place(ground, pattern, first) for ground in pair])
        cells = [pattern, f"{first:g} m", in_words(side.delay), side.kind, str(side.length)]
        yield [*cells, *map(side.written, walks), number(100 * side.distance, ".1f")]


def _delays(results: Results) -> Lines:
    """Tabulate all zeta on the grounds of the best reading."""
    for zeta in paper.DELAYS:
        walks = results.walks("adaptive", zeta)
        torques = "; ".join(number(walk.torque, ".1f") for walk in walks)
        forces = "; ".join(number(walk.least_force, ".2f") for walk in walks)
        yield [in_words(zeta), *map(results.best.written, walks), torques, forces]
    yield ["paper", *(printed("adaptive", ground) for ground in paper.GROUNDS), NONE, NONE]


def _sources(results: Results) -> Lines:
    """Tabulate all slope sources of the comparison controllers with gains that settle, on the reading's grounds."""
    for method, variant in paper.SETTLED.items():
        for source in paper.SLOPE_SOURCES:
            name = source + " *" * (source == variant.slope_source)
            yield [method, name, *map(results.best.written, results.walks(method, source))]
        if method in paper.TABLE_2:
            yield [method, "paper", *(printed(method, ground) for ground in paper.GROUNDS)]


def _printed(results: Results) -> Lines:
    """Tabulate the grounds with the signs that the paper prints, each change added to the last."""
    for place in paper.PRINTED:
        walks = [results.walks("adaptive", engine=engine, places=[place])[0] for engine in ENGINES]
        cells = (walk.ending(results.best.written(walk)) for walk in walks)
        yield [place.ground, place.pattern, printed("adaptive", place.ground), *cells]


def _gravity(results: Results) -> Lines:
    """Tabulate the best reading with g = 9.8 m/s²."""
    for walk in results.walks("adaptive"):
        here = results.best.cost(walk)
        there = results.best.cost(find(results.rows, part="gravity", place_read=walk.place_read))
        cells = number(here, ".6f"), number(there, ".6f"), excess(there, here, "+.4f")
        yield [walk.ground, printed("adaptive", walk.ground), *cells]


def _every(results: Results) -> Lines:
    """Tabulate all readings: the adaptive controller's in full, the others' at the best reading's kind and length."""
    for place in dict.fromkeys(row.place_read for row in select(results.rows, part="table 2")):
        ours, *walks = (results.walks(method, results.sources[0], places=[place])[0] for method in paper.METHODS)
        kinds = (" ".join(ours.cost(kind, length) for length in LENGTHS) for kind in WORK_KINDS)
        first = f"{place.first:g}" if place.pattern else NONE
        yield [f"{place.ground} {place.pattern}".strip(), first, *kinds, *map(results.best.written, walks)]


def _pairs(rows: Sequence[Row]) -> Pairs:
    mine = [row for row in rows if row.part in ("table 2", "blind", "fitted")]
    here, there = (
        {(row.part, row.place_read, row.method, row.delay, row.slope_source): row for row in mine if row.engine == name}
        for name in ENGINES
    )
    return [(here[key], row, _both_costs(here[key], row)) for key, row in there.items()]


def _both_costs(here: Row, there: Row) -> list[float]:
    """Return c_mt in both engines over the steps of MuJoCo's walk; empty where one did not come so far."""
    if there.finished and here.steps >= there.steps:
        return [float(getattr(walk, f"absolute_{there.steps}")) for walk in (here, there)]
    return []


def _parted(pairs: Pairs) -> str:
    """Count the walks that ended differently: not in the same step, nor both as far as the shorter was to go."""
    apart = [
        there
        for here, there, costs in pairs
        if not costs and (here.finished or there.finished or here.steps != there.steps)
    ]
    if not apart:
        return f"All {len(pairs)} end alike."
    named = "; ".join(dict.fromkeys(f"{row.method} on {row.ground} {row.pattern}" for row in apart))
    return f"{len(apart)} of {len(pairs)} end in another step than in the other engine: {named}."


def _apart(pairs: Pairs) -> str:
    """Describe the difference of the engines' c_mt: median, ninth decile, and the walk that differs most."""
    compared = [(abs(costs[1] / costs[0] - 1.0), there) for _, there, costs in pairs if costs]
    if not compared:
        return "no walk was compared"
    off = [difference for difference, _ in compared]
    middle, nine_tenths, most = (number(100 * float(np.quantile(off, part)), ".2g") for part in (0.5, 0.9, 1.0))
    last = compared[int(np.argmax(off))][1]
    return (
        f"c_mt of the {len(off)} walks of Table II that come to their end in both differs by {middle} % in the median, "
        f"by up to {nine_tenths} % in nine of ten, and by {most} % at most ({_law(last)}, on {last.ground} "
        f"{last.pattern})"
    )


def _engines(pairs: Pairs) -> Lines:
    """Tabulate every walk of Table II that was made in both engines."""
    for here, there, costs in pairs:
        cells = [*(f"{walk.outcome}, {walk.steps} steps" for walk in (here, there)), NONE]
        if costs:
            cells = [*map(number, costs), excess(costs[1], costs[0], "+.2f")]
        yield [f"{there.ground} {there.pattern}".strip(), _law(there), *cells]


def _law(row: Row) -> str:
    """Name a method with its settings."""
    if row.method == "adaptive":
        return f"adaptive, ζ = {in_words(row.delay)}"
    return f"{row.method}, {row.gains.replace('-', '−')}, {row.slope_source}"
