"""Make terrain, robot, controller and engine from the options of a command."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import click

import mjbiped
from mjbiped.cli import options
from mjbiped.cli.commands import Given
from mjbiped.control.controller import Controller
from mjbiped.control.loading import value_of
from mjbiped.control.registry import DEFAULT_CONTROLLER, controller_class, make_controller
from mjbiped.engines import base
from mjbiped.engines.base import Engine
from mjbiped.errors import InputError, prefixed, shortened, shown
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import KINDS, NAMED, named, robot_named
from mjbiped.robots.robot import Robot
from mjbiped.terrain.files import parse_parameters, parse_toml
from mjbiped.terrain.presets import RANDOM
from mjbiped.terrain.terrain import Terrain, parse_terrain
from mjbiped.utils.domains import known_name
from mjbiped.utils.files import read_text

_Robot = TypeVar("_Robot", bound=Robot)


def walker(text: str, given: Given) -> tuple[Controller, Terrain]:
    """Make the controller and the terrain of a walk.

    Robot, scuffing rule and disturbances replace their options in `given`; those of controller and terrain are removed.

    Raises:
        MjbipedError: Terrain, robot or controller cannot be as the options say.
    """
    terrain = terrain_of(text, given.pop("seed", None))
    robot = robot_of(given)
    disturbances = disturbances_of(given.pop("disturb", ()), given.pop("push", ()))
    controller = controller_of(model_of(robot, given.pop("model_error", ())), given)
    given |= {"robot": robot, "disturbances": disturbances, "scuffing": scuffing_of(given)}
    return controller, terrain


def scuffing_of(given: Given) -> mjbiped.ScuffingRule:
    """Make the scuffing rule of a command."""
    return mjbiped.ScuffingRule(reach=given.pop("scuffing_reach", mjbiped.ScuffingRule.reach))


def robot_of(given: Given) -> Robot:
    """Make the robot of a command, and remove its options from `given`.

    Raises:
        click.UsageError: An option is given that the robot does not have.
        InputError: The file cannot be read, or a number is outside its domain.
    """
    text = given.pop("robot", Compass.kind)
    with prefixed("--robot "):
        name, written = _described(text)
        for key in given.keys() & {*options.PARAMETERS} - {*named(name)[0].parameters()}:
            owners = ", ".join(each for each in NAMED if key in named(each)[0].parameters())
            given.refuse({key}, f"--robot {owners}", text)
        with prefixed(f"{shown(text)}: "):
            return robot_named(name, {**written, **given.take(options.PARAMETERS)})


def _described(text: str) -> tuple[str, dict[str, Any]]:
    """Return a robot's name, and its parameters where they stand in a file."""
    if not text.endswith((".toml", ".xml")):
        return known_name("robot", text, (*NAMED, "a .toml file", "an .xml file")), {}
    if text.endswith(".xml"):
        from mjbiped.exchange.foreign import read_file  # for such files alone

        robot, limits = read_file(text)
        _tell(text, robot, limits)
        written = robot.to_dict()
        return written.pop("kind", Compass.kind), written  # records name no compass
    with prefixed(f"{shown(text)}: "):
        written = parse_toml(read_text(Path(text)))
        if "kind" not in written and (foreign := sorted(written.keys() - {*Compass.parameters()})):
            raise InputError(
                f"its kind is missing; without one it is a {Compass.kind}, which has no {shortened(foreign[0])}: write "
                f"kind = one of {', '.join(KINDS)}"
            )
        known_name("robot", written.get("kind", Compass.kind), NAMED)
    return written.pop("kind", Compass.kind), written


def _tell(file: str, robot: Robot, limits: Mapping[str, float]) -> None:
    """Warn that motors of a robot from an MJCF file have no limits here, where a walk's options bound no torque."""
    chosen = click.get_current_context().params
    bounded = any(name == "torque_limit" for name, _ in chosen.get("disturb", ()))
    if limits and "disturb" in chosen and not bounded and not chosen.get("quiet"):
        told = ", ".join(f"{name} {limit:g} N m" for name, limit in limits.items())
        click.echo(
            f"Warning: motors have no limits here, unlike those in {file} ({told}); give --disturb torque_limit=X, "
            f"or one number for each of {', '.join(robot.joints)}, with commas between them.",
            err=True,
        )


