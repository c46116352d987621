"""Repetition of a recorded walk: the command and the Python program that give bitwise the same record."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from mjbiped.control.registry import SHARED, SLOPE_FIELD, make_controller, names_by_class, settings_of
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD
from mjbiped.errors import MjbipedError
from mjbiped.gaits.described import words_of
from mjbiped.gaits.optimised import only_kept
from mjbiped.gaits.steps import Goal
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import NAMED
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import parse_terrain

_ENGINES: Mapping[str, type[Mujoco] | type[Hybrid]] = {"mujoco": Mujoco, "hybrid": Hybrid}
_ENGINE_OPTIONS = ("timestep", "contact_timestep", "control_period", "stance_knee")
_OWN_OPTIONS = ("position_gain", "velocity_gain", "adaptation_gain", "replanning_delay", "estimate_update",
                "slope_source", *SHARED)  # fmt: skip
"""Settings of controllers that have options of their own; `--gain` sets all others."""

Option = tuple[str, Any]
"""Name and value of an option; the value is None for a flag."""


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
            words = ["mjbiped", "walk", _terrain(walk)]
            for name, value in _options(walk):
                option, text = f"--{name.replace('_', '-')}", str(value)
                if value is None:
                    words += [option]
                else:
                    words += [f"{option}={text}"] if text.startswith("-") else [option, text]
    except (_NotSayableError, MjbipedError, KeyError, TypeError, ValueError):
        return None
    return shlex.join(words)


class _NotSayableError(Exception):
    """The command line cannot express a setting."""


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


def _options(walk: Walk) -> Iterator[Option]:
    """Options of the command.

    Raises:
        _NotSayableError: The command line has no option for a setting.
    """
    settings = walk.settings
    if settings["engine"] != "mujoco":
        yield "engine", settings["engine"]
    yield from ((name, settings[name]) for name in ("steps", "distance") if settings[name] is not None)
    yield "initial", ",".join(map(repr, settings["initial"]))  # numbers: a name would depend on the controller
    yield from _controller(walk)
    for name, value in _changed(_ENGINES[settings["engine"]](), settings).items():
        if name not in (*_ENGINE_OPTIONS, "lands"):
            raise _NotSayableError
        yield _switch(name, value) if isinstance(value, bool) else (name, value)
    robots = {name: NAMED[name]() for name in NAMED}
    parameters = {
        name: _changed(robot, walk.robot.to_dict()) for name, robot in robots.items() if robot.kind == walk.robot.kind
    }
    named = min(parameters, key=lambda each: len(parameters[each]))
    if named != Compass.kind:
        yield "robot", named
    for name, value in parameters[named].items():
        yield name, ",".join(map(repr, value)) if name == "sole" else value
    disturbances = dict(settings.get("disturbances", {}))
    yield from (("push", f"{time!r}:{impulse!r}") for time, impulse in disturbances.pop("pushes", ()))
    yield from (("disturb", f"{name}={value!r}") for name, value in disturbances.items())
    rule = ScuffingRule(**(settings["scuffing"] or {}))
    if rule != ScuffingRule():
        yield "scuffing_reach", rule.reach
    if rule != ScuffingRule(reach=rule.reach) or settings["sample_period"] != DEFAULT_SAMPLE_PERIOD:
        raise _NotSayableError


def _changed(usual: Any, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings that differ from those of a dataclass's instance."""
    own = {field.name: getattr(usual, field.name) for field in fields(usual)}
    return {name: settings[name] for name in own if settings.get(name, own[name]) != own[name]}


def _controller(walk: Walk) -> Iterator[Option]:
    """Options for the controller's name and settings.

    Raises:
        _NotSayableError: It is not registered, or these words would make another one.
    """
    described, robot = walk.settings["controller"], walk.robot
    name = names_by_class(robot).get(described["name"])
    if "controller_source" in walk.settings or name is None:
        raise _NotSayableError
    usual, settings = settings_of(name, robot), dict(described)
    if "gait" in described:
        gait = described["gait"]
        settings["initial_slope_estimate_deg"] = _degrees(described.get(SLOPE_FIELD, 0.0))
        if "goal" in gait:
            settings["reference"] = words_of(Goal(**gait["goal"]))
        else:
            settings["imitate_slope_deg"] = _degrees(gait["slope"])
    passive = "imitate_slope_deg"  # always said, for not every robot imitates a passive gait unless told
    chosen = {
        key: settings[key] for key in usual if key in settings and (key == passive or settings[key] != usual[key])
    }
    if make_controller(name, robot, chosen).describe() != described:
        raise _NotSayableError
    if name != "adaptive":
        yield "controller", name
    for key, value in chosen.items():
        if key not in _OWN_OPTIONS:
            yield "gain", f"{key}={'none' if value is None else value}"
        elif isinstance(value, bool):
            yield _switch(key, value)
        else:
            yield key, "none" if value is None else value


def _switch(name: str, value: bool) -> Option:
    """The option that switches something on or off."""
    return (name if value else f"no_{name}"), None


def _degrees(angle: float) -> float:
    """Degrees that read back as this angle, with as few digits as possible; else the closest."""
    degrees = math.degrees(angle)
    return next((short for digits in range(17) if math.radians(short := round(degrees, digits)) == angle), degrees)
