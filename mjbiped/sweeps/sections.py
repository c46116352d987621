"""Reading the sections of a study file: the valid names, and the choices for each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, TypeAlias

from mjbiped.control.loading import located
from mjbiped.control.registry import DEFAULT_CONTROLLER, controller_class, settings_of
from mjbiped.disturbances.disturbances import SETTINGS
from mjbiped.engines.names import DEFAULT_ENGINE
from mjbiped.engines.plan import INITIAL_STATES
from mjbiped.errors import InputError, shown
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import named
from mjbiped.robots.robot import Robot
from mjbiped.sweeps.cell import LIMIT, LIMITS, OPTIONS, ROBOT
from mjbiped.sweeps.values import Choice, check_keys, read_choice
from mjbiped.terrain.files import FILE_KEY
from mjbiped.terrain.presets import PRESETS
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name
from mjbiped.utils.draws import Draw

OF_WALK = ("engine", *LIMITS, *OPTIONS)
SECTIONS = ("initial", "controller", "robot", "model", "disturbances", "scuffing", "terrain")
SCUFFING = ("reach", "delay")
KIND = "kind"
"""Key of a section `robot` that names one of `NAMED`; `ROBOT` unless given."""

_PARTS_OF_RANGE = ("low", "high", "plus_minus")

Settings: TypeAlias = dict[str, Choice]
"""Choices by dotted names."""


def parts_of(content: Mapping[str, Any], folder: Path) -> Iterator[list[Settings]]:
    """Read the parts of a file that are combined with one another, each a list of alternatives; the terrain is last.

    Args:
        content: Content of the file.
        folder: The file's folder, where the controllers' files are looked for.

    Raises:
        InputError: A part holds an unknown name or no choice.
    """
    robots = [read_robot(table) for table in _tables("robot", content.get("robot", {}))]
    kinds = kinds_of(robots)
    for key in OF_WALK:
        if key in content or key == "engine":
            name = f"{LIMIT}.{key}" if key in LIMITS else key
            yield [{name: read_choice(key, content.get(key, DEFAULT_ENGINE))}]
    initial = content.get("initial", INITIAL_STATES[0])
    alternatives = initial if isinstance(initial, list) else [initial]
    if not isinstance(initial, str | list) or any(isinstance(each, Mapping) for each in alternatives):
        tables = _tables("initial", initial)
        yield [{f"initial.{key}": read_choice(f"initial.{key}", value) for key, value in one.items()} for one in tables]
    else:
        yield [{"initial": read_choice("initial", initial)}]
    yield [read_controller(table, folder, kinds) for table in _tables("controller", content.get("controller", {}))]
    if "robot" in content:
        yield robots
    for section, what, names in (
        ("model", "parameter of the model", [name for kind in kinds for name in kind.parameters()]),
        ("disturbances", "disturbance", SETTINGS),
        ("scuffing", "setting of scuffing", SCUFFING),
    ):
        if section in content:
            tables = _tables(section, content[section])
            for table in tables:
                check_keys(what, table, dict.fromkeys(names))
            yield [
                {f"{section}.{key}": read_choice(f"{section}.{key}", table[key]) for key in table} for table in tables
            ]
    yield [_terrain(table) for table in _tables("terrain", content.get("terrain", {}))]


def _tables(key: str, value: object) -> list[Mapping[str, Any]]:
    """Return the alternatives of a section: one table, or several.

    Raises:
        InputError: The value is neither.
    """
    tables: list[Any] = value if isinstance(value, list) else [value]
    if not tables or not all(isinstance(table, Mapping) for table in tables):
        raise InputError(f"{key} must be a table [{key}], or several, [[{key}]] each; got {shown(value)}")
    return tables


def _named(
    section: str,
    table: Mapping[str, Any],
    key: str,
    usual: str,
    valid: Callable[[str], Iterable[str]],
    read: Callable[[str, object], Settings] | None = None,
) -> Settings:
    """Read a table in which one setting, a name, decides what other settings are valid.

    Args:
        section: The table's name.
        table: The table.
        key: Key of that setting.
        usual: Its value unless the table has it.
        valid: Valid other settings for a name; raises an error for an unknown name.
        read: Reads a setting from its dotted name and value; `read_choice` unless given.

    Raises:
        InputError: A name is unknown, or a setting is unknown to one of the names.
    """
    where = f"{section}.{key}"
    names = _texts(where, read_choice(where, table.get(key, usual)))
    known = {name: list(valid(name)) for name in names}
    settings: Settings = {where: names}
    for other, value in table.items():
        if other == key:
            continue
        for name, keys in known.items():
            if other not in keys and any(other in each for each in known.values()):
                raise InputError(f"{section} {name} has no {other}: give {name} its own [[{section}]], without it")
            known_name(f"setting of the {section} {name}", other, (*keys, *(() if other in keys else (key,))))
        place = f"{section}.{other}"
        settings |= read(place, value) if read is not None else {place: read_choice(place, value)}
    return settings


def read_robot(table: Mapping[str, Any]) -> Settings:
    """Read the robot that walks: its name, and parameters that are not as usual.

    Raises:
        InputError: There is no such robot or parameter.
    """
    settings = _named("robot", table, KIND, ROBOT, lambda name: named(name)[0].parameters())
    return {place: choice for place, choice in settings.items() if place != f"robot.{KIND}" or KIND in table}


def kinds_of(robots: Iterable[Settings]) -> tuple[type[Robot], ...]:
    """Kinds of robots that the sections `robot` of a study name."""
    names = [str(name) for settings in robots for name in _texts("robot", settings.get(f"robot.{KIND}", (ROBOT,)))]
    return tuple(dict.fromkeys(named(name)[0] for name in names))


def read_controller(table: Mapping[str, Any], folder: Path, kinds: Sequence[type[Robot]] = (Compass,)) -> Settings:
    """Read a controller's name and settings.

    Args:
        table: The controller's table.
        folder: The file's folder, where the controllers' files are looked for.
        kinds: Kinds of the robots that it drives; a setting may be one for some of them.

    Raises:
        InputError: There is no such controller or setting.
    """
    robots = [kind() for kind in kinds]

    def settings_for(name: str) -> list[str]:
        place = located(name, folder)
        controller_class(place)
        return list(dict.fromkeys(key for robot in robots for key in settings_of(place, robot)))

    return _named("controller", table, "name", DEFAULT_CONTROLLER, settings_for)


def _terrain(table: Mapping[str, Any]) -> Settings:
    if FILE_KEY in table and "name" not in table:
        check_keys("key of a terrain of a file", table, (FILE_KEY,))
        return {"terrain.file": read_choice("terrain.file", table[FILE_KEY])}
    parameters: dict[str, Mapping[str, Parameter]] = {}

    def parameters_of(name: str) -> Iterable[str]:
        parameters[name] = signature(getattr(Terrain, known_name("terrain", name, PRESETS))).parameters
        return parameters[name]

    def read(where: str, value: object) -> Settings:
        key = where.removeprefix("terrain.")
        ranges = {isinstance(each[key].default, tuple) for each in parameters.values()}
        if ranges == {True}:
            return _read_range_setting(where, value)
        if ranges == {False}:
            return {where: read_choice(where, value)}
        raise InputError(
            f"{where} is a range for some of {', '.join(parameters)} and a number for others: give each its own "
            "[[terrain]]"
        )

    return _named("terrain", table, "name", "mixed", parameters_of, read)


def _read_range_setting(where: str, value: object) -> Settings:
    """Read a setting that is a range of numbers.

    Raises:
        InputError: The value is not a text, a list of texts or a table of `_PARTS_OF_RANGE`.
    """
    if isinstance(value, Mapping):
        check_keys(f"part of the range {where}", value, _PARTS_OF_RANGE)
        if {*value} not in ({"low", "high"}, {"plus_minus"}):
            raise InputError(f"{where}: expected {{low, high}} or {{plus_minus}}, got {shown([*value])}")
        return {f"{where}.{key}": read_choice(f"{where}.{key}", part) for key, part in value.items()}
    choice = read_choice(where, value)
    if isinstance(choice, Draw) or not all(isinstance(each, str) for each in choice):
        raise InputError(
            f'{where} is a range: give it as "low..high", several as a list of these, or its ends as '
            f"{{low = ..., high = ...}} or {{plus_minus = ...}}; got {shown(value)}"
        )
    return {where: choice}


def _texts(where: str, choice: Choice) -> tuple[str, ...]:
    """Return the texts of a choice.

    Raises:
        InputError: The choice holds something else.
    """
    if isinstance(choice, Draw) or not all(isinstance(name, str) for name in choice):
        raise InputError(f"{where} must be a name, or a list of names")
    return tuple(str(name) for name in choice)
