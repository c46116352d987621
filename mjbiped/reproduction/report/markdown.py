"""Numbers, walks, and answers to claims of the paper, as texts of the report."""

from __future__ import annotations

import math
from typing import NamedTuple

from mjbiped.reproduction.grounds import DIGITS, TABLE_2
from mjbiped.reproduction.rows import Row

NONE = "–"

ENGINES = {"hybrid": "hybrid", "mujoco": "MuJoCo"}
"""What the engines are called, in the order in which the report has them."""


def number(value: float | None, form: str = ".4f") -> str:
    """Write a number; a dash stands for one that does not exist."""
    return NONE if value is None or not math.isfinite(value) else format(value, form).replace("-", "−")


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


def ending(row: Row | None, finished: str) -> str:
    """Write why and where a walk stopped before its end, or a text for one that came to it."""
    if row is None:
        return NONE
    if row.finished:
        return finished
    struck = f", {row.strikes} riser{'s' * (row.strikes > 1)} struck" if row.strikes else ""
    return f"X ({row.outcome} in step {row.steps + 1}, hip at {number(row.place, '.2f')} m{struck})"


def cost(row: Row | None, kind: str, length: int | None) -> str:
    """Write c_mt of a walk after some steps (None: at its end), or the step in which it ended before that."""
    if row is None:
        return NONE
    value = row.cost[kind, length]
    came = row.finished or (length is not None and math.isfinite(value))
    return number(value) if came else f"X {row.steps + 1}"


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
