"""What the settings of a record must be for every reader of them: checked once, when the record is read.

Readers rely on it: a report, a figure, a repetition of the walk take the settings as they are. What else stands beside
those that are named here is the engine's own, and no reader takes more of it than its text.
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
"""Numbers, texts and tables in a record's header at most; the longest terrain has some seven for each segment."""

LONGEST_TEXT = 32 * MOST_VALUES
"""Characters of a record's header at most: a number has up to 24 and a comma."""

LONGEST_DESCRIPTION = domains.SEGMENTS.high
"""Values that a controller may tell of itself; the others of a header leave room for so many."""

DEEPEST = 40  # levels of nested settings; the engines' own have five
_LONGEST_REASON = 300  # characters
_LONGEST_NUMBER = 40  # digits of a whole number; a seed has up to twenty
_DIGEST = 64  # letters of a source's digest


def parsed(text: str, most: int = MOST_VALUES) -> Any:
    """What a JSON text holds, in types that everything can compute with and write again.

    Args:
        text: As it stands in a file.
        most: Values that it may have.

    Raises:
        ValueError: It is no such text, or too long, nested too deep, or holds a number or text that nobody can write.
    """
    if len(text) > LONGEST_TEXT or sum(map(text.count, ",[{")) > most:
        raise ValueError(f"it is too long: {len(text)} characters; expected at most {most} values")
    try:
        value = json.loads(text, parse_int=_whole_number)
    except RecursionError as error:
        raise ValueError(f"nested more than {DEEPEST} times") from error
    _check_nesting(value)
    return value


def described(controller: Any) -> dict[str, Any]:
    """What a controller tells of itself, as it stands in a record that is read again.

    Args:
        controller: Its name and parameters.

    Raises:
        ValueError: No record with it could be read.
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
    """A whole number in JSON that everything can compute with."""
    if len(text) > _LONGEST_NUMBER:
        raise ValueError(f"a whole number of {len(text)} digits")
    return int(text)


def _check_nesting(value: Any) -> None:
    """Refuse what is nested too deep for those who look into it, and text that cannot be written anywhere.

    Raises:
        ValueError: It is.
    """
    level = [value]
    for _ in range(DEEPEST):
        below: list[Any] = []
        for part in level:
            if isinstance(part, str):
                part.encode()
            elif isinstance(part, dict):
                below.extend(part)
                below.extend(part.values())
            elif isinstance(part, list):
                below.extend(part)
        if not below:
            return
        level = below
    raise ValueError(f"nested more than {DEEPEST} times")


def damaged(what: str) -> RecordError:
    """The error of a record that holds what no walk has written; the message goes on from the file's name."""
    return RecordError(f"is a damaged record: {what}")


def checked_settings(settings: Any) -> Robot:
    """Check the settings of a record.

    Args:
        settings: Of a header that `parsed` has read.

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
        _built("scuffing rule", _rule_from, settings["scuffing"])
    checks = {**_CHECKS, **_OF_ENGINES.get(str(settings["engine"]), {})}
    for name, (holds, expected) in checks.items():
        if name in settings and not holds(settings[name]):
            raise damaged(f"its {name.replace('_', ' ')} is {shown(settings[name])}; expected {expected}")
    if "disturbances" in settings:
        _built("disturbances", _disturbances_from, settings["disturbances"])
    return robot


def is_numbers(values: Any, count: int) -> TypeGuard[list[float]]:
    """Whether this is a list of so many finite numbers."""
    return (
        isinstance(values, list)
        and len(values) == count
        and all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
        and all(map(math.isfinite, values))
    )


def _built(what: str, build: Callable[[Any], Part], described: Any) -> Part:
    """A part of a walk, of its description.

    Raises:
        RecordError: It cannot be built.
    """
    try:
        return build(described)
    except (MjbipedError, TypeError, ValueError, ArithmeticError) as error:
        why = textwrap.shorten(str(error), _LONGEST_REASON, placeholder=" ...")
        raise damaged(f"its {what} cannot be built: {why}") from error


def _rule_from(described: Mapping[str, Any]) -> ScuffingRule:
    return ScuffingRule(**described)


def _disturbances_from(described: Mapping[str, Any]) -> Disturbances:
    made = Disturbances.from_dict(described)
    if made.to_dict() != described:  # readers take the values as they stand there
        raise InputError(f"{shown(described)} is not as it would have been written")
    return made


_Check = tuple[Callable[[Any], bool], str]
"""Whether a value is one that readers take, and in words what is expected."""


def _text(value: Any) -> bool:
    return isinstance(value, str)


def _truth(value: Any) -> bool:
    return isinstance(value, bool)


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
    "engine": (_text, "a name"),
    "controller": (lambda told: isinstance(told, dict) and _text(told.get("name")), "a table with a name"),
    "controller_source": (
        lambda told: (
            isinstance(told, dict)
            and told.keys() == {"class", "sha256"}
            and all(map(_text, told.values()))
            and len(told["sha256"]) == _DIGEST
        ),
        "a class and the digest of its source",
    ),
    "steps": _in(domains.STEPS, needed=False),
    "distance": _in(domains.DISTANCE, needed=False),
    "sample_period": _in(domains.SAMPLE_PERIOD, needed=False),
    "versions": _table_of(_text, "texts"),
    "warnings": _table_of(lambda count: type(count) is int and count > 0, "numbers of times"),
}
"""Of the settings of all engines, beside those that are built."""

_ALL = (
    *("engine", "robot", "controller", "terrain", "initial"),
    *("steps", "distance", "sample_period", "scuffing", "versions"),
)
"""Settings that every record has had since the first format."""

_OF_ENGINES: Mapping[str, Mapping[str, _Check]] = {
    "mujoco": {
        "timestep": _in(domains.TIMESTEP),
        "contact_timestep": _in(domains.CONTACT_TIMESTEP),
        "control_period": _in(domains.CONTROL_PERIOD, needed=False),
        "ground": (_text, "a name"),
        "lands": (_truth, "true or false"),
        "stance_knee": (_text, "a name"),
    },
    "hybrid": {"tolerance": _in(domains.TOLERANCE), "compiled": (_truth, "true or false")},
}
"""Of the engines of this package; those of others are their own."""
