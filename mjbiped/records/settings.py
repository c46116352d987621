"""Checks of the settings of a record, made once when the record is read.

Reports, figures and repetitions of a walk use the settings that are checked here as they are. Of other settings readers
use only the text: `mjbiped.walk` checks what it is given again.
"""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Callable
from typing import Any, TypeGuard, TypeVar

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.errors import InputError, MjbipedError, RecordError, shown
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains

Part = TypeVar("Part")

MOST_VALUES = 10 * domains.SEGMENTS.high
"""Greatest number of values in a record's header; the longest terrain has about seven for each segment."""

LONGEST_DESCRIPTION = domains.SEGMENTS.high
"""Greatest number of values in a controller's description; the other values of a header leave room for them."""

DEEPEST = 40  # levels of nested settings; the engines' own have five
_LONGEST_REASON = 300  # characters
_LONGEST_NUMBER = 40  # digits of a whole number; a seed has up to twenty
_ALL = {"engine", "robot", "controller", "terrain", "initial", "steps", "distance", "sample_period", "scuffing"}
_TEXTS = {"class", "sha256"}


def parsed(text: str, most: int = MOST_VALUES) -> Any:
    """Read a JSON text into values that are safe to compute with and to write again.

    Args:
        text: JSON text as it stands in a file.
        most: Greatest number of values that it may have; each may have 32 characters on average.

    Raises:
        ValueError: The text is not JSON, too long or nested too deeply, or holds a number or text that cannot be
            written.
    """
    if len(text) > 32 * MOST_VALUES or sum(map(text.count, ",[{")) > most:
        raise ValueError(f"it is too long: {len(text)} characters; expected at most {most} values")
    try:
        value = json.loads(text, parse_int=_whole_number)
        json.dumps(value, ensure_ascii=False).encode()
        depth = _depth(value)
    except RecursionError:
        depth = DEEPEST + 1
    if depth > DEEPEST:
        raise ValueError(f"nested more than {DEEPEST} times")
    return value


def described(controller: object) -> dict[str, Any]:
    """Return a controller's description as it reads after saving and loading a record.

    Args:
        controller: Name and parameters of the controller.

    Raises:
        ValueError: A record with this description could not be read.
    """
    if not _is_named(controller):
        raise ValueError(f"it gives {shown(controller)}; expected a table with a name")
    whole = {"settings": {"controller": controller}}  # as deep as it stands there
    try:
        read: dict[str, Any] = parsed(json.dumps(whole), LONGEST_DESCRIPTION)["settings"]["controller"]
    except (TypeError, RecursionError) as error:
        raise ValueError(f"these are no plain JSON types: {error}") from error
    return read


def _whole_number(text: str) -> int:
    """Read a whole number in JSON of a bounded number of digits."""
    if len(text) > _LONGEST_NUMBER:
        raise ValueError(f"a whole number of {len(text)} digits")
    return int(text)


def _depth(value: object) -> int:
    """Count the levels of nesting of a JSON value."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(_depth, parts), default=-1)


def damaged(what: str) -> RecordError:
    """Return the error of a damaged record; its message continues the file's name."""
    return RecordError(f"is a damaged record: {what}")


def checked_settings(settings: object) -> Robot:
    """Check the settings of a record.

    Args:
        settings: Settings of a header that `parsed` has read.

    Returns:
        The robot that walked.

    Raises:
        RecordError: A setting that every record has is missing, or one is not what readers rely on.
    """
    if not isinstance(settings, dict):
        raise damaged(f"its settings are {shown(settings)}; expected a table")
    if missing := _ALL - settings.keys():
        raise damaged(f"its settings lack {', '.join(map(shown, sorted(missing)))}")
    robot = _built("robot", robot_from, settings["robot"])
    _built("terrain", Terrain.from_dict, settings["terrain"])
    _built("scuffing rule", lambda rule: rule is None or ScuffingRule(**rule), settings["scuffing"])
    _built("disturbances", _disturbances, settings.get("disturbances", {}))
    count, source, warnings = 2 * len(robot.angles), settings.get("controller_source"), settings.get("warnings", {})
    for name, holds, expected in (
        ("engine", isinstance(settings["engine"], str), "a name"),
        ("command", isinstance(settings.get("command", ""), str), "a text"),
        ("controller", _is_named(settings["controller"]), "a table with a name"),
        ("controller_source", source is None or _is_source(source), "a class and the digest of its source"),
        ("initial", is_numbers(settings["initial"], count), f"{count} numbers"),
        ("warnings", isinstance(warnings, dict) and all(map(_is_count, warnings.values())), "numbers of times"),
    ):
        if not holds:
            raise damaged(f"its {name.replace('_', ' ')} is {shown(settings.get(name))}; expected {expected}")
    return robot


def _is_named(controller: object) -> bool:
    return isinstance(controller, dict) and isinstance(controller.get("name"), str)


def _is_source(source: object) -> bool:
    return isinstance(source, dict) and source.keys() == _TEXTS and all(isinstance(v, str) for v in source.values())


def _is_count(value: object) -> bool:
    return type(value) is int and value > 0


def is_numbers(values: object, count: int) -> TypeGuard[list[float]]:
    """Whether a value is a list of `count` finite numbers."""
    return (
        isinstance(values, list)
        and len(values) == count
        and all(type(value) in (int, float) and math.isfinite(value) for value in values)
    )


def _disturbances(written: Any) -> Disturbances:
    """Build disturbances; readers use their values as they stand in the record.

    Raises:
        InputError: `Disturbances.to_dict` would not have written them so.
    """
    made = Disturbances.from_dict(written)
    if made.to_dict() != written:
        raise InputError(f"{shown(written)} is not as it would have been written")
    return made


def _built(what: str, build: Callable[[Any], Part], described: object) -> Part:
    """Build a part of a walk from its description.

    Raises:
        RecordError: It cannot be built.
    """
    try:
        return build(described)
    except (MjbipedError, TypeError, ValueError, ArithmeticError) as error:
        why = textwrap.shorten(str(error), _LONGEST_REASON, placeholder=" ...")
        raise damaged(f"its {what} cannot be built: {why}") from error
