"""The part of the report on Table II's numbers, by settings of the comparison methods that owe it nothing or much."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from mjbiped.reproduction.grounds import ENERGY_BASED, GROUNDS, TABLE_2, Place
from mjbiped.reproduction.methods import BLIND_SOURCE, METHODS
from mjbiped.reproduction.plan import START_ERROR
from mjbiped.reproduction.report.markdown import ENGINES, cost, ending, excess, number, paper
from mjbiped.reproduction.report.table_2 import walk_of, walks_asked
from mjbiped.reproduction.rows import Row, select
from mjbiped.reproduction.table_2 import Agreement, Choice, agreement_of, agreements, walks_read
from mjbiped.utils.markdown import markdown_table

SETS = ("blind", "settled", "fitted")
"""Settings of the comparison methods: without a look at Table II; gains without it and source by it; all by it."""


def sections(rows: Sequence[Row], best: Choice) -> dict[str, str]:
    """Fill the template's places about Table II's numbers, by name."""
    source = agreements(rows, best)[0].source
    return {
        **_main(rows, best, source),
        "ends": _ends(rows, best, source),
        "agreement": _agreement(rows, best),
        "misjudged": _misjudged(rows, best),
        "misjudged_turned": turned(rows, best),
    }


def walks_shown(
    rows: Sequence[Row], best: Choice, source: str, place: Place, method: str
) -> dict[str, list[Row | None]]:
    """Find a method's walks on a ground in both engines, by the settings, see `SETS`.

    The adaptive controller has the paper's gains, and its zeta was chosen with the reading: its walks are "fitted".

    Args:
        rows: Rows of the report.
        best: The reading.
        source: Slope source with the gains that settle.
        place: Ground, pattern and first change.
        method: One of `METHODS`.
    """
    shown = {part: [walks_asked(rows, best, engine, place[0], part).get(method) for engine in ENGINES] for part in SETS}
    shown["settled"] = [walk_of(rows, engine, place, method, source) for engine in ENGINES]
    return {part: walks if method != "adaptive" or part == "fitted" else [None, None] for part, walks in shown.items()}


def _numbers(rows: Sequence[Row], best: Choice, source: str) -> Iterator[tuple[str, str, list[list[Row | None]]]]:
    """List ground, method and the walks of both engines for each of `SETS`, for every number of Table II."""
    for place in best.places:
        for method in METHODS:
            yield place[0], method, [*walks_shown(rows, best, source, place, method).values()]


def _main(rows: Sequence[Row], best: Choice, source: str) -> dict[str, str]:
    """Tabulate every number of Table II beside ours: all of ours, and the hybrid engine's of the paper's methods."""
    lines = []
    for ground, method, shown in _numbers(rows, best, source):
        known, cells = TABLE_2.get(method, {}).get(ground), []
        for walks in shown:
            here = walks[0]
            cells += [cost(walk, best.kind, best.length) for walk in walks]
            cells.append(excess(math.nan if here is None else here.cost[best.kind, best.length], known))
        lines.append([ground, method, paper(method, ground), *cells])
    headings = [f"{gains}, {what}" for gains in SETS for what in ("hybrid", "MuJoCo", "hybrid − paper")]
    short = [[*line[:4], line[9]] for line in lines if line[1] in TABLE_2]
    return {
        "table_2": markdown_table(("ground", "method", "paper", "blind", "fitted"), short, 1),
        "table_2_whole": markdown_table(("ground", "method", "paper", *headings), lines, 1),
    }


def _ends(rows: Sequence[Row], best: Choice, source: str) -> str:
    """Tabulate the walks that did not come to their end."""
    lines = []
    for ground, method, shown in _numbers(rows, best, source):
        walks = [walk for walks in shown for walk in walks]
        if any(walk is not None and not walk.finished for walk in walks):
            cells = (ending(walk, f"{walk.steps} steps" if walk else "") for walk in walks)
            lines.append([ground, method, paper(method, ground), *cells])
    headings = [f"{gains}, {engine}" for gains in SETS for engine in ENGINES.values()]
    if not lines:
        return "None: all walks came to it."
    return markdown_table(("ground", "method", "paper", *headings), lines, 1)


def _agreement(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the agreement with the paper by gains, slope source and engine."""
    parts: list[tuple[str, str, str | None]] = [
        (f"blind, {BLIND_SOURCE}", "blind", None),
        ("fitted, each method's own", "fitted", None),
        *((f"settled, {each.source}", "table 2", each.source) for each in agreements(rows, best)),
    ]
    lines = []
    for name, part, source in parts:
        asked = len(walks_read(rows, best, part, "hybrid", source))
        for engine in ENGINES:
            found = agreement_of(walks_read(rows, best, part, engine, source), best)
            if found.asked == asked:
                met, distance = f"{found.met} of {found.numbers}", number(100 * found.distance, ".1f")
                lines.append([name, ENGINES[engine], in_kind(found), met, distance])
    kind, met = "X or number as in the paper", "numbers as printed"
    return markdown_table(("gains, slope", "engine", kind, met, "distance of the numbers %"), lines, 1)


def in_kind(found: Agreement) -> str:
    """Write how many cells of Table II are X or number as in the paper."""
    return f"{found.agreeing} of {found.asked}"


def _misjudged(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the fitted settings with the right and with a wrong slope at the start."""
    lines = []
    for method in ENERGY_BASED:
        for wrong in (0.0, START_ERROR, -START_ERROR):
            if walks := _walks(rows, best, method, wrong):
                cells = (cost(walks.get(ground), best.kind, best.length) for ground in GROUNDS)
                lines.append([method, f"{number(wrong, '+g')}°" if wrong else "right", *cells])
    return markdown_table(("method", "slope told at the start", *GROUNDS), lines, 1)


def turned(rows: Sequence[Row], best: Choice) -> str:
    """List where a wrong slope at the start turns a number into an X, or an X into a number, in words."""
    found = []
    for method in ENERGY_BASED:
        right = _walks(rows, best, method, 0.0)
        for wrong in (START_ERROR, -START_ERROR):
            for ground, walk in _walks(rows, best, method, wrong).items():
                before, after = (math.isnan(each.cost[best.kind, best.length]) for each in (right[ground], walk))
                if before != after:
                    found.append(f"{method} on {ground} ({number(wrong, '+g')}°)")
    return ", ".join(found) or "nowhere"


def _walks(rows: Sequence[Row], best: Choice, method: str, wrong: float) -> dict[str, Row]:
    """Find a method's fitted walks in the hybrid engine with a start slope wrong by some degrees, by ground."""
    part = "misjudged" if wrong else "fitted"
    mine = filter(best.reads, select(rows, part=part, method=method, engine="hybrid"))
    true = {row.ground: row.start_estimate for row in select(rows, part="fitted", method=method)}
    return {row.ground: row for row in mine if math.isclose(row.start_estimate, true[row.ground] + wrong, abs_tol=1e-6)}
