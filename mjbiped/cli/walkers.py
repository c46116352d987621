"""Who walks where, in which engine: what a command's options say of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import click

from mjbiped.cli import options
from mjbiped.cli.laws import controller_of, refuse, section, taken
from mjbiped.cli.robots import robot_of
from mjbiped.control.controller import Controller
from mjbiped.control.settings import value_of
from mjbiped.disturbances.disturbances import SETTINGS, Disturbances
from mjbiped.engines.base import Engine
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.names import ENGINES
from mjbiped.errors import InputError, shown
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.files import parse_parameters
from mjbiped.terrain.presets import RANDOM
from mjbiped.terrain.terrain import Terrain, parse_terrain
from mjbiped.utils.domains import known_name

_Robot = TypeVar("_Robot", bound=Robot)


def walker(ctx: click.Context, values: dict[str, Any]) -> tuple[Controller, Terrain]:
    """Who walks where, of `values`.

    Robot, scuffing rule and disturbances take the place there of the options that they are of.

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


def disturbances_of(given: Iterable[tuple[str, str]], pushes: Sequence[tuple[float, float]]) -> Disturbances | None:
    """The disturbances of a command; None where there are none.

    Args:
        given: Names and values as texts.
        pushes: Times (s) and impulses (N s).

    Raises:
        InputError: A name is unknown or given twice, or a value is outside its domain.
    """
    values: dict[str, Any] = {"pushes": pushes} if pushes else {}
    for name, text in given:
        try:
            known_name("disturbance", name, SETTINGS)
            if name in values:
                raise InputError(f"{name} is given twice; give it once")
            values[name] = value_of(Disturbances, name, text)
        except InputError as error:
            raise InputError(f"--disturb {error}") from error
    return Disturbances(**values) if values else None


def model_of(robot: _Robot, errors: Sequence[tuple[str, float]]) -> _Robot:
    """The model that a controller has of a robot.

    Args:
        robot: That walks.
        errors: Names of its parameters, and the factors by which the model's differ.

    Raises:
        InputError: A name is given twice, or the model is none that a robot can have.
    """
    if len(dict(errors)) < len(errors):
        raise InputError("--model-error: a name is given twice; give it once")
    if not errors:
        return robot
    for name, _ in errors:
        known_name("parameter of the robot", name, robot.parameters())
    changed = {name: factor * getattr(robot, name) for name, factor in errors}
    return replace(robot, **changed)  # type: ignore[type-var]  # every robot is a dataclass


def terrain_of(text: str, seed: int | None) -> Terrain:
    """The terrain that a text and a seed mean.

    Raises:
        InputError: The text means none, or the seed does not fit it.
    """
    terrain = parse_terrain(text)
    if seed is None:
        return terrain
    name, _, rest = text.strip().partition(":")
    if name.strip() not in RANDOM:
        raise InputError(f"--seed is for the terrains {', '.join(RANDOM)}; {shown(text)} has none")
    parameters = parse_parameters(rest) if rest else {}
    if parameters.setdefault("seed", seed) != seed:
        raise InputError(f"--seed {seed} contradicts {shown(text)}; give one of them")
    return Terrain.preset(name.strip(), **parameters)


def engine_of(ctx: click.Context, name: str, values: dict[str, Any]) -> Engine:
    """The engine of a command, its options taken out of `values`.

    Raises:
        click.UsageError: An option is given that the engine does not have.
        InputError: One is outside its domain.
    """
    mujoco = mujoco_of(ctx, values)
    if name == mujoco.name:
        return mujoco
    refuse(ctx, section(ctx, options.MUJOCO), f"--engine {mujoco.name}", name)
    return ENGINES[name]


def mujoco_of(ctx: click.Context, values: dict[str, Any]) -> Mujoco:
    """The MuJoCo engine of a command, its options taken out of `values`."""
    settings = taken(ctx, values, options.MUJOCO)
    return Mujoco(lands=not settings.pop("plain_steps"), **settings)


def next_ground(text: str, seed: int | None) -> Callable[[], Terrain] | None:
    """What gives the terrain of the next seed each time, where a text means random ground; None where it does not.

    Args:
        text: That `terrain_of` has taken.
        seed: As there.
    """
    name, _, rest = text.strip().partition(":")
    if name.strip() not in RANDOM:
        return None
    parameters = parse_parameters(rest) if rest else {}
    seeds = itertools.count(int(parameters.pop("seed", seed or 0)) + 1)
    return lambda: Terrain.preset(name.strip(), **{**parameters, "seed": next(seeds)})
