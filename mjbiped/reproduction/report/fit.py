"""The part of the report on Table II's numbers: settings that owe it nothing or much, and what each fit is worth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction import placebo
from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.grounds import ENERGY_BASED, GROUNDS, TABLE_2, Place, changes_of
from mjbiped.reproduction.methods import BLIND, BLIND_SOURCE, DELAYS, METHODS, SLOPE_SOURCES, Variant, gains_told
from mjbiped.reproduction.placebo import Placebo, RandomGround
from mjbiped.reproduction.plan import START_ERROR
from mjbiped.reproduction.report import table_3
from mjbiped.reproduction.report.markdown import ENGINES, NONE, cost, ending, excess, number, paper, share
from mjbiped.reproduction.report.table_2 import walk_of, walks_asked
from mjbiped.reproduction.rows import Row, select
from mjbiped.reproduction.table_2 import (
    Agreement,
    Choice,
    Tried,
    agreement,
    agreement_of,
    agreements,
    fitted,
    ranked,
    walks_read,
)
from mjbiped.utils.markdown import markdown_table

SETS = ("blind", "settled", "fitted")
"""Settings of the comparison methods: without a look at Table II; gains without it and source by it; all by it."""

SMALL_SHARE = 0.05
"""Of random rows that are met as near as the paper's: below, the fit is evidence."""

_AS_NEAR = 0.005  # of the distance, for settings that are as good as the nearest


