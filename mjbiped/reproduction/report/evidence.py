"""The part of the report on what its fits are worth: free choices, placebos, and how much a small error moves."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction import placebo, random_grounds
from mjbiped.reproduction.cell import LENGTHS
from mjbiped.reproduction.grounds import FIRST_CHANGES, FIRST_RISERS, SLOPE_PATTERNS, STAIR_PATTERNS
from mjbiped.reproduction.methods import DELAYS
from mjbiped.reproduction.placebo import Placebo
from mjbiped.reproduction.plan import START_ERROR
from mjbiped.reproduction.published import GROUNDS, TABLE_2
from mjbiped.reproduction.random_grounds import RandomGround
from mjbiped.reproduction.report import table_3
from mjbiped.reproduction.report.markdown import NONE, cost, number, table
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.scan import Tried, fitted
from mjbiped.reproduction.table_2 import Choice

SMALL_SHARE = 0.05
"""Of random rows that are met as near as the paper's: below, the fit is evidence."""

_READ = (DELAYS, WORK_KINDS, LENGTHS, STAIR_PATTERNS, FIRST_RISERS, SLOPE_PATTERNS, FIRST_CHANGES)


def sections(
    rows: Sequence[Row], best: Choice, tried: Sequence[Tried], grounds: Sequence[RandomGround]
) -> dict[str, str]:
    """What the template wants to know of the fits, by name."""
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
        "table_3_free": str(len(random_grounds.bounds())),
        "start_error": f"{START_ERROR:g}",
        "misjudged": _misjudged(rows, best),
        "misjudged_turned": turned(rows, best),
    }


def _worth(rows: Sequence[Row], tried: Sequence[Tried], grounds: Sequence[RandomGround]) -> str:
    """Every fit beside random rows."""
    lines = [_line("reading of the grounds, by the adaptive controller", len(_READ), "", placebo.of_readings(rows))]
    for method, each in fitted(tried).items():
        crosses = f" and {sum(value is None for value in TABLE_2[method].values())} X"
        found = placebo.of_method(tried, method)
        lines.append(_line(f"gains and slope source of {method}", len(each.variant.gains) + 1, crosses, found))
    free, searched = len(random_grounds.bounds()), table_3.distance(table_3.walks_of(rows, "found", "hybrid"))
    found = placebo.of_table_3(grounds)
    distance = number(100 * searched, ".1f")
    lines.append(["ground of Table III, searched", str(free), str(found.numbers), NONE, distance, NONE, NONE, NONE])
    lines.append(_line("the same, random grounds", free, "", found, "of the law, not of the ground"))
    met, as_near = "random rows: half are met within %", "random rows met as near as the paper's"
    return table(("fit", "free choices", "numbers met", "settings", "distance %", met, as_near, "evidence"), lines)


def _evident(tried: Sequence[Tried]) -> str:
    """Of which comparison methods the fit to Table II is evidence."""
    evident = [method for method in fitted(tried) if placebo.of_method(tried, method).share < SMALL_SHARE]
    return ", ".join(evident) or "none"


def _line(name: str, free: int, crosses: str, found: Placebo, kind: str = "some") -> list[str]:
    distances = (number(100 * value, ".1f") for value in (found.distance, found.random))
    evidence = kind if found.share < SMALL_SHARE else "none"
    return [name, str(free), f"{found.numbers}{crosses}", str(found.tried), *distances, _percent(found.share), evidence]


def _percent(share: float, form: str = ".0f") -> str:
    return f"{number(100 * share, form)} %"


def _misjudged(rows: Sequence[Row], best: Choice) -> str:
    """The fitted settings with the slope at the start as it is, and with a wrong one."""
    lines = []
    for method in TABLE_2:
        for part, wrong in (("fitted", 0.0), ("misjudged", START_ERROR), ("misjudged", -START_ERROR)):
            walks = _walks(rows, best, part, method, wrong)
            if walks:
                cells = (cost(walks.get(ground), best.kind, best.length) for ground in GROUNDS)
                lines.append([method, f"{number(wrong, '+g')}°" if wrong else "right", *cells])
    return table(("method", "slope told at the start", *GROUNDS), lines)


def turned(rows: Sequence[Row], best: Choice) -> str:
    """Where a wrong slope at the start makes an X of a number, or a number of an X, in words."""
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
    """A method's walks in the hybrid engine, by ground, told a start slope that is wrong by some degrees."""
    mine = [row for row in rows if (row.part, row.method, row.engine) == (part, method, "hybrid") and best.reads(row)]
    true = {row.ground: row.start_estimate for row in rows if (row.part, row.method) == ("fitted", method)}
    return {row.ground: row for row in mine if math.isclose(row.start_estimate, true[row.ground] + wrong, abs_tol=1e-6)}
