"""The part of the report on Table II: numbers with gains that owe it nothing or much, and what each fit is worth."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction import placebo
from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.grounds import (
    FIRST_CHANGES,
    FIRST_RISERS,
    GROUNDS,
    SLOPE_PATTERNS,
    STAIR_PATTERNS,
    TABLE_2,
    Place,
)
from mjbiped.reproduction.methods import (
    BLIND,
    BLIND_SOURCE,
    DELAYS,
    METHODS,
    SETTLED,
    SLOPE_SOURCES,
    Variant,
    gains_told,
)
from mjbiped.reproduction.placebo import Placebo, RandomGround
from mjbiped.reproduction.plan import START_ERROR
from mjbiped.reproduction.report import table_3
from mjbiped.reproduction.report.markdown import ENGINES, NONE, cost, ending, number, paper, percent, table
from mjbiped.reproduction.report.table_2 import walk_of, walks_asked
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import (
    GAINS,
    RATIOS,
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

SETS = ("blind", "settled", "fitted")
"""Settings of the comparison methods: without a look at Table II; gains without it and source by it; all by it."""

_AS_NEAR = 0.005  # of the distance, for settings that are as good as the nearest


def sections(rows: Sequence[Row], best: Choice, tried: Sequence[Tried]) -> dict[str, str]:
    """Fill the template's places about Table II's numbers, by name."""
    source = agreements(rows, best)[0].source
    nearest = fitted(tried)
    level = min(
        (each for each in tried if each.variant.method == "PBC" and not math.isnan(each.cost["level"])),
        key=lambda each: abs(each.cost["level"] - (TABLE_2["PBC"]["level"] or math.nan)),
    )
    whole = agreement(
        (each.variant.method, ground, value) for each in nearest.values() for ground, value in each.cost.items()
    )
    return {
        **_main(rows, best, source),
        "ends": _ends(rows, best, source),
        "agreement": _agreement(rows, best),
        "fits": _fits(tried),
        "settings": str(len(tried)),
        "settings_walks": str(len(tried) * len(GROUNDS)),
        "gains_tried": str(len(GAINS)),
        "least_gain": f"{min(GAINS):g}",
        "greatest_gain": f"{max(GAINS):g}",
        "ratios_tried": str(len(RATIOS)),
        "least_ratio": number(min(RATIOS), "g"),
        "greatest_ratio": number(max(RATIOS), "g"),
        "fit_agreement": f"{whole.agreeing} of {whole.asked}",
        "fit_met": f"{whole.met} of {whole.numbers}",
        "survivors": _survivors(tried, "stair 2"),
        "fit_distance": number(100 * whole.distance, ".1f"),
        "as_near": _as_near(tried),
        "blind": "; ".join(f"{method} {_gains(variant)}" for method, variant in BLIND.items()),
        "blind_source": BLIND_SOURCE,
        "settled": "; ".join(f"{method} {_gains(variant)}" for method, variant in SETTLED.items()),
        "pbc_falls": _falls(tried, "PBC", "slope 2"),
        "pbc_level": number(level.cost["level"], ".5f"),
        "pbc_level_paper": number(TABLE_2["PBC"]["level"]),
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
    shown["settled"] = [walk_of(rows, engine, place, method, source=source) for engine in ENGINES]
    return {part: walks if method != "adaptive" or part == "fitted" else [None, None] for part, walks in shown.items()}


def _main(rows: Sequence[Row], best: Choice, source: str) -> dict[str, str]:
    """Tabulate every number of Table II beside ours: all of ours, and the hybrid engine's of the paper's methods."""
    lines = []
    for place in best.places:
        for method in METHODS:
            known = TABLE_2.get(method, {}).get(place[0])
            cells = []
            for walks in walks_shown(rows, best, source, place, method).values():
                here = walks[0]
                cells += [cost(walk, best.kind, best.length) for walk in walks]
                cells.append(percent(math.nan if here is None else here.cost[best.kind, best.length], known))
            lines.append([place[0], method, paper(method, place[0]), *cells])
    headings = [f"{gains}, {what}" for gains in SETS for what in ("hybrid", "MuJoCo", "hybrid − paper")]
    short = [[*line[:4], line[9]] for line in lines if line[1] in TABLE_2]
    return {
        "table_2": table(("ground", "method", "paper", "blind", "fitted"), short),
        "table_2_whole": table(("ground", "method", "paper", *headings), lines),
    }


def _ends(rows: Sequence[Row], best: Choice, source: str) -> str:
    """Tabulate the walks that did not come to their end."""
    lines = []
    for place in best.places:
        for method in METHODS:
            walks = [walk for walks in walks_shown(rows, best, source, place, method).values() for walk in walks]
            if any(walk is not None and not walk.finished for walk in walks):
                cells = (
                    NONE if walk is None else f"{walk.steps} steps" if walk.finished else ending(walk) for walk in walks
                )
                lines.append([place[0], method, paper(method, place[0]), *cells])
    headings = [f"{gains}, {engine}" for gains in SETS for engine in ENGINES.values()]
    return table(("ground", "method", "paper", *headings), lines) if lines else "None: all walks came to it."


def _agreement(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the agreement with the paper by gains, slope source and engine."""
    lines = []
    for part, name in (("blind", f"blind, {BLIND_SOURCE}"), ("fitted", "fitted, each method's own")):
        for engine in ENGINES:
            walks = walks_read(rows, best, part, engine)
            if walks:
                lines.append(_agreed(name, engine, agreement_of(walks, best)))
    for each in agreements(rows, best):
        for engine in ENGINES:
            walks = walks_read(rows, best, "table 2", engine, each.source)
            found = agreement_of(walks, best)
            if found.asked == each.asked:
                lines.append(_agreed(f"settled, {each.source}", engine, found))
    kind, met = "X or number as in the paper", "numbers as printed"
    headings = ("gains, slope", "engine", kind, met, "distance of the numbers %")
    return table(headings, lines)


