"""Reading a study file: its sections, and in them the choices for each quantity by its dotted name.

A choice is a value, several, a range, or a distribution to draw from. What a walk cannot have is refused by its cell.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, TypeAlias

import numpy as np

from mjbiped.control.registry import DEFAULT_CONTROLLER
from mjbiped.disturbances.disturbances import SETTINGS
from mjbiped.engines.names import DEFAULT_ENGINE
from mjbiped.engines.plan import INITIAL_STATES
from mjbiped.errors import InputError, shortened, shown
from mjbiped.sweeps.cell import LIMIT, LIMITS, OPTIONS, Scalar, check_keys
from mjbiped.terrain.files import FILE_KEY
from mjbiped.utils import domains
from mjbiped.utils.domains import known_name
from mjbiped.utils.draws import DISTRIBUTIONS, Draw, read_draw

SCALES = ("linear", "log")
_RANGE = ("from", "to", "count", "scale")

_DIGITS = 12  # of a range's inner values: 0.3 and not 0.30000000000000004


Choice: TypeAlias = tuple[Scalar | Draw, ...]
"""The values of a grid (a single one where the quantity is fixed); a distribution counts as one value."""

OF_WALK = ("engine", *LIMITS, *OPTIONS)
SECTIONS = ("initial", "controller", "robot", "model", "disturbances", "scuffing", "terrain")
SCUFFING = ("reach", "delay")

_NAMES = ("kind", "name")
"""Keys of a section that decide what else can stand in it, and come first."""
_VALID = {"disturbances": SETTINGS, "scuffing": SCUFFING}
_USUAL = {"controller": {"name": DEFAULT_CONTROLLER}, "terrain": {"name": "mixed"}}
_ENDS, _PLUS_MINUS = {"low", "high"}, {"plus_minus"}

Settings: TypeAlias = dict[str, Choice]
"""Choices by dotted names."""


def parts_of(content: Mapping[str, Any]) -> Iterator[list[Settings]]:
    """Read the parts of a file that are combined with one another, each a list of alternatives; the terrain is last.

    Raises:
        InputError: A part holds no choice.
    """
    for key in OF_WALK:
        if key in content or key == "engine":
            name = f"{LIMIT}.{key}" if key in LIMITS else key
            yield [{name: read_choice(key, content.get(key, DEFAULT_ENGINE))}]
    for section in SECTIONS:
        value = content.get(section, INITIAL_STATES[0] if section == "initial" else {})
        tables = value if isinstance(value, list) else [value]
        if section == "initial" and any(isinstance(each, str) for each in tables):
            yield [{section: read_choice(section, value)}]
        elif not tables or not all(isinstance(table, Mapping) for table in tables):
            raise InputError(f"{section} must be a table [{section}], or several, [[{section}]]; got {shown(value)}")
        elif section in content or section in _USUAL:
            yield [read_section(section, table) for table in tables]


def read_section(section: str, table: Mapping[str, object]) -> Settings:
    """Read the choices of a table; the ends of a terrain's range are quantities of their own.

    Raises:
        InputError: Something in it is no choice.
    """
    if section in _VALID:
        check_keys(f"setting of {section}", table, _VALID[section])
    usual = {} if FILE_KEY in table and "name" not in table else _USUAL.get(section, {})
    names = {key: table[key] for key in _NAMES if key in table}
    settings: Settings = {}
    for key, value in {**usual, **names, **table}.items():
        place = f"{section}.{key}"
        where = shortened(place)
        if section == "terrain" and isinstance(value, Mapping) and {*value} & (_ENDS | _PLUS_MINUS):
            if {*value} not in (_ENDS, _PLUS_MINUS):
                raise InputError(f"{where}: expected {{low, high}} or {{plus_minus}}, got {shown([*value])}")
            settings |= {f"{place}.{end}": read_choice(f"{where}.{end}", each) for end, each in value.items()}
        else:
            settings[place] = read_choice(where, value)
    return settings


def read_table(content: Mapping[str, object], name: str, valid: Iterable[str] | None = None) -> Mapping[str, Any]:
    """Return a table of a file; an empty one where it is missing.

    Raises:
        InputError: It is no table, or has another key than the valid ones, where these are given.
    """
    table = content.get(name, {})
    if not isinstance(table, Mapping):
        raise InputError(f"{name} must be a table [{name}], got {shown(table)}")
    check_keys(f"key of {name}", table, table if valid is None else valid)
    return table


def generator(seed: int, sample: int, name: str) -> np.random.Generator:
    """Generator of a quantity's value in a sample; depends on the seed of the study, the sample and the name alone."""
    key = (sample, zlib.crc32(name.encode()))
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=key)))


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
