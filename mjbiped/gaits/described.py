"""Gaits found by robot and slope, and by descriptions in records."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mjbiped.errors import InputError, MjbipedError, shown
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.kneed import find_kneed_gait
from mjbiped.gaits.optimised import find_reference, optimised_from
from mjbiped.gaits.passive import PassiveGait, find_passive_gait, find_rolling
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot


def passive_gait_of(robot: Robot, slope: float) -> PassiveGait:
    """The passive gait of any robot on a slope, rad.

    Raises:
        InputError: The slope is outside its domain.
        GaitError: There is none.
    """
    flat: Any = robot.flat
    find: Callable[[Any, float], PassiveGait] = (find_rolling, find_passive_gait, find_kneed_gait)[len(flat.angles) - 1]
    return find(flat, slope)


def usual_gait(robot: Robot, slope: float) -> Gait:
    """The gait that controllers of a robot imitate unless told otherwise: the passive one on a slope, rad.

    With knees it is an optimised one: passive gaits clear 2 cm, and not every such robot has one on gentle slopes.

    Raises:
        InputError: The slope is outside its domain.
        GaitError: There is none.
    """
    return find_reference(robot, clearance=0.08) if isinstance(robot, KneedBiped) else passive_gait_of(robot, slope)


def gait_from(described: Mapping[str, Any]) -> Gait:
    """Make the gait that `Gait.describe` described: a passive one is searched for, an optimised one is read.

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
