"""Gaits of robots, and of their descriptions in records."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mjbiped.errors import InputError, MjbipedError, shown
from mjbiped.gaits.gait import Periodic
from mjbiped.gaits.kneed import find_kneed_gait
from mjbiped.gaits.optimised import optimised_from
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot


def passive_gait_of(robot: Robot, slope: float) -> Periodic:
    """The passive gait of any robot on a slope, rad.

    Raises:
        InputError: The slope is outside its domain.
        GaitError: There is none.
    """
    if isinstance(robot, KneedBiped):
        return find_kneed_gait(robot, slope)
    assert isinstance(robot, Compass)
    return find_passive_gait(robot, slope)


def gait_from(described: Mapping[str, Any]) -> Periodic:
    """The gait that `Periodic.describe` described: a passive one is found anew, an optimised one is read.

    Raises:
        InputError: Something is missing, of another kind or outside its domain.
        GaitError: The passive gait is not found.
    """
    try:
        if "goal" in described:
            return optimised_from(described)
        return passive_gait_of(robot_from(described["robot"]), described["slope"])
    except MjbipedError:
        raise
    except (LookupError, TypeError, ValueError, ArithmeticError) as error:
        raise InputError(f"this is no description of a gait: {shown(error)}") from error
