"""The kinds of robots, as records name them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mjbiped.errors import InputError
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.utils.domains import known_name

KINDS: Mapping[str, type[Robot]] = {kind.kind: kind for kind in (Compass, KneedBiped)}


def robot_from(described: Mapping[str, Any]) -> Robot:
    """The robot that `Robot.to_dict` described; one without a kind is a compass biped, as in records of old.

    Raises:
        TypeError: A parameter is missing or unknown.
        InputError: The kind is unknown, or a number is outside its domain.
    """
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
