"""The servo that holds the stance knee in place of its lock: a spring and a damper about the flexion of its landing.

It is the motor's own loop, which acts at every physics step whatever the controller's period is.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import NamedTuple

import numpy as np

from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.state import KNEES, Constants, stance_of
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.chain import chain_of
from mjbiped.robots.kneed import KneedBiped

STIFFNESS = 30.0
"""In weights times leg lengths per rad: 0.3 of those, twice what stairs of 4 cm ask for, bend the knee by 10 mrad."""

LONGEST = 0.75
"""Greatest product of timestep and natural frequency: critically damped, an explicit step is stable to 0.83."""


class Servo(NamedTuple):
    """A servo at the knee.

    Attributes:
        stiffness: N m/rad; 0: there is none, and the knee is locked.
        damping: N m s/rad.
    """

    stiffness: float
    damping: float


NONE = Servo(0.0, 0.0)


def frequency_of(robot: KneedBiped) -> float:
    """Natural frequency of the servo while the foot is off the ground, which is its highest, rad/s."""
    return math.sqrt(_stiffness(robot) / free_inertia(robot))


def servo_of(robot: KneedBiped) -> Servo:
    """The servo of a robot, critically damped while the foot is off the ground.

    A foot that slides or hops leaves the servo little more than the shank to move: more damping would then be unstable.
    """
    return Servo(_stiffness(robot), 2.0 * math.sqrt(_stiffness(robot) * free_inertia(robot)))


def _stiffness(robot: KneedBiped) -> float:
    return STIFFNESS * robot.weight * robot.leg_length


def free_inertia(robot: KneedBiped) -> float:
    """What a torque at a knee accelerates, over its flexion, of a robot in the air whose legs hang straight, kg m²."""
    upper, thigh, shank = robot.thigh_length, -robot.thigh_centre, -robot.shank_centre
    masses, inertias = (robot.thigh_mass, robot.shank_mass), (robot.thigh_inertia, robot.shank_inertia)
    hanging = chain_of(  # the hip's way forward, then thigh and shank of each leg
        [
            (robot.hip_mass, 0.0, None, (1.0, 0.0, 0.0, 0.0, 0.0)),
            (masses[0], inertias[0], 1, (1.0, thigh, 0.0, 0.0, 0.0)),
            (masses[1], inertias[1], 2, (1.0, -upper, shank, 0.0, 0.0)),
            (masses[0], inertias[0], 3, (1.0, 0.0, 0.0, thigh, 0.0)),
            (masses[1], inertias[1], 4, (1.0, 0.0, 0.0, -upper, shank)),
        ],
        reach=(0.0,) * 5,
        gravity=robot.gravity,
    )
    between = np.array([0.0, 1.0, -1.0, 0.0, 0.0])
    return 1.0 / float(between @ np.linalg.solve(hanging.weights, between))


def lean_on(constants: Constants, u: MutableSequence[float], leg: int) -> None:
    """Note how the line from foot to hip stands of a leg that gives; see `state.angles_of`."""
    upper, lower, flexion = constants.links.thigh_length, constants.links.shank_length, u[at.Q + KNEES[leg]]
    reach, lean = bent_leg(upper, lower, flexion)
    u[at.REACH], u[at.TILT] = reach, flexion - lean
    u[at.SHARE] = lower * (lower + upper * math.cos(flexion)) / (reach * reach)


def torque(constants: Constants, u: Sequence[float]) -> float:
    """Of the servo at the stance knee now, N m, against its flexion."""
    knee = KNEES[stance_of(u)]
    servo = constants.servo
    return float(servo.stiffness * (u[at.Q + knee] - u[at.REST]) + servo.damping * u[at.QVEL + knee])
