"""Tables and numbers of the report as Markdown, and answers to claims of the paper."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from mjbiped.reproduction.grounds import DIGITS, TABLE_2
from mjbiped.reproduction.rows import Row

NONE = "–"

ENGINES = {"hybrid": "hybrid", "mujoco": "MuJoCo"}
"""What the engines are called, in the order in which the report has them."""


def table(headings: Sequence[str], lines: Iterable[Sequence[str]], words: int = 1) -> str:
    """Write a Markdown table: the first columns hold words and are aligned left, all others right."""
    places = ["---"] * words + ["---:"] * (len(headings) - words)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (headings, places, *lines))


def number(value: float | None, form: str = ".4f") -> str:
    """Write a number; a dash stands for one that does not exist."""
    return NONE if value is None or not math.isfinite(value) else format(value, form).replace("-", "−")


def percent(ours: float, other: float | None, form: str = "+.1f") -> str:
    """Write by how much ours exceeds the other, in percent."""
    return NONE if other is None or math.isnan(ours) else number(100.0 * (ours / other - 1.0), form) + " %"


def paper(method: str, ground: str) -> str:
    """Write c_mt of Table II: X for a walk that did not come to its end, a dash for a method that it lacks."""
    value = TABLE_2.get(method, {}).get(ground, math.nan)
    return "X" if value is None else number(value)


def delay(value: float | None) -> str:
    """Write zeta, or "none" without re-planning."""
    return "none" if value is None else f"{value:g}"


def ending(row: Row) -> str:
    """Write why and where a walk stopped before its end."""
    struck = f", {row.strikes} riser{'s' * (row.strikes > 1)} struck" if row.strikes else ""
    return f"X ({row.outcome} in step {row.steps + 1}, hip at {number(row.place, '.2f')} m{struck})"


def cost(row: Row | None, kind: str, length: int | None, form: str = ".4f") -> str:
    """Write c_mt of a walk after some steps, or where the walk ended before them."""
    if row is None:
        return NONE
    value = row.cost[kind, length]
    if math.isfinite(value):
        return number(value, form)
    return NONE if row.finished else f"X {row.steps + 1}"


class Answer(NamedTuple):
    """The answer of one engine's walks to a claim of the paper.

    Attributes:
        claim: The claim, a sentence that is true or false by itself.
        source: Place of the claim in the paper.
        holds: Whether the claim holds; None where its walks do not exist.
        found: Our numbers.
        of: The part of the walks that was tested, where others did not come to their end; else empty.
    """

    claim: str
    source: str
    holds: bool | None
    found: str = ""
    of: str = ""

    @property
    def verdict(self) -> str:
        """The answer in words, with the numbers."""
        if self.holds is None:
            return f"not asked: {self.found}" if self.found else NONE
        said = ("holds" if self.holds else "**does not hold**") + (f" for {self.of}" if self.of else "")
        return f"{said}: {self.found}" if self.found else said


def answer(claim: str, source: str, holds: bool | None, found: str, of: str = "") -> Answer:
    """Answer a claim; the numbers are left out where there is no answer."""
    return Answer(claim, source, None) if holds is None else Answer(claim, source, holds, found, of)


def printed(value: float) -> float:
    """Round a c_mt to the paper's printed digits, with which claims are compared."""
    return round(value, DIGITS)
