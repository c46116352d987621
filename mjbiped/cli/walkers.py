"""Who walks where, in which engine: what a command's options say of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import click

from mjbiped.cli import options
from mjbiped.cli.laws import controller_of, refuse, section, taken
from mjbiped.control.controller import Controller
from mjbiped.engines.base import Engine
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.names import ENGINES
from mjbiped.errors import InputError, shown
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.files import parse_parameters
from mjbiped.terrain.presets import RANDOM
from mjbiped.terrain.terrain import Terrain, parse_terrain


def walker(ctx: click.Context, values: dict[str, Any]) -> tuple[Controller, Terrain]:
    """Who walks where, of `values`, in which robot and scuffing rule take the place of the options that they are of.

    Raises:
        click.UsageError: An option is given that the controller does not have.
        MjbipedError: Terrain, robot or controller cannot be as the options say.
    """
    terrain = terrain_of(values.pop("terrain"), values.pop("seed"))
    values["robot"] = Compass(**taken(ctx, values, "Robot"))
    controller = controller_of(ctx, values["robot"], values)
    values["scuffing"] = ScuffingRule(reach=values.pop("scuffing_reach"))
    return controller, terrain


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
