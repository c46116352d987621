"""Repetition of a recorded walk: the command and the Python program that give bitwise the same record."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from mjbiped.control.registry import SHARED, SLOPE_FIELDS, make_controller, names_by_class, settings_of
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD
from mjbiped.errors import MjbipedError
from mjbiped.gaits.described import words_of
from mjbiped.gaits.optimisation import Goal
from mjbiped.gaits.optimised import only_kept
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import NAMED
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import parse_terrain

_ENGINES: Mapping[str, type[Mujoco] | type[Hybrid]] = {"mujoco": Mujoco, "hybrid": Hybrid}
_OWN_OPTIONS = ("position_gain", "velocity_gain", "adaptation_gain", "replanning_delay", "estimate_update")
"""Settings of the adaptive controller that have options of their own; `--gain` sets all others."""

_PASSIVE = "imitate_slope_deg"  # the setting that means a passive gait


def python_of(walk: Walk, record: str) -> str | None:
    """Write a program that repeats the walk.

    Args:
        walk: The record.
        record: Path of the record in the program.

    Returns:
        The program; None if the engine is not one of mjbiped's own.
    """
    settings = walk.settings
    engine = _ENGINES.get(settings["engine"])
    if engine is None:
        return None
    set_here = {each.name: settings[each.name] for each in fields(engine) if each.name in settings}
    rule = "None" if settings["scuffing"] is None else 'mjbiped.ScuffingRule(**settings["scuffing"])'
    source = settings.get("controller_source")
    named = "" if source is None else f', settings["controller_source"], named={source["class"]!r}'
    of_engine = ", ".join(f"{name}={value!r}" for name, value in set_here.items())
    return f"""import mjbiped
from mjbiped.control.registry import controller_from

