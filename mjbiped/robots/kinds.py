"""The kinds of robots, as records name them, and robots by their names on the command line and in study files."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from mjbiped.errors import InputError
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.robots.wheel import RimlessWheel
from mjbiped.utils.domains import known_name

KINDS: Mapping[str, type[Robot]] = {kind.kind: kind for kind in (Compass, KneedBiped, RimlessWheel)}

NAMED: Mapping[str, Callable[[], Compass | KneedBiped | RimlessWheel]] = {
    Compass.kind: Compass,
    KneedBiped.kind: KneedBiped,
    "halved-rods": KneedBiped.halved_rods,
    RimlessWheel.kind: RimlessWheel,
}
"""Robots by their names, with the parameters that they have unless others are given."""


def named(name: str) -> tuple[type[Robot], dict[str, Any]]:
    """Kind and parameters of a robot by its name; inertias of rods are left to follow masses and lengths.

    Raises:
        InputError: There is no such robot.
    """
    robot = NAMED[known_name("robot", name, NAMED)]()
    parameters = dataclasses.asdict(robot)
    return type(robot), {key: value for key, value in parameters.items() if not key.endswith("_inertia")}


def robot_named(name: str, given: Mapping[str, Any]) -> Robot:
    """The robot of a name, with other parameters than its own where they are given.

    Raises:
        InputError: There is no such robot, or it has no such parameter, or a number is outside its domain.
    """
    kind, parameters = named(name)
    for key in given:
        known_name(f"parameter of the robot {name}", key, kind.parameters())
    return kind(**{**parameters, **given})


def robot_from(described: Mapping[str, Any]) -> Robot:
    """The robot that `Robot.to_dict` described; one without a kind is a compass biped, as in records of old.

    Raises:
        TypeError: A parameter is missing or unknown, or it is no mapping.
        InputError: The kind is unknown, or a number is outside its domain.
    """
    if not isinstance(described, Mapping):
        raise TypeError(f"a robot is described by names and numbers, not by a {type(described).__name__}")
    parameters = dict(described)
    kind = KINDS[known_name("kind of robot", parameters.pop("kind", Compass.kind), KINDS)]
    return kind(**parameters)


def compass_of(robot: Robot, what: str) -> Compass:
    """The robot, where it is a compass biped.

    Args:
        robot: Any.
        what: Is for compass bipeds alone, such as "a video".

    Raises:
        InputError: It is none.
    """
    if not isinstance(robot, Compass):
        raise InputError(f"{what} is there for the compass biped alone, and this robot is a {type(robot).__name__}")
    return robot
