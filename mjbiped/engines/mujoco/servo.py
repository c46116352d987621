"""The servo that holds the stance knee in place of its lock: a spring and a damper about the flexion of its landing.

It is the motor's own loop, which acts at every physics step whatever the controller's period is.
"""

from __future__ import annotations

import math

import numpy as np

from mjbiped.engines.mujoco.constants import Constants, Leg
from mjbiped.engines.mujoco.state import State
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.robot import Robot

STIFFNESS = 30.0
"""In weights times leg lengths per rad: 0.3 of those, twice what stairs of 4 cm ask for, bend the knee by 10 mrad."""

LONGEST = 0.75
"""Greatest product of timestep and natural frequency: critically damped, an explicit step is stable to 0.83."""


def servo_of(robot: Robot) -> tuple[float, float, float]:
    """Stiffness (N m/rad), damping (N m s/rad) and natural frequency (rad/s) of the servo while the foot is in the air.

    That frequency is its highest, and there it is critically damped. A foot that slides or hops leaves the servo little
    more than the shank to move: more damping would then be unstable.
    """
    stiffness, inertia = STIFFNESS * robot.weight * robot.leg_length, free_inertia(robot)
    return stiffness, 2.0 * math.sqrt(stiffness * inertia), math.sqrt(stiffness / inertia)


def free_inertia(robot: Robot) -> float:
    """What a torque at a knee accelerates, over its flexion, of a robot in the air whose legs hang straight, kg m²."""
    bodies = robot.bodies
    thigh, shank = bodies.leg
    weights = np.diag([0.0, thigh.inertia, shank.inertia, thigh.inertia, shank.inertia])
    for mass, levers in (  # of the hip's way forward, then of thigh and shank of each leg
        (bodies.hip_mass, (1.0, 0.0, 0.0, 0.0, 0.0)),
        (thigh.mass, (1.0, -thigh.centre, 0.0, 0.0, 0.0)),
        (shank.mass, (1.0, -thigh.length, -shank.centre, 0.0, 0.0)),
        (thigh.mass, (1.0, 0.0, 0.0, -thigh.centre, 0.0)),
        (shank.mass, (1.0, 0.0, 0.0, -thigh.length, -shank.centre)),
    ):
        weights += mass * np.outer(levers, levers)
    between = np.array([0.0, 1.0, -1.0, 0.0, 0.0])
    return 1.0 / float(between @ np.linalg.solve(weights, between))


def lean_on(leg: Leg, u: State) -> None:
    """Note how the line from foot to hip stands of a stance leg whose knee gives."""
    flexion = u.q[leg.knee]
    reach, lean = bent_leg(leg.upper, leg.lower, flexion)
    u.reach, u.tilt = reach, flexion - lean
    u.share = leg.lower * (leg.lower + leg.upper * math.cos(flexion)) / (reach * reach)


def torque(c: Constants, leg: Leg, u: State) -> float:
    """Torque of the servo at a leg's knee now, N m, against its flexion."""
    return float(c.knee_stiffness * (u.q[leg.knee] - u.rest) + c.knee_damping * u.rates[leg.knee])
