"""The settings of a controller: the fields of its dataclass, their defaults and valid types."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from numbers import Integral
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from mjbiped.errors import InputError, shown
from mjbiped.utils.domains import as_float, parse_number

REQUIRED = MISSING
"""Stands for the default of a setting that has none."""

_WORDS = {bool: "true or false", int: "a whole number", float: "a finite number", str: "a text", types.NoneType: "none"}
_READ = {"none": None, "true": True, "false": False}


def fields_of(kind: type) -> Mapping[str, Field[object]]:
    """Return the fields of a controller's dataclass that its constructor takes, by name; empty for other classes."""
    return {field.name: field for field in fields(kind) if field.init} if is_dataclass(kind) else {}


def default_of(field: Field[Any]) -> object:
    """Return the default of a field; `REQUIRED` where it has none."""
    return field.default if field.default_factory is MISSING else field.default_factory()


def why_none(kind: type) -> str:
    """Return advice for a controller class that has no fields; empty for a dataclass."""
    if is_dataclass(kind):
        return ""
    return (
        f"; {kind.__name__} is no dataclass: write @dataclass(frozen=True) above the class, and its parameters as "
        "fields, stiffness: float = 20.0 for instance (robot: mjbiped.Compass and gait: mjbiped.Gait are filled in)"
    )


def shown_defaults(settings: Mapping[str, object]) -> str:
    """Write settings with their defaults for a message."""
    return ", ".join(f"{key} (needed)" if value is REQUIRED else f"{key}={value}" for key, value in settings.items())


def value_of(kind: type, name: str, text: str) -> Any:
    """Read the value of a field from a text on the command line, by the field's type.

    Raises:
        InputError: The text is no value of the field's type.
    """
    text, number = text.strip(), parse_number(text.strip())
    word = text.lower()
    meanings = [*([_READ[word]] if word in _READ else []), *([] if number is None else [number]), text]
    wanted = _kinds(kind, name)
    return checked(kind, name, next((each for each in meanings if _fits(each, wanted)), text))


def checked(kind: type, name: str, value: object) -> Any:
    """Check a value against a field's type; a whole number also passes where a float is asked for.

    The class itself checks what the type does not say, such as a gain's domain.

    Raises:
        InputError: The value is of another type.
    """
    wanted = _kinds(kind, name)
    if value == "none" and types.NoneType in wanted and str not in wanted:
        return None
    if _fits(value, wanted):
        return as_float(value) if isinstance(value, Integral) and float in wanted and int not in wanted else value
    words = " or ".join(
        "one of " + ", ".join(map(str, get_args(each)))
        if get_origin(each) is Literal
        else _WORDS.get(each, f"a {getattr(each, '__name__', each)}, which cannot be given here")
        for each in wanted
    )
    raise InputError(f"{name} = {shown(value)}: must be {words}, as a field of {kind.__name__}")


def _kinds(kind: type, name: str) -> tuple[Any, ...]:
    """Return the types that a field takes; none where they are not known."""
    try:
        hint = get_type_hints(kind).get(name, Any)
    except Exception:  # names that stand only where a type checker sees them
        return ()
    kinds = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    return () if Any in kinds else kinds


def _fits(value: object, wanted: tuple[object, ...]) -> bool:
    """Whether a value is of one of some types, or of any type where none is known."""

    def fits(kind: object) -> bool:
        if get_origin(kind) is Literal:
            return value in get_args(kind)
        if kind is float:
            return math.isfinite(as_float(value))
        if kind is int:
            return isinstance(value, Integral) and not isinstance(value, bool)
        return type(value) is kind

    return not wanted or any(map(fits, wanted))
