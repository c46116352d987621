"""Reading the sections of a study file: choices by dotted names. What a walk cannot have is refused by its cell."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, TypeAlias

from mjbiped.control.registry import DEFAULT_CONTROLLER
from mjbiped.disturbances.disturbances import SETTINGS
from mjbiped.engines.names import DEFAULT_ENGINE
from mjbiped.engines.plan import INITIAL_STATES
from mjbiped.errors import InputError, shortened, shown
from mjbiped.sweeps.cell import LIMIT, LIMITS, OPTIONS
from mjbiped.sweeps.values import Choice, check_keys, read_choice
from mjbiped.terrain.files import FILE_KEY

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


def read_section(section: str, table: Mapping[str, Any]) -> Settings:
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


def read_table(content: Mapping[str, Any], name: str, valid: Iterable[str] | None = None) -> Mapping[str, Any]:
    """Return a table of a file; an empty one where it is missing.

    Raises:
        InputError: It is no table, or has another key than the valid ones, where these are given.
    """
    table = content.get(name, {})
    if not isinstance(table, Mapping):
        raise InputError(f"{name} must be a table [{name}], got {shown(table)}")
    check_keys(f"key of {name}", table, table if valid is None else valid)
    return table
