"""The part of the report on Table II's numbers: the paper's, and ours with gains that owe it nothing, less, or more."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mjbiped.reproduction.grounds import Place
from mjbiped.reproduction.methods import BLIND, BLIND_SOURCE, METHODS, SETTLED, SLOPE_SOURCES, Variant, gains_told
from mjbiped.reproduction.published import GROUNDS, TABLE_2
from mjbiped.reproduction.report.markdown import ENGINES, NONE, cost, ending, number, paper, percent, table
from mjbiped.reproduction.report.table_2 import walk_of, walks_asked
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.scan import GAINS, RATIOS, Tried, fitted, ranked
from mjbiped.reproduction.table_2 import Agreement, Choice, agreement, agreement_of, agreements, walks_read

SETS = ("blind", "settled", "fitted")
"""Settings of the comparison methods: without a look at Table II; gains without it and source by it; all by it."""

_AS_NEAR = 0.005  # of the distance, for settings that are as good as the nearest


def sections(rows: Sequence[Row], best: Choice, tried: Sequence[Tried]) -> dict[str, str]:
    """What the template wants to know of Table II's numbers, by name."""
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
        "table_2": _main(rows, best, source),
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
    """A method's walks on a ground in both engines, by the settings, see `SETS`.

    The adaptive controller has the paper's gains, and its zeta was chosen with the reading: its walks are "fitted".

    Args:
        rows: Of the report.
        best: The reading.
        source: Of the slope, with the gains that settle.
        place: Ground, pattern and first change.
        method: One of `METHODS`.
    """
    shown = {part: [walks_asked(rows, best, engine, place[0], part).get(method) for engine in ENGINES] for part in SETS}
    shown["settled"] = [walk_of(rows, engine, place, method, source=source) for engine in ENGINES]
    return {part: walks if method != "adaptive" or part == "fitted" else [None, None] for part, walks in shown.items()}


def _main(rows: Sequence[Row], best: Choice, source: str) -> str:
    """Every number of Table II and ours, line by line."""
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
    return table(("ground", "method", "paper", *headings), lines)


def _ends(rows: Sequence[Row], best: Choice, source: str) -> str:
    """Every walk of the table that did not come to its end."""
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
    """How far walks agree with the paper, by gains, slope source and engine."""
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
    """The nearest setting of each method with each slope source, and of KETC through one joint and through both."""
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
    """A setting's gains, as the page shows them."""
    return gains_told(dict(variant.gains)).replace("-", "−")


def _fit(method: str, gains: str, each: Tried) -> list[str]:
    found = each.agreement
    cells = [f"X {each.ended[ground]}" if ground in each.ended else number(each.cost[ground]) for ground in GROUNDS]
    right = f"{found.agreeing} of {found.asked}"
    return [method, gains, each.variant.slope_source, right, number(100 * found.distance, ".1f"), *cells]


def _as_near(tried: Sequence[Tried]) -> str:
    """How many settings of each method are as good as its nearest, in words."""
    parts = []
    for method, nearest in fitted(tried).items():
        mine = [each.agreement for each in tried if each.variant.method == method]
        best = nearest.agreement
        near = sum(each.agreeing == best.agreeing and each.distance <= best.distance + _AS_NEAR for each in mine)
        parts.append(f"{near} of {len(mine)} for {method}")
    return ", ".join(parts)


def _falls(tried: Sequence[Tried], method: str, ground: str) -> str:
    """With how many settings of each slope source a method does not come to the end of a ground."""
    parts = []
    for source in SLOPE_SOURCES:
        mine = [each for each in tried if (each.variant.method, each.variant.slope_source) == (method, source)]
        parts.append(f'{sum(ground in each.ended for each in mine)} ("{source}")')
    return f"{', '.join(parts[:-1])} or {parts[-1]}"


def _survivors(tried: Sequence[Tried], ground: str) -> str:
    """Which settings come to the end of a ground, in words."""
    through = [each.variant for each in tried if ground not in each.ended]
    named = "; ".join(f"{each.method} {_gains(each)}, {each.slope_source}" for each in through)
    return f"{len(through)} of {len(tried)}" + (f" ({named})" if through else "")
