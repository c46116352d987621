"""What a robot is to the rest of the laboratory: its angles, its joints, and where its limbs are."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mjbiped.robots.bodies import Bodies
from mjbiped.robots.equations import Equations

Array = NDArray[np.float64]


class Robot(ABC):
    """A planar robot with equal legs and point feet; subclasses are frozen dataclasses, whose fields tell all.

    Engines, records, figures and videos take from here how many numbers a state, a torque and a posture have.

    Attributes:
        kind: Stands in records; see `mjbiped.robots.kinds`.
        angles: Names of the angles q in swing, from the ground's normal, rad, positive forward: the stance leg first.
        joints: Names of the joints with motors, in the order of torques.
        places: Names of the numbers of a posture `qpos`: hip x and z (m), left and right thigh, or leg, from the
            vertical (rad), and what the robot has beyond that.
        controller: Class in `controllers` that is proposed where another one does not drive it.
        collides_from_lift_off: Whether the swing foot meets the ground in all of the swing; else the scuffing rule says
            from when on.
        equations: Equations of motion, guards and reset maps for event-driven engines.
        gravity: m/s^2.
    """

    kind: ClassVar[str]
    angles: ClassVar[tuple[str, ...]]
    joints: ClassVar[tuple[str, ...]]
    places: ClassVar[tuple[str, ...]]
    controller: ClassVar[str] = "PassiveController"
    collides_from_lift_off: ClassVar[bool]
    equations: ClassVar[Equations]
    gravity: float

    @property
    @abstractmethod
    def bodies(self) -> Bodies:
        """The bodies that it consists of, for engines of rigid bodies."""

    @property
    @abstractmethod
    def leg_length(self) -> float:
        """Length of a straight leg, m."""

    @property
    @abstractmethod
    def total_mass(self) -> float:
        """Mass of the whole robot, kg."""

    @property
    def weight(self) -> float:
        """Weight of the whole robot, N."""
        return self.total_mass * self.gravity

    @abstractmethod
    def mass_matrix(self, q: Any) -> Array:
        """M(q), shape (n, n), kg m^2, for angles of shape (n,) in rad."""

    @abstractmethod
    def coriolis_matrix(self, q: Any, dq: Any) -> Array:
        """C(q, dq), shape (n, n), kg m^2/s; dM/dt - 2 C is skew."""

    @abstractmethod
    def gravity_vector(self, q: Any, slope: float) -> Array:
        """g(q, slope), shape (n,), N m; the slope in rad, > 0 downhill."""

    @property
    @abstractmethod
    def input_matrix(self) -> Array:
        """B: generalised forces of joint torques, shape (len(angles), len(joints))."""

    @abstractmethod
    def kinetic_energy(self, q: Any, dq: Any) -> float:
        """Kinetic energy, J."""

    @abstractmethod
    def potential_energy(self, q: Any, slope: float) -> float:
        """Potential energy about the stance foot, J."""

    def energy(self, q: Any, dq: Any, slope: float) -> float:
        """Kinetic plus potential energy about the stance foot, J; constant between impacts while no torque acts."""
        return self.kinetic_energy(q, dq) + self.potential_energy(q, slope)

    @abstractmethod
    def swing_foot(self, q: Any) -> Array:
        """Swing foot from the stance foot, shape (2,), m: (along the ground, along its normal), for angles in rad."""

    @abstractmethod
    def limbs(self, qpos: Any) -> Array:
        """Hip, joints and foot of each leg in postures `qpos`.

        Args:
            qpos: Shape (..., len(places)).

        Returns:
            Places x, z in m, shape (..., legs, points, 2): legs in the order in which they stand, points from the hip
            down to the foot, x and z.
        """

    @abstractmethod
    def centre_of_mass(self, qpos: Any) -> Array:
        """Place of the centre of mass in postures `qpos`, shape (..., 2), m."""

    def joint_rates(self, dq: Any) -> Array:
        """Rates at which the joints turn, shape (..., len(joints)), rad/s, of the rates of the angles."""
        rates = np.asarray(dq, dtype=np.float64)
        return np.concatenate([rates[..., :1], np.diff(rates, axis=-1)], axis=-1)

    @abstractmethod
    def ground_force(
        self, q: Any, dq: Any, torque: Any, slope: float, *, locked: bool = True, stance_flexion: float = 0.0
    ) -> tuple[float, float]:
        """Force of the ground on the stance foot, forward and upward, N, by the equations of motion.

        Args:
            q: Angles, shape (len(angles),), rad.
            dq: Their rates, rad/s.
            torque: Of the joints, N m.
            slope: Of the ground, rad.
            locked: Whether the swing knee is; a straight leg is one that always is.
            stance_flexion: Flexion at which the stance knee is locked, rad.
        """

    @abstractmethod
    def rates_after_touchdown(self, q: Any, dq: Any, stance_flexion: float = 0.0) -> Array:
        """Rates after the swing foot's plastic impact in a touchdown, in the new roles, shape (len(angles),), rad/s.

        Args:
            q: Angles just before it, in the old roles, shape (len(angles),), rad.
            dq: Their rates, rad/s.
            stance_flexion: Flexion at which the stance knee is locked, rad.
        """

    def flexion(self, qpos: Any, leg: Any) -> Array:
        """Flexion of the knee of a leg (0 left, 1 right) in postures `qpos`, shape (...,), rad; 0 of straight legs."""
        return np.zeros(np.broadcast_shapes(np.shape(qpos)[:-1], np.shape(leg)))

    def posture(self, foot: Any, stance: int, angles: Any, stance_flexion: float = 0.0) -> tuple[float, ...]:
        """Posture `qpos` of the robot on one foot.

        Args:
            foot: Place of the stance foot, x and z in m.
            stance: Number of the stance leg: of a biped 0 left, 1 right.
            angles: Angles from the vertical, stance leg first, shape (len(angles),), rad.
            stance_flexion: Flexion of the stance knee, rad.
        """
        x, z = foot
        hip = (x + self.leg_length * math.sin(angles[0]), z + self.leg_length * math.cos(angles[0]))
        return (*hip, *(angles[::-1] if stance else angles))

    @classmethod
    def parameters(cls) -> tuple[str, ...]:
        """Names of the parameters, which are the dataclass's fields."""
        return tuple(field.name for field in dataclasses.fields(cls))  # type: ignore[arg-type]  # subclasses are ones

    def to_dict(self) -> dict[str, Any]:
        """Kind and parameters in plain JSON types; `mjbiped.robots.kinds.robot_from` reads it."""
        return {"kind": self.kind, **dataclasses.asdict(self)}  # type: ignore[call-overload]  # subclasses are ones