def _agreed(name: str, engine: str, found: Agreement) -> list[str]:
    kind, met = f"{found.agreeing} of {found.asked}", f"{found.met} of {found.numbers}"
    return [name, ENGINES[engine], kind, met, number(100 * found.distance, ".1f")]


def _fits(tried: Sequence[Tried]) -> str:
    """Tabulate the nearest setting of each method with each slope source, and of KETC with one joint and with both."""
    lines = []
    for method in dict.fromkeys(each.variant.method for each in tried):
        mine = [each for each in tried if each.variant.method == method]
        chosen = ranked(mine)[0]
        kinds: dict[tuple[str, float | None], list[Tried]] = {}
        for each in mine:
            kind = each.variant.slope_source, dict(each.variant.gains).get("hip_weight")
            kinds.setdefault(kind, []).append(each)
        for each in ranked(ranked(alike)[0] for alike in kinds.values()):
            star = " *" if each is chosen else ""
            lines.append(_fit(method, _gains(each.variant) + star, each))
        lines.append([method, "paper", NONE, NONE, NONE, *(paper(method, ground) for ground in GROUNDS)])
    return table(("method", "gains", "slope", "X and numbers", "distance %", *GROUNDS), lines)


def _gains(variant: Variant) -> str:
    """Write a setting's gains for the page."""
    return gains_told(dict(variant.gains)).replace("-", "−")


def _fit(method: str, gains: str, each: Tried) -> list[str]:
    found = each.agreement
    cells = [f"X {each.ended[ground]}" if ground in each.ended else number(each.cost[ground]) for ground in GROUNDS]
    right = f"{found.agreeing} of {found.asked}"
    return [method, gains, each.variant.slope_source, right, number(100 * found.distance, ".1f"), *cells]


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


SMALL_SHARE = 0.05
"""Of random rows that are met as near as the paper's: below, the fit is evidence."""

_READ = (DELAYS, WORK_KINDS, LENGTHS, STAIR_PATTERNS, FIRST_RISERS, SLOPE_PATTERNS, FIRST_CHANGES)


def worth_sections(
    rows: Sequence[Row], best: Choice, tried: Sequence[Tried], grounds: Sequence[RandomGround]
) -> dict[str, str]:
    """Fill the template's places about the worth of the fits, by name."""
    (low, high), (least, greatest) = placebo.span("level"), placebo.span("stair 2")
    found = table_3.distance(table_3.walks_of(rows, "found", "hybrid"))
    others, walked = placebo.to_another(grounds), sum(bool(each.torques) for each in grounds)
    return {
        "fits_worth": _worth(rows, tried, grounds),
        "evident": _evident(tried),
        "placebo_rows": str(placebo.ROWS),
        "placebo_low": number(low),
        "placebo_high": number(high),
        "placebo_least": number(least),
        "placebo_greatest": number(greatest),
        "small_share": _percent(SMALL_SHARE),
        "grounds_drawn": str(len(grounds)),
        "grounds_walked": str(walked),
        "to_another": _percent(float(np.median(others)), ".1f"),
        "to_another_share": _percent(float(np.mean(others <= found))),
        "table_3_free": str(len(placebo.bounds())),
        "start_error": f"{START_ERROR:g}",
        "misjudged": _misjudged(rows, best),
        "misjudged_turned": turned(rows, best),
    }


