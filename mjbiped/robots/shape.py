"""Where a robot's limbs are in a posture, and the postures in which it stands."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.numerics.blocks import Numbers
from mjbiped.robots.bodies import Bodies

Array = NDArray[np.float64]

ARC = 0.6
"""Half of the angle over which the arc of a round foot is drawn, rad; it is no limit of its rolling."""
HIP = ("hip_x", "hip_y", "hip_z")
"""Names of the hip's place in a posture, m; planar robots have no `hip_y`."""


class Shape(ABC):
    """A robot as it is seen.

    Attributes:
        places: Names of the numbers of a posture `qpos`: hip x and z (m), left and right thigh, or leg, from the
            vertical (rad), then any other angles of the robot.
    """

    places: ClassVar[tuple[str, ...]]

    @property
    def radius(self) -> float:
        """Radius of the feet, m; 0: point feet."""
        return 0.0

    @property
    @abstractmethod
    def bodies(self) -> Bodies:
        """Rigid bodies that the robot consists of, for engines such as MuJoCo."""

    @property
    @abstractmethod
    def leg_length(self) -> float:
        """Length of a straight leg, m."""

    @property
    @abstractmethod
    def total_mass(self) -> float:
        """Mass of the whole robot, kg."""

    def limbs(self, qpos: ArrayLike) -> Array:
        """Positions of hip, joints and foot of each leg in postures `qpos`.

        Args:
            qpos: Shape (..., len(places)).

        Returns:
            Positions in m, shape (..., legs, points, 2): legs in the order in which they stand, points from the hip
            down to the foot, then x and z.
        """
        places = np.asarray(qpos, dtype=np.float64)
        angles, points = np.zeros(2), [np.broadcast_to(places[..., None, :2], (*places.shape[:-1], 2, 2))]
        for k, segment in enumerate(self.bodies.leg):
            angles = angles + places[..., 2 + 2 * k : 4 + 2 * k]
            line = angles + segment.turn
            points.append(points[-1] - segment.length * np.stack([np.sin(line), np.cos(line)], axis=-1))
        return np.stack(points, axis=-2)

    def leg_ends(self, qpos: ArrayLike) -> Array:
        """Positions of the ends of the legs in postures `qpos`, shape (..., legs, 2), m.

        They are feet that are points, the ankles of feet that are bodies, or the centres of round feet's arcs.
        """
        points = self.limbs(qpos)[..., : len(self.bodies.leg) + 1, :]
        last = points[..., -1, :] - points[..., -2, :]
        return np.asarray(points[..., -1, :] - self.radius * last / np.linalg.norm(last, axis=-1, keepdims=True))

    def outline(self, qpos: ArrayLike) -> Array:
        """Lines that figures draw of each leg in postures `qpos`: its limbs, and the arc of a round foot.

        Shapes are those of `limbs`; the line goes along the arc to the heel and back to the toe.
        """
        limbs = self.limbs(qpos)
        if not self.radius:
            return limbs
        centre = self.leg_ends(qpos)
        along = (limbs[..., -1, :] - centre) / self.radius
        ahead = along[..., ::-1] * [-1.0, 1.0]  # a right angle ahead of the leg
        turns = ARC * np.concatenate([np.linspace(0.0, -1.0, 5), np.linspace(-1.0, 1.0, 11)])[:, None]
        arc = centre[..., None, :] + self.radius * (
            np.cos(turns) * along[..., None, :] + np.sin(turns) * ahead[..., None, :]
        )
        return np.concatenate([limbs, arc], axis=-2)

    def centre_of_mass(self, qpos: ArrayLike) -> Array:
        """Position x, z of the centre of mass in postures `qpos`, shape (..., 2), m."""
        points = self.limbs(qpos)
        moment = self.bodies.hip_mass * points[..., 0, 0, :]
        for k, segment in enumerate(self.bodies.leg):
            upper, lower = points[..., k, :], points[..., k + 1, :]
            centre = upper + segment.centre / segment.length * (lower - upper)
            if segment.offset:
                centre = centre + segment.offset / segment.length * (upper - lower)[..., ::-1] * [1.0, -1.0]
            moment = moment + segment.mass * centre.sum(axis=-2)
        if self.bodies.foot is not None:
            moment = moment + self.bodies.foot.mass * points[..., len(self.bodies.leg), :].sum(axis=-2)
        return np.asarray(moment / self.total_mass)

    def flexion(self, qpos: ArrayLike, leg: ArrayLike) -> Array:
        """Knee flexion of the leg with a given number in postures `qpos`, shape (...,), rad; 0 for straight legs."""
        return np.zeros(np.broadcast_shapes(np.shape(qpos)[:-1], np.shape(leg)))

    def lean(self, qpos: Numbers, leg: int) -> float:
        """Angle from the vertical, rad, of the upper segment of a leg in a posture `qpos`."""
        limb = self.bodies.limbs[leg]
        return float(qpos[self.places.index(limb.hinge)] + limb.offset)

    def posture(
        self, foot: Numbers, stance: int, angles: Numbers, stance_flexion: float = 0.0, slope: float = 0.0
    ) -> tuple[float, ...]:
        """Posture `qpos` of the robot on one foot.

        Args:
            foot: Position of the stance foot, or of the centre of a round one, x and z in m.
            stance: Number of the stance leg; for a biped 0 is left, 1 right.
            angles: Angles from the vertical, stance leg first, shape (len(angles),), rad.
            stance_flexion: Flexion of the stance knee, rad.
            slope: Of the ground, rad, to which feet that turn about an ankle are parallel.
        """
        x, z = foot
        length = self.leg_length - self.radius
        hip = (x + length * math.sin(angles[0]), z + length * math.cos(angles[0]))
        return (*hip, *(angles[::-1] if stance else angles))