before = mjbiped.Walk.load({record!r})
settings = before.settings
again = mjbiped.walk(
    controller_from(settings["controller"]{named}),
    before.terrain,
    engine=mjbiped.{engine.__name__}({of_engine}),
    robot=before.robot,
    initial=settings["initial"],
    steps=settings["steps"],
    distance=settings["distance"],
    sample_period=settings["sample_period"],
    scuffing={rule},
    disturbances=mjbiped.Disturbances.from_dict(settings.get("disturbances", {{}})),
)
print(again.summary())
print("the same, bit by bit:", again == before)
"""


def command_of(walk: Walk) -> str | None:
    """Write the command that repeats the walk; None if no command does, as for terrains made in Python."""
    try:
        with only_kept():  # what the record asks for would have to be searched for minutes, to know what it gives
            return shlex.join(["mjbiped", "walk", *_words(walk)])
    except (_NotSayableError, MjbipedError, KeyError, TypeError, ValueError):
        return None


class _NotSayableError(Exception):
    """The command line cannot express a setting."""


def _words(walk: Walk) -> Iterator[str]:
    settings = walk.settings
    yield _terrain(walk)
    yield from ("--engine", settings["engine"]) if settings["engine"] != "mujoco" else ()
    yield from _limits(settings)
    yield "--initial=" + ",".join(map(repr, settings["initial"]))  # numbers: a name would depend on the controller
    yield from _controller(walk)
    yield from _engine(settings)
    yield from _robot(walk.robot)
    for name, value in settings.get("disturbances", {}).items():
        if name == "pushes":
            yield from (f"--push={time!r}:{impulse!r}" for time, impulse in value)
        else:
            yield from ("--disturb", f"{name}={value!r}")
    rule = ScuffingRule(**(settings["scuffing"] or {}))
    if rule != ScuffingRule(reach=rule.reach):
        raise _NotSayableError
    if rule != ScuffingRule():
        yield from ("--scuffing-reach", repr(rule.reach))


def _robot(robot: Robot) -> Iterator[str]:
    """Options for the most similar named robot, and for the parameters that differ from it."""
    alike = (each for each in NAMED if isinstance(NAMED[each](), type(robot)))
    name = min(alike, key=lambda each: len(_odd(robot, NAMED[each]())))
    yield from ("--robot", name) if name != Compass.kind else ()
    for parameter, value in _odd(robot, NAMED[name]()).items():
        yield from (_option(parameter), repr(value))


def _odd(robot: Robot, usual: Robot) -> dict[str, float]:
    """Parameters of a robot that differ from those of the named robot."""
    values = {name: getattr(robot, name) for name in robot.parameters()}
    return {name: value for name, value in values.items() if value != getattr(usual, name)}


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _terrain(walk: Walk) -> str:
    """Argument for the terrain.

    Raises:
        _NotSayableError: No argument stands for this ground.
    """
    terrain = walk.terrain
    said = [f"{key}={'..'.join(map(repr, v)) if isinstance(v, tuple) else repr(v)}" for key, v in terrain.parameters]
    text = f"{terrain.name}:{','.join(said)}" if said else terrain.name
    if parse_terrain(text) != terrain:
        raise _NotSayableError
    return text


def _limits(settings: Mapping[str, Any]) -> Iterator[str]:
    if settings["sample_period"] != DEFAULT_SAMPLE_PERIOD:
        raise _NotSayableError
    for name in ("steps", "distance"):
        if settings[name] is not None:
            yield from (_option(name), repr(settings[name]))


def _controller(walk: Walk) -> Iterator[str]:
    """Options for the controller's name and settings.

    Raises:
        _NotSayableError: It is not registered, or these words would make another one.
    """
    described, robot = walk.settings["controller"], walk.robot
    names = names_by_class(robot)
    if "controller_source" in walk.settings or described["name"] not in names:
        raise _NotSayableError
    name = names[described["name"]]
    usual = settings_of(name, robot)
    chosen = {key: described[key] for key in usual if key in described and described[key] != usual[key]}
    shared: dict[str, Any] = {}
    if "gait" in described:
        shared |= _gait(described["gait"])
        shared["initial_slope_estimate_deg"] = _degrees(
            next(described[key] for key in SLOPE_FIELDS if key in described)
        )
    # of a robot with knees the usual gait is no passive one
    chosen |= {
        key: value
        for key, value in shared.items()
        if value != SHARED[key] or ("shank" in robot.angles and key == _PASSIVE)
    }
    if make_controller(name, robot, chosen).describe() != described:
        raise _NotSayableError
    yield from ("--controller", name) if name != "adaptive" else ()
    for key, value in chosen.items():
        if isinstance(value, bool) and key in _OWN_OPTIONS:
            yield _option(key) if value else _option(f"no_{key}")
        elif key in (*shared, *_OWN_OPTIONS, "slope_source"):
            yield f"{_option(key)}={'none' if value is None else value}"
        else:
            yield from ("--gain", f"{key}={'none' if value is None else value}")


def _gait(described: Mapping[str, Any]) -> dict[str, Any]:
    """Setting of a controller that stands for a gait."""
    if "goal" in described:
        return {"reference": words_of(Goal(**described["goal"]))}
    return {_PASSIVE: _degrees(described["slope"])}


def _degrees(angle: float) -> float:
    """Degrees that read back as this angle, with as few digits as possible; else the closest."""
    degrees = math.degrees(angle)
    return next((short for digits in range(17) if math.radians(short := round(degrees, digits)) == angle), degrees)


def _engine(settings: Mapping[str, Any]) -> Iterator[str]:
    """Options for settings of the engine that are not the defaults.

    Raises:
        _NotSayableError: The command line has no option for one.
    """
    usual = _ENGINES[settings["engine"]]()
    for field in fields(usual):
        value = settings.get(field.name, getattr(usual, field.name))
        if value == getattr(usual, field.name):
            continue
        if field.name == "lands":
            yield "--plain-steps"
        elif field.name == "stance_knee":
            yield from (_option(field.name), value)
        elif field.name in ("timestep", "contact_timestep", "control_period"):
            yield from (_option(field.name), repr(value))
        else:
            raise _NotSayableError
