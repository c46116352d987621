"""Limits at which a walk in MuJoCo ends."""

from __future__ import annotations

import math

from mjbiped.engines.mujoco import bearing
from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import AVERAGED, FALLEN_HIP, STALL_TIME, SUSTAINED, Limits
from mjbiped.utils import domains

LONGEST_STEP = 1.0  # no step of a walk is longer, in leg lengths; decides how far the ground is built


def limits_of(
    robot: Robot,
    rule: ScuffingRule,
    timestep: float,
    ground: tuple[float, float],
    steps: int | None,
    distance: float | None,
    lands: bool,
) -> Limits:
    """The limits of a walk; the ground's start and end are places x in m, and `lands` is as in `Options`."""
    length = robot.leg_length
    pendulum = math.sqrt(length / robot.gravity)
    return Limits(
        leg_length=length,
        lowest_hip=FALLEN_HIP * length - robot.radius,  # the ground of round feet lies higher by their radius
        foot_radius=FOOT_RADIUS,
        rolling_radius=robot.radius + (0.0 if lands or robot.bodies.foot is not None else FOOT_RADIUS),
        weight=robot.weight,
        reach=rule.reach * length,
        delay=rule.delay,
        stall_time=STALL_TIME * pendulum,
        averaged=max(AVERAGED * pendulum, bearing.FEWEST_AVERAGED * timestep),
        airborne=bearing.AIRBORNE * pendulum,
        sustained=SUSTAINED * pendulum,
        start=ground[0],
        end=ground[1],
        steps=math.inf if steps is None else float(steps),
        distance=math.inf if distance is None else float(distance),
    )


def ground_needed(robot: Robot, steps: int | None, distance: float | None) -> float:
    """How far ahead of x = 0 a walk can come, m."""
    length = robot.leg_length
    ways = [steps * LONGEST_STEP * length] if steps is not None else []
    ways += [distance] if distance is not None else []
    return 2.0 * length + min(ways, default=domains.PLACE.high)  # no geom can be infinite
