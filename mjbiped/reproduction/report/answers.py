"""A claim of the paper and what one engine's walks say to it."""

from __future__ import annotations

from typing import NamedTuple

from mjbiped.reproduction.published import DIGITS
from mjbiped.reproduction.report.markdown import NONE


class Answer(NamedTuple):
    """What the walks of one engine say to a claim.

    Attributes:
        claim: In a sentence that is true or false by itself.
        source: Where the paper has it.
        holds: Whether it does; None where the walks that it is about do not exist.
        found: Our numbers.
        of: Of which part of the walks it was asked, where others did not come to their end; else empty.
    """

    claim: str
    source: str
    holds: bool | None
    found: str = ""
    of: str = ""

    @property
    def verdict(self) -> str:
        """The answer, with the numbers."""
        if self.holds is None:
            return f"not asked: {self.found}" if self.found else NONE
        said = ("holds" if self.holds else "**does not hold**") + (f" for {self.of}" if self.of else "")
        return f"{said}: {self.found}" if self.found else said


def printed(value: float) -> float:
    """A c_mt as the paper prints it: c_mt is compared so, as the claims can be seen there."""
    return round(value, DIGITS)
