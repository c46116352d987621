"""Tables and numbers of the report, as Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from mjbiped.reproduction.published import TABLE_2
from mjbiped.reproduction.rows import Row

NONE = "–"

ENGINES = {"hybrid": "hybrid", "mujoco": "MuJoCo"}
"""What the engines are called, in the order in which the report has them."""


def table(headings: Sequence[str], lines: Iterable[Sequence[str]], words: int = 1) -> str:
    """A Markdown table, the first columns, of words, to the left and all others to the right."""
    places = ["---"] * words + ["---:"] * (len(headings) - words)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (headings, places, *lines))


def number(value: float | None, form: str = ".4f") -> str:
    """A number, a dash for one that does not exist."""
    return NONE if value is None or not math.isfinite(value) else format(value, form).replace("-", "−")


def percent(ours: float, other: float | None, form: str = "+.1f") -> str:
    """How much more ours is, in percent of the other."""
    return NONE if other is None or math.isnan(ours) else number(100.0 * (ours / other - 1.0), form) + " %"


def paper(method: str, ground: str) -> str:
    """c_mt of Table II, X for a walk that did not come to its end, a dash for a method that is not in it."""
    value = TABLE_2.get(method, {}).get(ground, math.nan)
    return "X" if value is None else number(value)


def delay(value: float | None) -> str:
    """zeta, or that nothing is re-planned."""
    return "none" if value is None else f"{value:g}"


def ending(row: Row) -> str:
    """Why a walk that did not come to its end stopped, and where."""
    struck = f", {row.strikes} riser{'s' * (row.strikes > 1)} struck" if row.strikes else ""
    return f"X ({row.outcome} in step {row.steps + 1}, hip at {number(row.place, '.2f')} m{struck})"


def cost(row: Row | None, kind: str, length: int | None, form: str = ".4f") -> str:
    """c_mt of a walk after some steps, or why there is none."""
    if row is None:
        return NONE
    value = row.cost[kind, length]
    if math.isfinite(value):
        return number(value, form)
    return NONE if row.finished else f"X {row.steps + 1}"
