"""The kinds of robots, as records name them, and robots by their names on the command line and in study files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mjbiped.robots.compass import Compass
from mjbiped.robots.footed import FootedCompass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.robots.round import RimlessWheel, RoundCompass, RoundKneed
from mjbiped.robots.three_d import Abducting3D, Compass3D, Kneed3D
from mjbiped.utils.domains import known_name

_CLASSES = (
    Compass, FootedCompass, KneedBiped, RimlessWheel, RoundCompass, RoundKneed, Compass3D, Abducting3D, Kneed3D,
)  # fmt: skip
KINDS: Mapping[str, type[Robot]] = {kind.kind: kind for kind in _CLASSES}

NAMED: Mapping[str, Callable[[], Robot]] = {**KINDS, "halved-rods": KneedBiped.halved_rods}
"""Robots by their names, with the parameters that they have unless others are given."""


def named(name: str) -> tuple[type[Robot], dict[str, Any]]:
    """Kind and parameters of a robot by its name; inertias of rods are left to follow masses and lengths.

    Raises:
        InputError: There is no such robot.
    """
    robot = NAMED[known_name("robot", name, NAMED)]()
    parameters = {key: getattr(robot, key) for key in robot.parameters() if not key.endswith("_inertia")}
    return type(robot), parameters


def robot_named(name: str, given: Mapping[str, object]) -> Robot:
    """The robot of a name, with other parameters than its own where they are given.

    Raises:
        InputError: There is no such robot, or it has no such parameter, or a number is outside its domain.
    """
    kind, parameters = named(name)
    for key in given:
        known_name(f"parameter of the robot {name}", key, kind.parameters())
    return kind(**{**parameters, **given})


def robot_from(described: Mapping[str, object]) -> Robot:
    """The robot that `Robot.to_dict` described; one without a kind is a compass biped, as in records of old.

    A class of somebody's own is known by its `kind` as soon as its module is imported.

    Raises:
        TypeError: A parameter is missing or unknown, or it is no mapping.
        InputError: The kind is unknown, or a number is outside its domain.
    """
    if not isinstance(described, Mapping):
        raise TypeError(f"a robot is described by names and numbers, not by a {type(described).__name__}")
    parameters = dict(described)
    classes = Robot.__subclasses__()
    for each in classes:  # which grows meanwhile
        classes += each.__subclasses__()
    known = {**{each.kind: each for each in classes if hasattr(each, "kind")}, **KINDS}
    return known[known_name("kind of robot", parameters.pop("kind", Compass.kind), known)](**parameters)