def _worth(rows: Sequence[Row], tried: Sequence[Tried], grounds: Sequence[RandomGround]) -> str:
    """Tabulate every fit beside fits to random rows."""
    lines = [_line("reading of the grounds, by the adaptive controller", len(_READ), "", placebo.of_readings(rows))]
    for method, each in fitted(tried).items():
        crosses = f" and {sum(value is None for value in TABLE_2[method].values())} X"
        found = placebo.of_method(tried, method)
        lines.append(_line(f"gains and slope source of {method}", len(each.variant.gains) + 1, crosses, found))
    free, searched = len(placebo.bounds()), table_3.distance(table_3.walks_of(rows, "found", "hybrid"))
    found = placebo.of_table_3(grounds)
    distance = number(100 * searched, ".1f")
    lines.append(["ground of Table III, searched", str(free), str(found.numbers), NONE, distance, NONE, NONE, NONE])
    lines.append(_line("the same, random grounds", free, "", found, "of the law, not of the ground"))
    met, as_near = "random rows: half are met within %", "random rows met as near as the paper's"
    return table(("fit", "free choices", "numbers met", "settings", "distance %", met, as_near, "evidence"), lines)


def _evident(tried: Sequence[Tried]) -> str:
    """List the comparison methods whose fit to Table II is evidence."""
    evident = [method for method in fitted(tried) if placebo.of_method(tried, method).share < SMALL_SHARE]
    return ", ".join(evident) or "none"


def _line(name: str, free: int, crosses: str, found: Placebo, kind: str = "some") -> list[str]:
    distances = (number(100 * value, ".1f") for value in (found.distance, found.random))
    evidence = kind if found.share < SMALL_SHARE else "none"
    return [name, str(free), f"{found.numbers}{crosses}", str(found.tried), *distances, _percent(found.share), evidence]


def _percent(share: float, form: str = ".0f") -> str:
    return f"{number(100 * share, form)} %"


def _misjudged(rows: Sequence[Row], best: Choice) -> str:
    """Tabulate the fitted settings with the right and with a wrong slope at the start."""
    lines = []
    for method in TABLE_2:
        for part, wrong in (("fitted", 0.0), ("misjudged", START_ERROR), ("misjudged", -START_ERROR)):
            walks = _walks(rows, best, part, method, wrong)
            if walks:
                cells = (cost(walks.get(ground), best.kind, best.length) for ground in GROUNDS)
                lines.append([method, f"{number(wrong, '+g')}°" if wrong else "right", *cells])
    return table(("method", "slope told at the start", *GROUNDS), lines)


def turned(rows: Sequence[Row], best: Choice) -> str:
    """List where a wrong slope at the start turns a number into an X, or an X into a number, in words."""
    found = []
    for method in TABLE_2:
        right = _walks(rows, best, "fitted", method, 0.0)
        for wrong in (START_ERROR, -START_ERROR):
            for ground, walk in _walks(rows, best, "misjudged", method, wrong).items():
                before, after = (math.isnan(each.cost[best.kind, best.length]) for each in (right[ground], walk))
                if before != after:
                    found.append(f"{method} on {ground} ({number(wrong, '+g')}°)")
    return ", ".join(found) or "nowhere"


def _walks(rows: Sequence[Row], best: Choice, part: str, method: str, wrong: float) -> dict[str, Row]:
    """Find a method's walks in the hybrid engine with a start slope that is wrong by some degrees, by ground."""
    mine = [row for row in rows if (row.part, row.method, row.engine) == (part, method, "hybrid") and best.reads(row)]
    true = {row.ground: row.start_estimate for row in rows if (row.part, row.method) == ("fitted", method)}
    return {row.ground: row for row in mine if math.isclose(row.start_estimate, true[row.ground] + wrong, abs_tol=1e-6)}
