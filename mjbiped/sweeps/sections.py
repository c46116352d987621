"""The sections of a study file, read: which names they may hold, and what each can be."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import Any, TypeAlias

from mjbiped.control.loading import located
from mjbiped.control.registry import DEFAULT_CONTROLLER, controller_class, settings_of
from mjbiped.disturbances.disturbances import SETTINGS
from mjbiped.engines.names import DEFAULT_ENGINE
from mjbiped.engines.plan import INITIAL_STATES
from mjbiped.errors import InputError, shown
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import NAMED, named
from mjbiped.robots.robot import Robot
from mjbiped.sweeps.cell import LIMIT, LIMITS, OPTIONS, ROBOT, state_of
from mjbiped.sweeps.values import Choice, Draw, check_keys, read_choice
from mjbiped.terrain.files import FILE_KEY
from mjbiped.terrain.presets import PRESETS
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name

OF_WALK = ("engine", *LIMITS, *OPTIONS)
SECTIONS = ("initial", "controller", "robot", "model", "disturbances", "scuffing", "terrain")
SCUFFING = ("reach", "delay")
KIND = "kind"
"""Key of a section `robot` that names one of `NAMED`; `ROBOT` unless given."""

_PARTS_OF_RANGE = ("low", "high", "plus_minus")

Settings: TypeAlias = dict[str, Choice]
"""Choices by dotted names."""


def parts_of(content: Mapping[str, Any], folder: Path) -> Iterator[list[Settings]]:
    """The parts of a file that are combined with one another; each is a list of alternatives. The last is the terrain.

    Args:
        content: Of the file.
        folder: Where it stands, and the files of controllers that it names.

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
        yield [_initial(table, kinds) for table in _tables("initial", initial)]
    else:
        yield [{"initial": read_choice("initial", initial)}]
    yield [read_controller(table, folder, kinds) for table in _tables("controller", content.get("controller", {}))]
    if "robot" in content:
        yield robots
    if "model" in content:
        parameters = list(dict.fromkeys(name for kind in kinds for name in kind.parameters()))
        yield [_named("model", "parameter of the model", parameters, t) for t in _tables("model", content["model"])]
    if "disturbances" in content:
        yield [
            _named("disturbances", "disturbance", SETTINGS, t) for t in _tables("disturbances", content["disturbances"])
        ]
    if "scuffing" in content:
        yield [_named("scuffing", "setting of scuffing", SCUFFING, t) for t in _tables("scuffing", content["scuffing"])]
    yield [_terrain(table) for table in _tables("terrain", content.get("terrain", {}))]


def _tables(key: str, value: object) -> list[Mapping[str, Any]]:
    """The alternatives of a section: one table, or several.

    Raises:
        InputError: It is no table.
    """
    tables: list[Any] = value if isinstance(value, list) else [value]
    if not tables or not all(isinstance(table, Mapping) for table in tables):
        raise InputError(f"{key} must be a table [{key}], or several, [[{key}]] each; got {shown(value)}")
    return tables


def read_robot(table: Mapping[str, Any]) -> Settings:
    """The robot that walks: its name, and parameters that are not as usual.

    Raises:
        InputError: There is no such robot or parameter.
    """
    chosen = {KIND: read_choice(f"robot.{KIND}", table[KIND])} if KIND in table else {}
    names = _names("robot", f"robot.{KIND}", chosen.get(KIND, (ROBOT,)), NAMED)
    parameters = {name: named(name)[0].parameters() for name in names}
    settings = {f"robot.{key}": choice for key, choice in chosen.items()}
    for key, value in table.items():
        if key != KIND:
            _known_to_all("robot", key, parameters, KIND)
            settings[f"robot.{key}"] = read_choice(f"robot.{key}", value)
    return settings


def kinds_of(robots: Iterable[Settings]) -> tuple[type[Robot], ...]:
    """The kinds of robots that a study's sections `robot` name."""
    names = [str(name) for settings in robots for name in _texts("robot", settings.get(f"robot.{KIND}", (ROBOT,)))]
    return tuple(dict.fromkeys(named(name)[0] for name in names))