def controller_of(robot: Robot, given: Given, usual: str = DEFAULT_CONTROLLER) -> Controller:
    """Make the controller of a command, and remove its options from `given`.

    Args:
        robot: The robot model of the law.
        given: Options of the command.
        usual: Name of the controller if none is given.

    Raises:
        MjbipedError: There is no such controller, it has no such setting, a gain is outside its domain, or the slope
            to be imitated has no passive gait.
    """
    name, settings = given.pop("controller", usual), given.take(options.LAW)
    for key, text in dict(given.pop("gain", ())).items():
        with prefixed(f"--gain {shortened(key)}: "):
            if key in settings:
                raise InputError(f"--{key.replace('_', '-')} is given, too; give one of them")
            settings[key] = value_of(controller_class(name, robot), key, text)
    return make_controller(name, robot, settings)


def disturbances_of(
    given: Iterable[tuple[str, str]], pushes: Sequence[tuple[float, float]]
) -> mjbiped.Disturbances | None:
    """Make the disturbances of a command; None if there are none.

    Args:
        given: Names and values as texts.
        pushes: Times (s) and impulses (N s).

    Raises:
        InputError: A name is unknown or given twice, or a value is outside its domain.
    """
    values: dict[str, Any] = {"pushes": pushes} if pushes else {}
    for name, text in given:
        with prefixed("--disturb "):
            known_name("disturbance", name, options.DISTURBANCES)
            if name in values:
                raise InputError(f"{name} is given twice; give it once")
            values[name] = value_of(mjbiped.Disturbances, name, text)
    return mjbiped.Disturbances(**values) if values else None


def model_of(robot: _Robot, errors: Sequence[tuple[str, float]]) -> _Robot:
    """Make the controller's model of a robot.

    Args:
        robot: The robot that walks.
        errors: Names of its parameters, and the factors by which the model's differ.

    Raises:
        InputError: A name is given twice, or the model is not a valid robot.
    """
    with prefixed("--model-error: "):
        if len(dict(errors)) < len(errors):
            raise InputError("a name is given twice; give it once")
        for name, _ in errors:
            known_name("parameter of the robot", name, robot.numbers())
    changed = {name: factor * getattr(robot, name) for name, factor in errors}
    return replace(robot, **changed) if changed else robot  # type: ignore[type-var]  # every robot is a dataclass


def terrain_of(text: str, seed: int | None) -> Terrain:
    """Make the terrain that a text and a seed describe.

    Raises:
        InputError: The text describes none, or the seed does not fit it.
    """
    terrain = parse_terrain(text)
    if seed is None:
        return terrain
    name, parameters = _random(text)
    if not name:
        raise InputError(f"--seed is for the terrains {', '.join(RANDOM)}; {shown(text)} has none")
    if parameters.setdefault("seed", seed) != seed:
        raise InputError(f"--seed {seed} contradicts {shown(text)}; give one of them")
    return Terrain.preset(name, **parameters)


def next_ground(text: str, seed: int | None) -> Callable[[], Terrain] | None:
    """Return a function that makes the terrain of the next seed at each call; None where the ground is not random.

    Args:
        text: A text that `terrain_of` accepts.
        seed: Seed that was given with the text; None without one.
    """
    name, parameters = _random(text)
    if not name:
        return None
    seeds = itertools.count(int(parameters.pop("seed", seed or 0)) + 1)
    return lambda: Terrain.preset(name, **{**parameters, "seed": next(seeds)})


def _random(text: str) -> tuple[str, dict[str, Any]]:
    """Return name and parameters of random ground; the name is empty where the text describes other ground."""
    name, _, rest = text.partition(":")
    if name.strip() not in RANDOM:
        return "", {}
    return name.strip(), parse_parameters(rest) if rest.strip() else {}


def engine_of(name: str, given: Given) -> Engine:
    """Make the engine of a command, and remove its options from `given`.

    Raises:
        click.UsageError: An option is given that the engine does not have.
        InputError: One is outside its domain.
    """
    if name == mjbiped.Mujoco.name:
        return mujoco_of(given)
    given.refuse(options.MUJOCO, f"--engine {mjbiped.Mujoco.name}", name)
    return base.engine_of(name)


def mujoco_of(given: Given) -> mjbiped.Mujoco:
    """Make the MuJoCo engine of a command, and remove its options from `given`."""
    return mjbiped.Mujoco(**given.take(options.MUJOCO))
