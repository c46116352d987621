"""Gaits found by robot and slope, and by descriptions in records."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mjbiped.errors import InputError, MjbipedError, shown
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.kneed import find_kneed_gait
from mjbiped.gaits.optimised import find_reference, optimised_from
from mjbiped.gaits.passive import PassiveGait, find_passive_gait, find_rolling
from mjbiped.gaits.space import find_gait_in_space
from mjbiped.gaits.with_roll import with_roll
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.robot import Robot


def passive_gait_of(robot: Robot, slope: float) -> PassiveGait:
    """The passive gait of any robot on a slope, rad.

    Raises:
        InputError: The slope is outside its domain.
        GaitError: There is none.
    """
    if isinstance(robot, InSpace):
        return find_gait_in_space(robot, slope)
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
    if "knee" in robot.joints:
        return reference_of(robot, clearance=0.08)
    return passive_gait_of(robot, slope)


def reference_of(robot: Robot, **goal: Any) -> Gait:
    """The optimised gait of any robot; in space its roll is left to itself.

    Args:
        robot: The robot.
        goal: Arguments of `mjbiped.find_reference`.

    Raises:
        InputError: A number is outside its domain, or the robot has no such gaits.
        GaitError: There is none.
    """
    if isinstance(robot, InSpace):
        return with_roll(robot, find_reference(robot.planar, **goal))  # type: ignore[arg-type]  # checked there
    return find_reference(robot, **goal)  # type: ignore[arg-type]  # checked there


def gait_from(described: Mapping[str, Any]) -> Gait:
    """Make the gait that `Gait.describe` described: a passive one is searched for, an optimised one is read.

    Raises:
        InputError: Something is missing, of another kind or outside its domain.
        GaitError: The passive gait is not found.
    """
    try:
        robot = robot_from(described["robot"])
        if "goal" in described and isinstance(robot, InSpace):
            return with_roll(robot, optimised_from({**described, "robot": robot.planar.to_dict()}))
        return optimised_from(described) if "goal" in described else passive_gait_of(robot, described["slope"])
    except MjbipedError:
        raise
    except (LookupError, TypeError, ValueError, ArithmeticError) as error:
        raise InputError(f"this is no description of a gait: {shown(error)}") from error
