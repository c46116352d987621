"""Checks of the settings of a record, made once when the record is read.

Readers rely on them: a report, a figure or a repetition of the walk uses the settings as they are. Settings that are
not named here are the engine's own, and readers use only their text.
"""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Callable, Mapping
from typing import Any, TypeGuard, TypeVar

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.errors import InputError, MjbipedError, RecordError, shown
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain

Part = TypeVar("Part")

MOST_VALUES = 10 * domains.SEGMENTS.high
"""Greatest number of values in a record's header; the longest terrain has about seven for each segment."""

LONGEST_TEXT = 32 * MOST_VALUES
"""Greatest number of characters in a record's header: a number has up to 24 and a comma."""

LONGEST_DESCRIPTION = domains.SEGMENTS.high
"""Greatest number of values in a controller's description; the other values of a header leave room for them."""

DEEPEST = 40  # levels of nested settings; the engines' own have five
_LONGEST_REASON = 300  # characters
_LONGEST_NUMBER = 40  # digits of a whole number; a seed has up to twenty
_DIGEST = 64  # letters of a source's digest


def parsed(text: str, most: int = MOST_VALUES) -> Any:
    """Read a JSON text into values that are safe to compute with and to write again.

    Args:
        text: JSON text as it stands in a file.
        most: Greatest number of values that it may have.

    Raises:
        ValueError: The text is not JSON, too long or nested too deeply, or holds a number or text that cannot be
            written.
    """
    if len(text) > LONGEST_TEXT or sum(map(text.count, ",[{")) > most:
        raise ValueError(f"it is too long: {len(text)} characters; expected at most {most} values")
    try:
        value = json.loads(text, parse_int=_whole_number)
        depth = _depth(value)
    except RecursionError:
        depth = DEEPEST + 1
    if depth > DEEPEST:
        raise ValueError(f"nested more than {DEEPEST} times")
    return value


def described(controller: Any) -> dict[str, Any]:
    """Return a controller's description as it reads after saving and loading a record.

    Args:
        controller: Name and parameters of the controller.

    Raises:
        ValueError: A record with this description could not be read.
    """
    holds, expected = _CHECKS["controller"]
    if not holds(controller):
        raise ValueError(f"it gives {shown(controller)}; expected {expected}")
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


def _depth(value: Any) -> int:
    """Count the levels of nesting of a JSON value.

    Raises:
        ValueError: It holds a text that cannot be written anywhere.
    """
    if isinstance(value, str):
        value.encode()
    parts = [*value, *value.values()] if isinstance(value, dict) else value if isinstance(value, list) else []
    return 1 + max(map(_depth, parts)) if parts else 0


def damaged(what: str) -> RecordError:
    """Return the error of a damaged record; its message continues the file's name."""
    return RecordError(f"is a damaged record: {what}")


def checked_settings(settings: Any) -> Robot:
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
    missing = [name for name in _ALL if name not in settings]
    if missing:
        raise damaged(f"its settings lack {', '.join(map(shown, missing))}")
    robot = _built("robot", robot_from, settings["robot"])
    _built("terrain", Terrain.from_dict, settings["terrain"])
    count = 2 * len(robot.angles)
    if not is_numbers(settings["initial"], count):
        raise damaged(f"its initial state is {shown(settings['initial'])}; expected {count} numbers")
    if settings["scuffing"] is not None:
        _built("scuffing rule", lambda described: ScuffingRule(**described), settings["scuffing"])
    checks = {**_CHECKS, **_OF_ENGINES.get(str(settings["engine"]), {})}
    for name, (holds, expected) in checks.items():
        if name in settings and not holds(settings[name]):
            raise damaged(f"its {name.replace('_', ' ')} is {shown(settings[name])}; expected {expected}")
    if "disturbances" in settings:
        made = _built("disturbances", Disturbances.from_dict, settings["disturbances"])
        if made.to_dict() != settings["disturbances"]:  # readers use the values as they stand there
            described = shown(settings["disturbances"])
            raise damaged(f"its disturbances cannot be built: {described} is not as it would have been written")
    return robot


def is_numbers(values: Any, count: int) -> TypeGuard[list[float]]:
    """Whether a value is a list of `count` finite numbers."""
    return (
        isinstance(values, list)
        and len(values) == count
        and all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
        and all(map(math.isfinite, values))
    )


def _built(what: str, build: Callable[[Any], Part], described: Any) -> Part:
    """Build a part of a walk from its description.

    Raises:
        RecordError: It cannot be built.
    """
    try:
        return build(described)
    except (MjbipedError, TypeError, ValueError, ArithmeticError) as error:
        why = textwrap.shorten(str(error), _LONGEST_REASON, placeholder=" ...")
        raise damaged(f"its {what} cannot be built: {why}") from error


_Check = tuple[Callable[[Any], bool], str]
"""Function that tells whether a value is valid, and what is expected in words."""


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


_NAME: _Check = (_is_text, "a name")
_TRUTH: _Check = (lambda value: isinstance(value, bool), "true or false")


def _in(domain: Domain | Count, *, needed: bool = True) -> _Check:
    def holds(value: Any) -> bool:
        try:
            return (value is None and not needed) or domain.check("", value) == value
        except InputError:
            return False

    return holds, domain.words if needed else f"{domain.words}, or none"


def _table_of(holds: Callable[[Any], bool], expected: str) -> _Check:
    return lambda table: isinstance(table, dict) and all(map(holds, table.values())), f"a table of {expected}"


_CHECKS: Mapping[str, _Check] = {
    "engine": _NAME,
    "controller": (lambda told: isinstance(told, dict) and _is_text(told.get("name")), "a table with a name"),
    "controller_source": (
        lambda told: (
            isinstance(told, dict)
            and told.keys() == {"class", "sha256"}
            and all(map(_is_text, told.values()))
            and len(told["sha256"]) == _DIGEST
        ),
        "a class and the digest of its source",
    ),
    "steps": _in(domains.STEPS, needed=False),
    "distance": _in(domains.DISTANCE, needed=False),
    "sample_period": _in(domains.SAMPLE_PERIOD, needed=False),
    "versions": _table_of(_is_text, "texts"),
    "warnings": _table_of(lambda count: type(count) is int and count > 0, "numbers of times"),
}
"""Checks of the settings of all engines; parts of a walk such as its terrain are checked by building them."""

_ALL = (
    *("engine", "robot", "controller", "terrain", "initial"),
    *("steps", "distance", "sample_period", "scuffing", "versions"),
)
"""Settings in every record since the first format."""

_OF_ENGINES: Mapping[str, Mapping[str, _Check]] = {
    "mujoco": {
        "timestep": _in(domains.TIMESTEP),
        "contact_timestep": _in(domains.CONTACT_TIMESTEP),
        "control_period": _in(domains.CONTROL_PERIOD, needed=False),
        "ground": _NAME,
        "lands": _TRUTH,
        "stance_knee": _NAME,
    },
    "hybrid": {"tolerance": _in(domains.TOLERANCE)},
}
"""Checks of the settings of this package's engines; other engines have their own settings."""
