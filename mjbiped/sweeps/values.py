"""Choices of a study file for one quantity: a value, several, a range, or a distribution to draw from."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Mapping
from typing import TypeAlias

import numpy as np

from mjbiped.errors import InputError, shown
from mjbiped.utils import domains
from mjbiped.utils.domains import known_name
from mjbiped.utils.draws import DISTRIBUTIONS, Draw, read_draw

Scalar: TypeAlias = bool | int | float | str

SCALES = ("linear", "log")
_RANGE = ("from", "to", "count", "scale")

_DIGITS = 12  # of a range's inner values: 0.3 and not 0.30000000000000004


Choice: TypeAlias = tuple[Scalar | Draw, ...]
"""The values of a grid (a single one where the quantity is fixed); a distribution counts as one value."""


def generator(seed: int, sample: int, name: str) -> np.random.Generator:
    """Generator of a quantity's value in a sample; depends on the seed of the study, the sample and the name alone."""
    key = (sample, zlib.crc32(name.encode()))
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=key)))


def check_keys(what: str, table: Iterable[str], valid: Iterable[str]) -> None:
    """Refuse a table with unknown keys.

    Raises:
        InputError: A key is unknown; the message says what kind of key it is.
    """
    for key in table:
        known_name(what, key, valid)


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
        check_keys(f"way to vary {where}", value, (*_RANGE, *DISTRIBUTIONS))
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
    return domains.STUDY_WHOLE.check(where, value) if type(value) is int else value


def _read_range(where: str, table: Mapping[str, object]) -> tuple[Scalar, ...]:
    if not {"from", "to", "count"} <= {*table} <= {*_RANGE}:
        raise InputError(f"{where} has the keys {', '.join(table)}; a range has from, to, count, and scale at will")
    scale = known_name(f"scale of {where}", table.get("scale", "linear"), SCALES)
    domain = domains.STUDY_POSITIVE if scale == "log" else domains.STUDY_NUMBER
    first, last = (domain.check(f"{where}: {end}", table[end]) for end in ("from", "to"))
    count = domains.STUDY_RANGE.check(f"{where}: count", table["count"])
    if first == last:
        raise InputError(f"{where} goes from {first:g} to {last:g}; give one value, or two different ends")
    whole = isinstance(table["from"], int) and isinstance(table["to"], int)
    if whole and scale == "linear" and (last - first) % (count - 1) == 0.0:
        step = round((last - first) / (count - 1))
        return tuple(round(first) + step * i for i in range(count))
    spaced = np.geomspace if scale == "log" else np.linspace
    inner = (float(f"{value:.{_DIGITS}g}") for value in spaced(first, last, count)[1:-1].tolist())
    return (first, *inner, last)
