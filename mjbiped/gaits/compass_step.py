"""The compass biped's step as the reference optimiser takes it: its laws of motion on arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjbiped.gaits.bezier import DEGREE, Numbers, curve
from mjbiped.gaits.optimisation import Course, Goal, Motion
from mjbiped.gaits.straight_legs import StraightLegs
from mjbiped.robots import compass
from mjbiped.robots.compass import Array, Compass

REACH = 0.2  # leg lengths ahead of the stance foot from which on the swing foot may touch the ground
_CORNER = 1e-3  # leg lengths: how much the corner of "above the ground or not yet ahead" is rounded


@dataclass(frozen=True)
class CompassStep(StraightLegs):
    """A `mjbiped.gaits.optimisation.StepModel` of the compass biped on level ground.

    The laws are those of `mjbiped.robots.compass`, whose functions of plain numbers take arrays as well.
    """

    robot: Compass
    joints: int = 2
    own: tuple[tuple[float, float], ...] = ()
    intervals: tuple[int, ...] = (48, 32)
    starts: tuple[tuple[float, float], ...] = ((0.15, 0.86), (0.22, 0.80))
    lifted: float = 0.0

    def rates_after_impact(self, half: Numbers, rates: Numbers) -> Numbers:
        """Rates after the impact of rates before it (eq. 2), rad/s."""
        legs: Any = (-np.sin(half), np.cos(half), np.sin(half), np.cos(half))
        cosine: Any = np.cos(2.0 * half)
        dq1: Any = rates[..., 0]
        dq2: Any = rates[..., 1]
        after = compass.rates_after_impact(self.robot.constants, legs, cosine, dq1, dq2)
        return np.stack(after, axis=-1)

    def breaks(self, own: Numbers) -> tuple[Numbers, ...]:
        """None: both legs move smoothly from impact to impact."""
        return ()

    def along(self, motion: Motion, stretches: Sequence[Numbers]) -> Course:
        """What a step's curves ask of the robot."""
        return self.course(*curve(motion.points, np.concatenate(stretches, axis=-1), motion.period))

    def keeps(self, goal: Goal, motion: Motion, course: Course, phases: Numbers, second: int) -> dict[str, Numbers]:
        """The foot is above the ground where it may touch it, or not yet there."""
        # the greater of height and what is missing to the reach, rounded
        height = course.height[..., :-1] / self.length
        missing = REACH - course.ahead[..., :-1] / self.length
        greater = 0.5 * (height + missing + np.sqrt((height - missing) ** 2 + _CORNER**2) - _CORNER)
        return {"foot above the ground": greater + 0.5 * _CORNER}  # just above zero at the end, where the foot lands

    def course(self, q: Numbers, dq: Numbers, ddq: Numbers) -> Course:
        """Inverse dynamics (eq. 1) and the swing foot's path (eq. 4)."""
        constants, length = self.robot.constants, self.length
        (q1, q2), (dq1, dq2), (ddq1, ddq2) = (tuple(np.moveaxis(each, -1, 0)) for each in (q, dq, ddq))
        legs: Any = np.sin(q1), np.cos(q1), np.sin(q2), np.cos(q2)
        m11, m12, m22 = compass.mass_terms(constants, legs)
        c1, c2 = compass.coriolis_terms(constants, legs, dq1, dq2)
        _, _, g1, g2 = compass.gravity_terms(constants, legs)
        ankle, hip = compass.joint_torques(
            m11 * ddq1 + m12 * ddq2 + c1 + g1,
            m12 * ddq1 + m22 * ddq2 + c2 + g2,
        )
        forward, upward = compass.ground_force(
            constants, self.robot.total_mass, self.robot.gravity, legs, dq1, dq2, ddq1, ddq2
        )
        sine1, cosine1, sine2, cosine2 = legs
        ahead, height = compass.swing_foot(length, legs)
        return Course(
            torques=np.stack(np.broadcast_arrays(ankle, hip), axis=-1),
            powers=np.stack([ankle * dq1, hip * (dq2 - dq1)], axis=-1),
            tangential_force=np.asarray(forward),
            normal_force=np.asarray(upward),
            ahead=np.asarray(ahead),
            height=np.asarray(height),
            ahead_rate=length * (cosine1 * dq1 - cosine2 * dq2),
            height_rate=length * (sine2 * dq2 - sine1 * dq1),
        )

    def guess(self, half: float) -> tuple[Array, Array]:
        """Legs to begin with; there is nothing of its own."""
        return straight_guess(half), np.empty(0)


def straight_guess(half: float) -> Array:
    """Control points to begin with: a stance leg that turns evenly, a swing leg that swings out and comes back."""
    stance = np.linspace(-half, half, DEGREE + 1)
    swing = np.linspace(half, -half, DEGREE + 1)
    swing[3:DEGREE] -= 0.5 * half * np.sin(np.linspace(0.25, 0.9, DEGREE - 3) * math.pi)
    return np.stack([stance, swing], axis=-1)