def _initial(table: Mapping[str, Any], kinds: Sequence[type[Robot]]) -> Settings:
    states = [state_of(kind) for kind in kinds]
    check_keys("key of initial", table, tuple(dict.fromkeys(["around", *(key for each in states for key in each)])))
    if "around" not in table and all(any(key not in table for key in each) for each in states):
        wanted = " or ".join(", ".join(each) for each in states)
        raise InputError(
            f"initial needs all of {wanted} (rad, rad/s), or around = one of {', '.join(INITIAL_STATES)} and the "
            "deviations from it"
        )
    settings = {f"initial.{key}": read_choice(f"initial.{key}", value) for key, value in table.items()}
    _names("initial.around", "initial.around", settings.get("initial.around", ()), INITIAL_STATES)
    return settings


def read_controller(table: Mapping[str, Any], folder: Path, kinds: Sequence[type[Robot]] = (Compass,)) -> Settings:
    """A controller's name and settings.

    Args:
        table: Of the file.
        folder: Where the file stands, and the files of controllers that it names.
        kinds: Of the robots that it drives; a setting may be one for some of them.

    Raises:
        InputError: There is no such controller or setting.
    """
    settings = {"controller.name": read_choice("controller.name", table.get("name", DEFAULT_CONTROLLER))}
    names = {name: located(name, folder) for name in _texts("controller.name", settings["controller.name"])}
    for place in names.values():
        controller_class(place)
    robots = {kind.knees: kind() for kind in kinds}.values()
    for key, value in table.items():
        if key != "name":
            valid = {
                name: {key: None for robot in robots for key in settings_of(place, robot)}
                for name, place in names.items()
            }
            _known_to_all("controller", key, valid, "name")
            settings[f"controller.{key}"] = read_choice(f"controller.{key}", value)
    return settings


def _named(section: str, what: str, names: Sequence[str], table: Mapping[str, Any]) -> Settings:
    """Choices of a section all of whose names are known."""
    check_keys(what, table, names)
    return {f"{section}.{key}": read_choice(f"{section}.{key}", value) for key, value in table.items()}


def _terrain(table: Mapping[str, Any]) -> Settings:
    if FILE_KEY in table and "name" not in table:
        check_keys("key of a terrain of a file", table, (FILE_KEY,))
        return {"terrain.file": read_choice("terrain.file", table[FILE_KEY])}
    settings = {"terrain.name": read_choice("terrain.name", table.get("name", "mixed"))}
    names = _names("terrain", "terrain.name", settings["terrain.name"], PRESETS)
    parameters = {name: signature(getattr(Terrain, name)).parameters for name in names}
    for key, value in table.items():
        if key == "name":
            continue
        _known_to_all("terrain", key, parameters, "name", "file")
        where = f"terrain.{key}"
        ranges = {isinstance(parameters[name][key].default, tuple) for name in names}
        if ranges == {False}:
            settings[where] = read_choice(where, value)
        elif ranges == {True}:
            settings.update(_read_range_setting(where, value))
        else:
            raise InputError(
                f"{where} is a range for some of {', '.join(names)} and a number for others: give each its own "
                "[[terrain]]"
            )
    return settings


def _read_range_setting(where: str, value: object) -> Settings:
    """Choices for a setting that is a range itself.

    Raises:
        InputError: It is not a text, a list of texts, nor a table of `_PARTS_OF_RANGE`.
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


def _names(what: str, where: str, choice: Choice, valid: Iterable[str]) -> tuple[str, ...]:
    """A choice that must be of names.

    Args:
        what: They are of, for messages.
        where: They stand in the file.
        choice: As it was read.
        valid: The names that there are.

    Raises:
        InputError: It is of something else, or of a name that is unknown.
    """
    return tuple(known_name(what, name, valid) for name in _texts(where, choice))


def _texts(where: str, choice: Choice) -> tuple[str, ...]:
    """A choice that must be of texts.

    Raises:
        InputError: It is of something else.
    """
    if isinstance(choice, Draw) or not all(isinstance(name, str) for name in choice):
        raise InputError(f"{where} must be a name, or a list of names")
    return tuple(str(name) for name in choice)


def _known_to_all(section: str, key: str, valid: Mapping[str, Any], *others: str) -> None:
    """Refuse a key that is unknown to one of the names that share a table.

    Raises:
        InputError: It is.
    """
    for name, keys in valid.items():
        if key not in keys and len(valid) > 1 and any(key in each for each in valid.values()):
            raise InputError(f"{section} {name} has no {key}: give {name} its own [[{section}]], without it")
        known_name(f"setting of the {section} {name}", key, (*keys, *(() if key in keys else others)))
