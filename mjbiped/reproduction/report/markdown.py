"""Numbers and walks as texts of the report."""

from __future__ import annotations

import math
from collections.abc import Iterable

from mjbiped.reproduction.grounds import DIGITS, TABLE_2
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice

NONE = "–"

ENGINES = {"hybrid": "hybrid", "mujoco": "MuJoCo"}
"""What the engines are called, in the order in which the report has them."""


def body(lines: Iterable[Iterable[str]]) -> str:
    """Write the lines of a table in Markdown, whose headings stand in the page's template."""
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def number(value: float, form: str = ".4f") -> str:
    """Write a number; a dash stands for one that does not exist."""
    return format(value, form).replace("-", "−") if math.isfinite(value) else NONE


def share(value: float, form: str = ".0f") -> str:
    """Write a share in percent."""
    return f"{number(100 * value, form)} %"


def excess(ours: float, other: float | None, form: str = "+.1f") -> str:
    """Write by how much ours exceeds the other, in percent."""
    return NONE if other is None or math.isnan(ours) else share(ours / other - 1.0, form)


def paper(method: str, ground: str) -> str:
    """Write c_mt of Table II: X for a walk that did not come to its end, a dash for a method that it lacks."""
    value = TABLE_2.get(method, {}).get(ground, math.nan)
    return "X" if value is None else number(value)


def delay(value: float | None) -> str:
    """Write zeta, or "none" without re-planning."""
    return "none" if value is None else f"{value:g}"


def ending(row: Row, finished: str) -> str:
    """Write why and where a walk stopped before its end, or a text for one that came to it."""
    if not row.outcome:
        return NONE
    if row.finished:
        return finished
    struck = f", {row.strikes} riser{'s' * (row.strikes > 1)} struck" if row.strikes else ""
    return f"X ({row.outcome} in step {row.steps + 1}, hip at {number(row.place, '.2f')} m{struck})"


def cost(row: Row, kind: str = "absolute", length: int | None = None) -> str:
    """Write c_mt of a walk after some steps, or at its end, or the step in which it ended before that."""
    value = getattr(row, f"{kind}_{length or 'end'}")
    if row.finished or (length and math.isfinite(value)):
        return number(value)
    return f"X {row.steps + 1}" if row.outcome else NONE


def best_cost(row: Row, best: Choice) -> str:
    """Write c_mt of a walk as the best reading takes it."""
    return cost(row, best.kind, best.length)


def printed(value: float) -> float:
    """Round a c_mt to the paper's printed digits, with which claims are compared."""
    return round(value, DIGITS)