def sections(rows: Sequence[Row], best: Choice, tried: Sequence[Tried]) -> dict[str, str]:
    """Fill the template's places about Table II's numbers, by name."""
    source = agreements(rows, best)[0].source
    whole = agreement(
        (method, ground, value) for method, each in fitted(tried).items() for ground, value in each.cost.items()
    )
    levels = (each.cost["level"] for each in tried if each.variant.method == "PBC" and each.cost["level"] > 0.0)
    return {
        "table_2": _main(rows, best, source),
        "ends": _ends(rows, best, source),
        "agreement": _agreement(rows, best),
        "fits": _fits(tried),
        "fit_agreement": f"{whole.agreeing} of {whole.asked}",
        "fit_met": f"{whole.met} of {whole.numbers}",
        "fit_distance": number(100 * whole.distance, ".1f"),
        "survivors": _survivors(tried, "stair 2"),
        "as_near": _as_near(tried),
        "pbc_falls": _falls(tried, "PBC", "slope 2"),
        "pbc_level": number(min(levels, key=lambda value: abs(value - (TABLE_2["PBC"]["level"] or math.nan))), ".5f"),
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


def _main(rows: Sequence[Row], best: Choice, source: str) -> str:
    """Tabulate every number of Table II beside ours."""
    lines = []
    for ground, method, shown in _numbers(rows, best, source):
        known, cells = TABLE_2.get(method, {}).get(ground), []
        for walks in shown:
            here = walks[0]
            cells += [cost(walk, best.kind, best.length) for walk in walks]
            cells.append(excess(math.nan if here is None else here.cost[best.kind, best.length], known))
        lines.append([ground, method, paper(method, ground), *cells])
    headings = [f"{gains}, {what}" for gains in SETS for what in ("hybrid", "MuJoCo", "hybrid − paper")]
    return markdown_table(("ground", "method", "paper", *headings), lines, 1)


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
                lines.append([name, ENGINES[engine], _in_kind(found), met, distance])
    kind, met = "X or number as in the paper", "numbers as printed"
    return markdown_table(("gains, slope", "engine", kind, met, "distance of the numbers %"), lines, 1)


def _in_kind(found: Agreement) -> str:
    return f"{found.agreeing} of {found.asked}"


def _fits(tried: Sequence[Tried]) -> str:
    """Tabulate the nearest setting of each method with each slope source, and of KETC with one joint and with both."""
    lines = []
    for method, chosen in fitted(tried).items():
        kinds: dict[tuple[str, float | None], Tried] = {}
        for each in ranked(each for each in tried if each.variant.method == method):
            kinds.setdefault((each.variant.slope_source, dict(each.variant.gains).get("hip_weight")), each)
        for each in kinds.values():
            gains = _gains(each.variant) + (" *" if each is chosen else "")
            costs = (f"X {each.ended[g]}" if g in each.ended else number(each.cost[g]) for g in GROUNDS)
            found = each.agreement
            distance = number(100 * found.distance, ".1f")
            lines.append([method, gains, each.variant.slope_source, _in_kind(found), distance, *costs])
        lines.append([method, "paper", NONE, NONE, NONE, *(paper(method, ground) for ground in GROUNDS)])
    return markdown_table(("method", "gains", "slope", "X and numbers", "distance %", *GROUNDS), lines, 1)


def _gains(variant: Variant) -> str:
    """Write a setting's gains for the page."""
    return gains_told(dict(variant.gains)).replace("-", "−")


def _as_near(tried: Sequence[Tried]) -> str:
    """Count the settings of each method that are as good as its nearest, in words."""
    parts = []
    for method, nearest in fitted(tried).items():
        mine = [each.agreement for each in tried if each.variant.method == method]
        best = nearest.agreement
        near = sum(each.agreeing == best.agreeing and each.distance <= best.distance + _AS_NEAR for each in mine)
        parts.append(f"{near} of {len(mine)} for {method}")
    return ", ".join(parts)


def _falls(tried: Sequence[Tried], method: str, ground: str) -> str:
    """Count the settings of each slope source with which a method does not come to the end of a ground."""
    parts = []
    for source in SLOPE_SOURCES:
        mine = [each for each in tried if (each.variant.method, each.variant.slope_source) == (method, source)]
        parts.append(f'{sum(ground in each.ended for each in mine)} ("{source}")')
    return f"{', '.join(parts[:-1])} or {parts[-1]}"


def _survivors(tried: Sequence[Tried], ground: str) -> str:
    """List the settings that come to the end of a ground, in words."""
    through = [each.variant for each in tried if ground not in each.ended]
    named = "; ".join(f"{each.method} {_gains(each)}, {each.slope_source}" for each in through)
    return f"{len(through)} of {len(tried)}" + (f" ({named})" if through else "")


def worth_sections(
    rows: Sequence[Row], best: Choice, tried: Sequence[Tried], grounds: Sequence[RandomGround]
) -> dict[str, str]:
    """Fill the template's places about the worth of the fits, by name."""
    found = table_3.distance(table_3.walks_of(rows, "found", "hybrid"))
    fits, others = {method: placebo.of_method(tried, method) for method in fitted(tried)}, placebo.to_another(grounds)
    return {
        "fits_worth": _worth(rows, fits, grounds, found),
        "evident": ", ".join(method for method, each in fits.items() if each.share < SMALL_SHARE) or "none",
        "grounds_walked": str(sum(bool(each.torques) for each in grounds)),
        "to_another": share(float(np.median(others)), ".1f"),
        "to_another_share": share(float(np.mean(others <= found))),
        "misjudged": _misjudged(rows, best),
        "misjudged_turned": turned(rows, best),
    }


def _worth(rows: Sequence[Row], fits: Mapping[str, Placebo], grounds: Sequence[RandomGround], searched: float) -> str:
    """Tabulate every fit beside fits to random rows."""
    read = (DELAYS, WORK_KINDS, LENGTHS, *changes_of("stair 1"), *changes_of("slope 1"))
    lines = [_line("reading of the grounds, by the adaptive controller", len(read), "", placebo.of_readings(rows))]
    for method, found in fits.items():
        free = 1 + len(BLIND[method].gains)
        crosses = f" and {sum(value is None for value in TABLE_2[method].values())} X"
        lines.append(_line(f"gains and slope source of {method}", free, crosses, found))
    free, found = len(placebo.bounds()), placebo.of_table_3(grounds)
    distance = number(100 * searched, ".1f")
    lines.append(["ground of Table III, searched", str(free), str(found.numbers), NONE, distance, NONE, NONE, NONE])
    lines.append(_line("the same, random grounds", free, "", found, "of the law, not of the ground"))
    met, as_near = "random rows: half are met within %", "random rows met as near as the paper's"
    headings = ("fit", "free choices", "numbers met", "settings", "distance %", met, as_near, "evidence")
    return markdown_table(headings, lines, 1)


def _line(name: str, free: int, crosses: str, found: Placebo, kind: str = "some") -> list[str]:
    distances = (number(100 * value, ".1f") for value in (found.distance, found.random))
    evidence = kind if found.share < SMALL_SHARE else "none"
    return [name, str(free), f"{found.numbers}{crosses}", str(found.tried), *distances, share(found.share), evidence]


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
