"""Where a robot in space stands: the ground's frame under its stance foot, and its posture in that frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjbiped.robots.space import Array, SpatialLinkage

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

    @property
    def pull(self) -> Array:
        """Gravity's components: downhill along the heading, into the ground, and towards the swing side."""
        return np.array([DOWN @ self.forward, -DOWN @ self.normal, DOWN @ self.aside])

    def axes(self, roll: float) -> tuple[Array, Array]:
        """The hip's axle towards the swing side, and the direction that is upright in the robot, at a roll, rad."""
        cosine, sine = np.cos(roll), np.sin(roll)
        return cosine * self.aside + sine * self.normal, cosine * self.normal - sine * self.aside

    def world(self, local: Array) -> Array:
        """A place from the foot, (forward, aside, along the normal), as x, y, z, m."""
        return np.asarray(self.place + local[0] * self.forward + local[1] * self.aside + local[2] * self.normal)

    def swing_foot(self, linkage: SpatialLinkage, q: Array) -> Array:
        """The swing foot, x, y, z in m."""
        return self.world(linkage.swing_foot(q))

    def next(self, place: Array, normal: Array, roll: float) -> tuple[Footing, float]:
        """The footing on the swing foot, and the angle by which upright turns in the robot, rad.

        The robot's attitude stays; the heading is now square to its axle in the plane of the new ground.

        Args:
            place: Of the swing foot, m.
            normal: Of the ground there.
            roll: Before the touchdown, rad.
        """
        axle, upright = self.axes(roll)
        away = -axle  # towards the new swing side
        aside = away - (away @ normal) * normal
        aside /= np.linalg.norm(aside)
        forward = np.cross(aside, normal)
        forward *= np.sign(forward @ self.forward)
        return Footing(1 - self.stance, place, forward, aside, normal), float(
            np.arctan2(-(forward @ upright), forward @ self.forward)
        )


def first_footing(place: Array, normal: Array) -> Footing:
    """The footing of the first stance leg, the left one, with the heading along x."""
    forward = np.array([normal[2], 0.0, -normal[0]])
    forward /= np.linalg.norm(forward)
    return Footing(0, place, forward, -np.cross(normal, forward), normal)
