"""The part of the report on Table II's numbers, by settings of the comparison methods that owe it nothing or much."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mjbiped.reproduction.grounds import ENERGY_BASED, TABLE_2, Place
from mjbiped.reproduction.methods import BLIND_SOURCE, METHODS
from mjbiped.reproduction.plan import START_ERROR
from mjbiped.reproduction.report.markdown import ENGINES, best_cost, body, ending, excess, number, paper
from mjbiped.reproduction.rows import NO_WALK, Row, select
from mjbiped.reproduction.table_2 import Agreement, Choice, agreement_of, sources_ranked, walk_on

SETS = ("blind", "settled", "fitted")
"""Settings of the comparison methods: without a look at Table II; gains without it and source by it; all by it."""


def sections(rows: Sequence[Row], best: Choice) -> dict[str, str]:
    """Fill the template's places about Table II's numbers, by name."""
    sources = sources_ranked(rows, best)
    shown = {
        (place[0], method): walks_shown(rows, best, sources[0], place, method)
        for place in best.places
        for method in METHODS
    }
    started = {method: _started(rows, best, method) for method in ENERGY_BASED}
    return {
        **_main(shown, best),
        "ends": _ends(shown),
        "agreement": _agreement(rows, best, sources),
        "misjudged": _misjudged(started, best),
        "misjudged_turned": _turned(started, best),
    }


Shown = dict[tuple[str, str], dict[str, list[Row]]]
"""By ground and method, for each number of Table II: the walks of both engines by `SETS`."""


def walks_shown(rows: Sequence[Row], best: Choice, source: str, place: Place, method: str) -> dict[str, list[Row]]:
    """Find a method's walks on a ground in both engines, by the settings, see `SETS`.

    The adaptive controller has the paper's gains, and its zeta was chosen with the reading: its walks are "fitted".

    Args:
        rows: Rows of the report.
        best: The reading.
        source: Slope source with the gains that settle.
        place: Ground, pattern and first change.
        method: One of `METHODS`.
    """
    settings = {"blind": "blind", "settled": source, "fitted": "fitted"}
    found = {name: [walk_on(rows, best, e, place, method, given) for e in ENGINES] for name, given in settings.items()}
    return found if method != "adaptive" else {**dict.fromkeys(SETS, [NO_WALK] * 2), "fitted": found["fitted"]}


def _main(shown: Shown, best: Choice) -> dict[str, str]:
    """Tabulate every number of Table II beside ours: all of ours, and the hybrid engine's of the paper's methods."""
    lines = []
    for (ground, method), sets in shown.items():
        known, cells = TABLE_2.get(method, {}).get(ground), []
        for walks in sets.values():
            cells += [*(best_cost(walk, best) for walk in walks), excess(best.cost(walks[0]), known)]
        lines.append([ground, method, paper(method, ground), *cells])
    short = [[*line[:4], line[9]] for line in lines if line[1] in TABLE_2]
    return {"table_2": body(short), "table_2_whole": body(lines)}


def _ends(shown: Shown) -> str:
    """Tabulate the walks that did not come to their end."""
    lines = []
    for (ground, method), sets in shown.items():
        walks = [walk for walks in sets.values() for walk in walks]
        if any(walk.outcome and not walk.finished for walk in walks):
            cells = (ending(walk, f"{walk.steps} steps") for walk in walks)
            lines.append([ground, method, paper(method, ground), *cells])
    return body(lines)


def _agreement(rows: Sequence[Row], best: Choice, sources: Sequence[str]) -> str:
    """Tabulate the agreement with the paper by gains, slope source and engine."""
    names = {f"blind, {BLIND_SOURCE}": "blind", "fitted, each method's own": "fitted"}
    names |= {f"settled, {source}": source for source in sources}
    lines = []
    for name, settings in names.items():
        by_engine = {engine: agreement_of(rows, best, engine, settings) for engine in ENGINES}
        for engine, found in by_engine.items():
            if found.asked == by_engine["hybrid"].asked:
                met, distance = f"{found.met} of {found.numbers}", number(100 * found.distance, ".1f")
                lines.append([name, ENGINES[engine], in_kind(found), met, distance])
    return body(lines)


def in_kind(found: Agreement) -> str:
    """Write how many cells of Table II are X or number as in the paper."""
    return f"{found.agreeing} of {found.asked}"


Started = dict[str, list[Row]]
"""A method's fitted walks on Table II's grounds, by the error of the slope that it was told at the start, in words."""


def _started(rows: Sequence[Row], best: Choice, method: str) -> Started:
    mine = [select(rows, part="misjudged", method=method, place_read=place) for place in best.places]
    less, more = zip(*(sorted(walks, key=lambda walk: float(walk.start_estimate)) for walks in mine), strict=True)
    right = [walk_on(rows, best, "hybrid", place, method, "fitted") for place in best.places]
    return {"right": right, f"{number(START_ERROR, '+g')}°": [*more], f"{number(-START_ERROR, '+g')}°": [*less]}


def _misjudged(started: dict[str, Started], best: Choice) -> str:
    """Tabulate the fitted settings with the right and with a wrong slope at the start."""
    lines = [
        [method, told, *(best_cost(walk, best) for walk in walks)]
        for method, found in started.items()
        for told, walks in found.items()
    ]
    return body(lines)


def _turned(started: dict[str, Started], best: Choice) -> str:
    """List where a wrong slope at the start turns a number into an X, or an X into a number, in words."""
    found = [
        f"{method} on {walk.ground} ({told})"
        for method, walks in started.items()
        for told in [*walks][1:]
        for right, walk in zip(walks["right"], walks[told], strict=True)
        if math.isnan(best.cost(right)) != math.isnan(best.cost(walk))
    ]
    return ", ".join(found) or "nowhere"
