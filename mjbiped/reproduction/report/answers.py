"""Answers to the claims of the paper in `claims.toml`."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from mjbiped.reproduction.grounds import FILES
from mjbiped.reproduction.report.markdown import NONE

CLAIMS: dict[str, tuple[str, str]] = tomllib.loads((FILES / "claims.toml").read_text(encoding="utf-8"))
"""Place in the paper and sentence, by name."""


class Answer(NamedTuple):
    """The answer of one engine's walks to a claim of the paper.

    Attributes:
        claim: The claim, a sentence that is true or false by itself.
        source: Place of the claim in the paper.
        holds: Whether the claim holds; None where its walks do not exist.
        found: Our numbers.
        of: The part of the walks that was tested, where others did not come to their end; else empty.
        engine: Engine of the walks.
        group: One of `mjbiped.reproduction.report.checks.GROUPS`.
    """

    claim: str
    source: str
    holds: bool | None
    found: str = ""
    of: str = ""
    engine: str = ""
    group: str = ""

    @property
    def verdict(self) -> str:
        """The answer in words, with the numbers; a dash without an answer."""
        if self.holds is None:
            return NONE
        said = ("holds" if self.holds else "**does not hold**") + (f" for {self.of}" if self.of else "")
        return f"{said}: {self.found}" if self.found else said


Words = Mapping[str, str | float]
"""What is filled into a claim's braces."""


def answer(
    name: str, words: Words, holds: bool | None, found: str = "", numbers: Iterable[float] = (), of: str = ""
) -> Answer:
    """Answer a claim, unless one of its numbers does not exist; the other arguments are as in `Answer`."""
    source, claim = CLAIMS[name]
    if holds is None or any(map(math.isnan, numbers)):
        return Answer(claim.format(**words), source, None)
    return Answer(claim.format(**words), source, holds, found, of)
