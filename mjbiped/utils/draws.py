"""Distributions from which a quantity is drawn, as study files and environments write them: {"uniform": [4, 5]}."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mjbiped.errors import InputError, shown
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain, known_name

_ENDS: dict[str, tuple[Domain | Count, Domain | Count]] = {
    "uniform": (domains.STUDY_NUMBER, domains.STUDY_NUMBER),
    "log_uniform": (domains.STUDY_POSITIVE, domains.STUDY_POSITIVE),
    "normal": (domains.STUDY_NUMBER, domains.STUDY_POSITIVE),
    "integer": (domains.STUDY_EXACT, domains.STUDY_EXACT),
}
DISTRIBUTIONS = tuple(_ENDS)

Number: TypeAlias = int | float


@dataclass(frozen=True)
class Draw:
    """A distribution from which values are drawn.

    Attributes:
        kind: One of `DISTRIBUTIONS`.
        first: Lower end, included; mean of the normal distribution.
        second: Upper end, of "integer" included; standard deviation of the normal distribution.
    """

    kind: str
    first: float
    second: float

    def value(self, random: np.random.Generator) -> Number:
        """Draw a value."""
        if self.kind == "integer":
            return int(random.integers(int(self.first), int(self.second), endpoint=True))
        if self.kind == "log_uniform":
            return math.exp(random.uniform(math.log(self.first), math.log(self.second)))
        return float(getattr(random, self.kind)(self.first, self.second))

    @property
    def middle(self) -> Number:
        """Median of the distribution."""
        if self.kind == "integer":
            return (int(self.first) + int(self.second)) // 2
        if self.kind == "log_uniform":
            return math.sqrt(self.first * self.second)
        return self.first if self.kind == "normal" else 0.5 * (self.first + self.second)

    @property
    def ends(self) -> tuple[Number, Number]:
        """Least and greatest value; of the normal distribution four standard deviations from its mean."""
        if self.kind == "normal":
            return self.first - 4.0 * self.second, self.first + 4.0 * self.second
        return (int(self.first), int(self.second)) if self.kind == "integer" else (self.first, self.second)


def read_draw(where: str, table: Mapping[str, object]) -> Draw:
    """Read a table of one distribution.

    Args:
        where: Dotted name of the quantity, for messages.
        table: uniform or log_uniform = [low, high], normal = [mean, deviation], integer = [least, greatest].

    Raises:
        InputError: It is no such table, or the ends are not two numbers, or in the wrong order.
    """
    if len(table) != 1:
        raise InputError(f"{where} = {shown(dict(table))}: must be one of {', '.join(DISTRIBUTIONS)} with its two ends")
    ((kind, ends),) = table.items()
    known_name(f"distribution of {where}", kind, DISTRIBUTIONS)
    words = {"normal": "mean, deviation", "integer": "least, greatest"}.get(kind, "low, high")
    if isinstance(ends, str) or not isinstance(ends, Sequence) or len(ends) != 2:
        raise InputError(f"{where}: expected {kind} = [{words}], got {shown(ends)}")
    names = [f"{where}: {kind}, {word}" for word in words.split(", ")]
    lower, upper = _ENDS[kind]
    first, second = float(lower.check(names[0], ends[0])), float(upper.check(names[1], ends[1]))
    if kind != "normal" and not first < second:
        raise InputError(f"{where}: {kind} = {shown(ends)} needs its lower end first")
    return Draw(kind, first, second)
