"""The section of a biped's states just after an impact on a plane: (q1, dq1, dq2) tell the whole state.

Both feet stand on the plane and both legs are straight, so that q2 = -q1. Thigh and shank of the swing leg move as one,
or, where the heel strike can bend the knee, at rates that it links (`Robot.after_touchdown`).
"""

from __future__ import annotations

import numpy as np

from mjbiped.engines.checks import check_robot, check_rule
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Gait
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule, check_landing

GUARD = ScuffingRule(reach=0.0, delay=0.0, name="eq. 4")
"""Touchdown of straight legs as `find_passive_gait` has it: whenever the swing foot comes down ahead."""

OFF = 1e-9
"""Sum of the legs' angles, rad, beyond which a state is off the section: it touched down with a bent knee."""


def check_biped(robot: object) -> None:
    """Refuse what is no robot with two legs.

    Raises:
        InputError: It is no robot, or it has no swing leg.
    """
    check_robot("robot", robot)
    if isinstance(robot, Robot) and "swing" not in robot.angles:
        raise InputError(
            f"this is about the states of a stance and a swing leg; a {type(robot).__name__} has no swing leg"
        )


def check_scuffing(gait: Gait, slope: float, rule: ScuffingRule) -> None:
    """Refuse a scuffing rule that would never let a gait land on a slope, rad, or for a robot that needs none.

    Raises:
        InputError: It is such a rule.
    """
    check_rule(gait.robot, rule)
    if not gait.robot.collides_from_lift_off:
        check_landing(gait, slope, rule)


def guard_of(robot: Robot) -> ScuffingRule:
    """The rule under which gaits are followed: that of eq. 4, or none where the foot collides from lift-off."""
    return ScuffingRule() if robot.collides_from_lift_off else GUARD


def places_of(states: Array) -> Array:
    """(q1, dq1, dq2) of states, shape (..., 3), for states of shape (..., 2 n) with n angles."""
    angles = states.shape[-1] // 2
    return states[..., [0, angles, angles + 1]]


def step_lengths(robot: Robot, states: Array) -> Array:
    """Distance between the feet just after impacts on a plane, m; states of shape (..., 2 n), NaN where these are."""
    q = states[..., : len(robot.angles)]
    lengths = np.full(q.shape[:-1], np.nan)
    known = np.isfinite(q).all(axis=-1)
    lengths[known] = -robot.swing_foot(q[known])[..., 0]
    return lengths
