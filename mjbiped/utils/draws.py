"""Choices for a quantity, as study files write them: values, ranges, or a distribution, {"uniform": [4, 5]}.

Settings of environments write distributions in the same form.
"""

from __future__ import annotations

import math
import zlib
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

Scalar: TypeAlias = bool | int | float | str
"""A value of a quantity."""

SCALES = ("linear", "log")
_RANGE = ("from", "to", "count", "scale")
_DIGITS = 12  # of a range's inner values: 0.3 and not 0.30000000000000004


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


Choice: TypeAlias = tuple[Scalar | Draw, ...]
"""The values of a grid (a single one where the quantity is fixed); a distribution counts as one value."""


def read_choice(where: str, value: object) -> Choice:
    """Read the choice of a study file for a quantity.

    Args:
        where: Dotted name of the quantity, for messages.
        value: A number, a text or a truth value; a list of them; a table {from, to, count, scale}; or a table of one
            distribution: uniform or log_uniform = [low, high], normal = [mean, deviation], integer = [least, greatest].

    Raises:
        InputError: It is anything else.
    """
    if isinstance(value, Mapping):
        for key in value:
            known_name(f"way to vary {where}", key, (*_RANGE, *DISTRIBUTIONS))
        return _read_range(where, value) if {*value} & {*_RANGE} else (read_draw(where, value),)
    if not isinstance(value, list):
        return (_scalar(where, value),)
    values = tuple(_scalar(f"{where}, value {i}", each) for i, each in enumerate(value, start=1))
    if not values or len({(type(each), each) for each in values}) < len(values):
        raise InputError(f"{where} = {shown(value)}: must be a list of at least one value, each of them once")
    return values


def _scalar(where: str, value: object) -> Scalar:
    if not isinstance(value, bool | int | float | str):
        raise InputError(f"{where} = {shown(value)}: must be a number, a text, true or false")
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{where} = {shown(value)}: must be finite")
    return Count(-(2**64), 2**64).check(where, value) if type(value) is int else value


def _read_range(where: str, table: Mapping[str, object]) -> tuple[Scalar, ...]:
    if not {"from", "to", "count"} <= {*table} <= {*_RANGE}:
        raise InputError(f"{where} has the keys {', '.join(table)}; a range has from, to, count, and scale at will")
    scale = known_name(f"scale of {where}", table.get("scale", "linear"), SCALES)
    domain = domains.STUDY_POSITIVE if scale == "log" else domains.STUDY_NUMBER
    first, last = (domain.check(f"{where}: {end}", table[end]) for end in ("from", "to"))
    count = Count(2, domains.WALKS.high).check(f"{where}: count", table["count"])
    if first == last:
        raise InputError(f"{where} goes from {first:g} to {last:g}; give one value, or two different ends")
    whole = isinstance(table["from"], int) and isinstance(table["to"], int)
    if whole and scale == "linear" and (last - first) % (count - 1) == 0.0:
        step = round((last - first) / (count - 1))
        return tuple(round(first) + step * i for i in range(count))
    spaced = np.geomspace if scale == "log" else np.linspace
    inner = (float(f"{value:.{_DIGITS}g}") for value in spaced(first, last, count)[1:-1].tolist())
    return (first, *inner, last)


def generator(seed: int, sample: int, name: str) -> np.random.Generator:
    """Generator of a quantity's value in a sample; depends on the seed of the study, the sample and the name alone."""
    key = (sample, zlib.crc32(name.encode()))
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=key)))
