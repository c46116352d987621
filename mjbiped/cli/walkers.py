"""Make terrain, robot, controller and engine from the options of a command."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import click

import mjbiped
from mjbiped.cli import options
from mjbiped.cli.kinds import MODEL, OWNERS
from mjbiped.cli.sections import is_given, refuse, section, taken
from mjbiped.control.controller import Controller
from mjbiped.control.loading import is_reference
from mjbiped.control.registry import SHARED, controller_class, make_controller, settings_of
from mjbiped.control.settings import shown_defaults, value_of, why_none
from mjbiped.disturbances.disturbances import SETTINGS, Disturbances
from mjbiped.engines import names
from mjbiped.engines.base import Engine
from mjbiped.errors import InputError, prefixed, shortened, shown
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import NAMED, named, robot_named
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.files import parse_parameters, parse_toml
from mjbiped.terrain.presets import RANDOM
from mjbiped.terrain.terrain import Terrain, parse_terrain
from mjbiped.utils.domains import known_name, nearest
from mjbiped.utils.files import read_text

_Robot = TypeVar("_Robot", bound=Robot)


def walker(ctx: click.Context, values: dict[str, Any]) -> tuple[Controller, Terrain]:
    """Make the controller and the terrain of a command, and remove their options from `values`.

    Robot, scuffing rule and disturbances replace their options in `values`.

    Raises:
        click.UsageError: An option is given that the controller does not have.
        MjbipedError: Terrain, robot or controller cannot be as the options say.
    """
    terrain = terrain_of(values.pop("terrain"), values.pop("seed"))
    values["robot"] = robot_of(ctx, values)
    values["disturbances"] = disturbances_of(values.pop("disturb"), values.pop("pushes"))
    controller = controller_of(ctx, model_of(values["robot"], values.pop("model_error")), values)
    values["scuffing"] = ScuffingRule(reach=values.pop("scuffing_reach"))
    return controller, terrain


def robot_of(ctx: click.Context, values: dict[str, Any]) -> Robot:
    """Make the robot of a command, and remove its options from `values`.

    Raises:
        click.UsageError: An option is given that the robot does not have.
        InputError: The file cannot be read, or a number is outside its domain.
    """
    text = values.pop("robot")
    name, written = _described(text)
    kind, _ = named(name)
    for each in ctx.command.params:
        if each.name in OWNERS.keys() - kind.parameters():
            refuse(ctx, [each], f"--robot {', '.join(OWNERS[str(each.name)])}", text)
    numbers = {key: values.pop(key) for key in OWNERS}
    given = {key: value for key, value in numbers.items() if is_given(ctx, key)}
    with prefixed("" if text in NAMED else f"--robot {shown(text)}: "):
        return robot_named(name, {**written, **given})


def _described(text: str) -> tuple[str, dict[str, Any]]:
    """Return a robot's name, and its parameters where they stand in a file."""
    if text in NAMED:
        return text, {}
    with prefixed("--robot "):
        if text.endswith(MODEL):
            from mjbiped.exchange.foreign import read_robot  # for such files alone

            written = read_robot(text).to_dict()
        else:
            with prefixed(f"{shown(text)}: "):
                written = parse_toml(read_text(Path(text)))
    return written.pop("kind", Compass.kind), written


def controller_of(ctx: click.Context, robot: Robot, values: dict[str, Any]) -> Controller:
    """Make the controller of a command, and remove its options from `values`.

    Raises:
        click.UsageError: An option is given that the controller does not have.
        MjbipedError: There is no such controller, a gain is outside its domain, or the slope to be imitated has no
            passive gait.
    """
    name, gains = values.pop("controller"), dict(values.pop("gain"))
    settings = taken(ctx, values, options.ADAPTIVE, options.COMPARISON)
    valid = settings_of(name, robot)
    _refuse_options(ctx, name, valid)
    fields = options.gains_of(name, robot)
    for unknown in gains.keys() - fields.keys():
        said = f"valid are {shown_defaults(fields)}" if fields else f"it has none{why_none(controller_class(name))}"
        raise click.UsageError(
            f"--gain {shortened(unknown)}: {name} has no such gain; {said}{nearest(unknown, fields) or '.'}"
        )
    given = {key: value for key, value in settings.items() if key in valid and is_given(ctx, key)}
    for twice in given.keys() & gains.keys():
        raise click.UsageError(f"--gain {twice} and --{twice.replace('_', '-')} say the same; give one of them.")
    with prefixed("--gain "):
        chosen = {key: value_of(controller_class(name, robot), key, text) for key, text in gains.items()}
    return make_controller(name, robot, {**given, **chosen})


def _refuse_options(ctx: click.Context, name: str, valid: Iterable[str]) -> None:
    """Refuse options for other controllers.

    Raises:
        click.UsageError: One is given.
    """
    own = is_reference(name)  # whatever its fields are called, their domains are its own: --gain sets them
    known = {*valid} & {*SHARED, "slope_source"} if own else {*valid}
    for part, owners in ((options.ADAPTIVE, "adaptive"), (options.COMPARISON, ", ".join(options.COMPARED))):
        owner = "controllers of this project, and --gain sets what yours has" if own else f"--controller {owners}"
        refuse(ctx, [each for each in section(ctx, part) if each.name not in known], owner, name)


def disturbances_of(given: Iterable[tuple[str, str]], pushes: Sequence[tuple[float, float]]) -> Disturbances | None:
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
            known_name("disturbance", name, SETTINGS)
            if name in values:
                raise InputError(f"{name} is given twice; give it once")
            values[name] = value_of(Disturbances, name, text)
    return Disturbances(**values) if values else None


def model_of(robot: _Robot, errors: Sequence[tuple[str, float]]) -> _Robot:
    """Make the controller's model of a robot.

    Args:
        robot: The robot that walks.
        errors: Names of its parameters, and the factors by which the model's differ.

    Raises:
        InputError: A name is given twice, or the model is not a valid robot.
    """
    if len(dict(errors)) < len(errors):
        raise InputError("--model-error: a name is given twice; give it once")
    if not errors:
        return robot
    for name, _ in errors:
        known_name("parameter of the robot", name, robot.numbers())
    changed = {name: factor * getattr(robot, name) for name, factor in errors}
    return replace(robot, **changed)  # type: ignore[type-var]  # every robot is a dataclass


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


def engine_of(ctx: click.Context, name: str, values: dict[str, Any]) -> Engine:
    """Make the engine of a command, and remove its options from `values`.

    Raises:
        click.UsageError: An option is given that the engine does not have.
        InputError: One is outside its domain.
    """
    mujoco = mujoco_of(ctx, values)
    if name == mujoco.name:
        return mujoco
    refuse(ctx, section(ctx, options.MUJOCO), f"--engine {mujoco.name}", name)
    return names.engine_of(name)


def mujoco_of(ctx: click.Context, values: dict[str, Any]) -> mjbiped.Mujoco:
    """Make the MuJoCo engine of a command, and remove its options from `values`."""
    return mjbiped.Mujoco(**taken(ctx, values, options.MUJOCO))
