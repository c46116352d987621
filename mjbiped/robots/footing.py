"""Where a robot in space stands: the ground's frame under its stance foot, and its posture in the world."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.robots.space import Array

if TYPE_CHECKING:
    from mjbiped.robots.in_space import InSpace

DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, eq=False)
class Footing:
    """A stance foot on the ground.

    Attributes:
        stance: Number of the stance leg: 0 left, 1 right.
        place: Of the foot, x, y, z in m.
        forward: The heading in the plane of the ground, a unit vector.
        aside: The direction in that plane towards the swing side.
        normal: Of the ground.
    """

    stance: int
    place: Array
    forward: Array
    aside: Array
    normal: Array

    @cached_property
    def pull(self) -> Array:
        """Gravity's components: downhill along the heading, into the ground, and towards the swing side."""
        return np.array([DOWN @ self.forward, -DOWN @ self.normal, DOWN @ self.aside])

    @property
    def to_left(self) -> float:
        """1 where the swing side is the left one, else -1."""
        return 1.0 if self.stance else -1.0

    @property
    def slope(self) -> float:
        """Of the ground along the heading, rad, positive downhill."""
        return math.atan2(self.pull[0], self.pull[1])

    @property
    def lateral(self) -> float:
        """Of the ground to the left, rad, positive downhill."""
        return self.to_left * math.atan2(self.pull[2], self.pull[1])

    def turned(self, vector: Array) -> Array:
        """A vector of the world in the ground's frame: ahead, to the swing side, along the normal."""
        return np.array([vector @ self.forward, vector @ self.aside, vector @ self.normal])

    def axes(self, roll: float) -> tuple[Array, Array]:
        """The hip's axle towards the swing side, and the direction that is upright in the robot, at a roll, rad."""
        cosine, sine = math.cos(roll), math.sin(roll)
        return cosine * self.aside + sine * self.normal, cosine * self.normal - sine * self.aside

    def swing_foot(self, robot: InSpace, q: Array) -> Array:
        """The swing foot, x, y, z in m."""
        along, across, up = robot.swing_foot(q)
        return np.asarray(self.place + along * self.forward + across * self.aside + up * self.normal)

    def hip(self, robot: InSpace, q: Array) -> Array:
        """The middle of the hip, x, y, z in m."""
        (axle, upright), opening = self.axes(q[-1]), robot.opening(q)
        line = math.sin(q[0]) * self.forward + math.cos(q[0]) * upright
        aside = 0.5 * robot.hip_width + robot.leg_length * math.sin(opening)
        return np.asarray(self.place + robot.leg_length * math.cos(opening) * line + aside * axle)

    def posture(self, robot: InSpace, q: Array) -> Array:
        """The posture `qpos` in the order of the robot's `places`."""
        axle, upright = self.axes(q[-1])
        lines = [math.sin(angle) * self.forward + math.cos(angle) * upright for angle in robot.pitches(q)]
        hip, left = self.hip(robot, q), self.to_left * axle
        roll, yaw = math.asin(left[2]), math.atan2(-left[0], left[1])
        ahead, _, over = robot_axes(yaw, roll)
        pitch = [math.atan2(line @ ahead, line @ over) for line in lines]
        legs = pitch[1::-1] if self.stance else pitch[:2]
        bent = [] if len(pitch) < 3 else [0.0, pitch[2] - pitch[1]]
        flexions = bent[::-1] if self.stance else bent
        opening = [robot.opening(q)] * len(robot.hips)
        return np.array([hip[0], hip[2], *legs, *flexions, *opening, hip[1], roll, yaw])

    def rates(self, robot: InSpace, q: Array, dq: Array) -> Array:
        """Rates of the posture `qpos`, for angles and their rates, rad and rad/s."""
        step = 1e-6  # s: differences are exact to 1e-9
        ahead, back = (self.posture(robot, q + sign * step * dq) for sign in (1.0, -1.0))
        return np.asarray((ahead - back) / (2.0 * step))

    def next(self, place: Array, normal: Array, axle: Array, upright: Array) -> tuple[Footing, float]:
        """The footing on the swing foot, and the angle by which upright turns forward in the robot, rad.

        The robot's attitude stays; the heading is now square to its axle in the plane of the new ground.

        Args:
            place: Of the swing foot, m.
            normal: Of the ground there.
            axle: The hip's axle before the touchdown, towards the swing side until then.
            upright: The direction that is upright in the robot.
        """
        aside = (axle @ normal) * normal - axle  # towards the new swing side
        aside /= np.linalg.norm(aside)
        forward = np.cross(aside, normal)
        forward *= np.sign(forward @ self.forward)
        turn = math.atan2(-(forward @ upright), forward @ self.forward)
        return Footing(1 - self.stance, place, forward, aside, normal), turn

    def roll_of(self, axle: Array) -> float:
        """The roll of a robot whose axle points along a unit vector towards the swing side, rad."""
        return math.asin(min(1.0, max(-1.0, float(axle @ self.normal))))


def robot_axes(yaw: ArrayLike, roll: ArrayLike) -> tuple[Array, Array, Array]:
    """The directions ahead, to the left and upright in a robot without pitch, in the world, shape (..., 3) each."""
    cy, sy, cr, sr = np.cos(yaw), np.sin(yaw), np.cos(roll), np.sin(roll)
    ahead, left, over = (cy, sy, 0.0 * cy), (-sy * cr, cy * cr, sr), (sy * sr, -cy * sr, cr)
    return np.stack(ahead, axis=-1), np.stack(left, axis=-1), np.stack(over, axis=-1)


def first_footing(place: Array, normal: Array) -> Footing:
    """The footing of the first stance leg, the left one, with the heading along x."""
    forward = np.array([normal[2], 0.0, -normal[0]])
    forward /= np.linalg.norm(forward)
    return Footing(0, place, forward, -np.cross(normal, forward), normal)
