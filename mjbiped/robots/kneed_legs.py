"""What bipeds with knees have in common, on whatever feet they stand."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.errors import InputError
from mjbiped.robots.chain import SWING_LOCKED, Array
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains

STRAIGHT = 1e-6  # rad; integrators find the stop more exactly than that


class KneedLegs(Robot):
    """A biped with knees; subclasses are frozen dataclasses of these parameters and of their feet.

    Attributes:
        thigh_mass: Mass of one thigh, kg.
        shank_mass: Mass of one shank, kg.
        hip_mass: Mass at the hip, kg.
        thigh_length: From the hip to the knee, m.
        shank_length: From the knee to the foot, m.
        thigh_centre: From the hip down to the thigh's centre of mass, m.
        shank_centre: From the knee down to the shank's centre of mass, m.
        thigh_inertia: Inertia of a thigh about its centre of mass, kg m^2.
        shank_inertia: Inertia of a shank about its centre of mass, kg m^2.
    """

    thigh_mass: float
    shank_mass: float
    hip_mass: float
    thigh_length: float
    shank_length: float
    thigh_centre: float
    shank_centre: float
    thigh_inertia: float
    shank_inertia: float

    angles: ClassVar[tuple[str, ...]] = ("stance", "swing", "shank")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "knee")
    places: ClassVar[tuple[str, ...]] = ("hip_x", "hip_z", "left", "right", "left_knee", "right_knee")
    collides_from_lift_off: ClassVar[bool] = True

    def check_centres(self) -> None:
        """Refuse a centre of mass beyond the end of its link.

        Raises:
            InputError: There is one.
        """
        for link in ("thigh", "shank"):
            length, centre = getattr(self, f"{link}_length"), getattr(self, f"{link}_centre")
            if centre > length:
                raise InputError(
                    f"{link}_centre = {centre:g}: must lie on the link, at most {link}_length = {length:g} m from its "
                    "upper end"
                )

    @property
    def total_mass(self) -> float:
        """Mass of the whole robot, kg."""
        return 2 * (self.thigh_mass + self.shank_mass) + self.hip_mass

    def knee_impact(self, q: ArrayLike, dq: ArrayLike) -> tuple[Array, Array]:
        """State (q_plus, dq_plus), each of shape (2,), after the swing knee's plastic impact on its stop: it locks.

        The stance foot does not slip, and the stance knee stays locked.

        Args:
            q: stance leg, swing thigh, swing shank, shape (3,), rad; the knee is at its stop.
            dq: their rates, shape (3,), rad/s.

        Raises:
            InputError: the knee is bent, or the shapes are others.
        """
        angles = domains.ANGLE.array("q", q, (3,))
        if abs(angles[2] - angles[1]) > STRAIGHT:
            bent = math.degrees(angles[2] - angles[1])
            raise InputError(f"the swing knee is bent by {bent:.4g} degrees: it strikes its stop where it is straight")
        rates = self.chains[3].joints_lock(SWING_LOCKED, angles, rates_of(dq, angles))
        return np.array([angles[0], (angles[1] + angles[2]) / 2]), rates

    @abstractmethod
    def heel_impact(self, q: ArrayLike, dq: ArrayLike) -> tuple[Array, Array]:
        """State (q_plus, dq_plus) after the impact of the swing leg, its knee at its stop, with the legs exchanged.

        It is plastic and without slip, and the other foot leaves the ground. The angles stay relative to the normal
        that `q` was measured from.

        Args:
            q: stance and swing leg, shape (2,), rad.
            dq: their rates, shape (2,), rad/s.

        Returns:
            Stance leg and swing leg, or swing thigh and swing shank where the impact can bend the swing knee.
        """

    def flexion(self, qpos: ArrayLike, leg: ArrayLike) -> Array:
        """Flexion of the knee of a leg (0 left, 1 right) in postures `qpos`, shape (..., 6): shape (...,), rad."""
        places, legs = np.asarray(qpos, dtype=np.float64), np.asarray(leg)
        return np.where(legs == 0, places[..., 4], places[..., 5])


def rates_of(dq: ArrayLike, angles: Array) -> Array:
    """Check rates, rad/s, as many as there are angles."""
    return domains.RATE.array("dq", dq, angles.shape)
