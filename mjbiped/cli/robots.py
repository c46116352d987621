"""The robot of a command, of its options."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mjbiped.cli import options
from mjbiped.cli.laws import is_given, refuse, section, taken
from mjbiped.errors import InputError, shown
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import KINDS, NAMED, named
from mjbiped.robots.robot import Robot
from mjbiped.terrain.files import parse_toml
from mjbiped.utils.domains import known_name
from mjbiped.utils.reading import read_text


def robot_of(ctx: click.Context, values: dict[str, Any]) -> Robot:
    """The robot of a command, its options taken out of `values`.

    Raises:
        click.UsageError: An option is given that the robot does not have.
        InputError: The file cannot be read, or a number is outside its domain.
    """
    numbers = taken(ctx, values, options.LEGS, options.KNEES)
    name = numbers.pop("robot")
    kind, parameters = _named(name)
    own = kind.parameters()
    others = [each for each in section(ctx, options.LEGS, options.KNEES) if each.name not in (*own, "robot")]
    refuse(ctx, others, "robots with knees" if kind is Compass else "--robot compass", name)
    given = {key: value for key, value in numbers.items() if key in own and is_given(ctx, key)}
    return kind(**{**parameters, **given})


def _named(name: str) -> tuple[type[Robot], dict[str, Any]]:
    """Kind and parameters of a robot by its name or file."""
    if name in NAMED:
        return named(name)
    try:
        written = parse_toml(read_text(Path(name)))
    except InputError as error:
        raise InputError(f"--robot {shown(name)}: {error}") from error
    kind = KINDS[known_name(f"kind of robot in {name}", written.pop("kind", Compass.kind), KINDS)]
    for key in written:
        known_name(f"parameter of the robot in {shown(name)}", key, kind.parameters())
    return kind, written
