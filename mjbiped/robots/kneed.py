"""The planar biped with knees and point feet, and the base class of bipeds with knees on any feet.

From the stance foot up and down again, the segments of its `mjbiped.robots.chain` are stance shank, stance thigh, swing
thigh, swing shank. A straight knee that is locked makes one segment of a leg, so that angles q come in three lengths:

    2: stance leg, swing leg                                 both knees locked, as a compass biped
    3: stance leg, swing thigh, swing shank                  the swing knee free, as in swing
    4: stance shank, stance thigh, swing thigh, swing shank  both free

Angles are from the normal of the ground, rad, positive forward. The knee bends backward: the flexion of the swing knee
is shank less thigh, q[2] - q[1] of three, and is 0 where the knee has struck its stop.

`stance_knee_torque` is the torque that a locked stance knee bears and that no motor gives: the force of the row that
locks the knee of the linkage with all four segments free.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.dynamics.modes import bent_leg
from mjbiped.errors import InputError
from mjbiped.numerics.blocks import Numbers
from mjbiped.robots.bodies import Bodies, Segment
from mjbiped.robots.chain import SWING_LOCKED, Array
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains

STRAIGHT = 1e-6  # rad; integrators find the stop more exactly than that


@dataclass(frozen=True)
class KneedLegs(Robot):
    """A biped with knees; subclasses add what their feet need.

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
        gravity: Acceleration of gravity, m/s^2.

    Raises:
        InputError: A value is not a finite number of its domain, or a centre of mass lies beyond the end of its link.
    """

    thigh_mass: Annotated[float, domains.LEG_MASS] = 4.5
    shank_mass: Annotated[float, domains.LEG_MASS] = 0.5
    hip_mass: Annotated[float, domains.HIP_MASS] = 5.0
    thigh_length: Annotated[float, domains.LENGTH] = 0.5
    shank_length: Annotated[float, domains.LENGTH] = 0.5
    thigh_centre: Annotated[float, domains.LENGTH] = 0.30
    shank_centre: Annotated[float, domains.LENGTH] = 0.09
    thigh_inertia: Annotated[float, domains.INERTIA] = None  # type: ignore[assignment]  # a number after __post_init__
    shank_inertia: Annotated[float, domains.INERTIA] = None  # type: ignore[assignment]  # a number after __post_init__
    gravity: Annotated[float, domains.GRAVITY] = 9.81

    angles: ClassVar[tuple[str, ...]] = ("stance", "swing", "shank")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "knee")
    places: ClassVar[tuple[str, ...]] = ("hip_x", "hip_z", "left", "right", "left_knee", "right_knee")
    collides_from_lift_off: ClassVar[bool] = True
    gyration: ClassVar[Mapping[str, float]] = {}  # radii over lengths of links that are no uniform rods

    def __post_init__(self) -> None:
        """Check every value, and turn it into a plain float."""
        domains.check_fields(self)
        for link in ("thigh", "shank"):
            mass, length, centre = (getattr(self, f"{link}_{part}") for part in ("mass", "length", "centre"))
            if centre > length:
                raise InputError(
                    f"{link}_centre = {centre:g}: must lie on the link, at most {link}_length = {length:g} m from its "
                    "upper end"
                )
            if getattr(self, f"{link}_inertia") is None:
                ratio = self.gyration.get(link)
                inertia = mass * length**2 / 12 if ratio is None else mass * (ratio * length) ** 2
                object.__setattr__(self, f"{link}_inertia", inertia)
        domains.LEG.check("from the foot to the hip", self.leg_length)

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
        rates = self.chains[3].joints_lock(SWING_LOCKED, angles, domains.RATE.array("dq", dq, (3,)))
        return np.array([angles[0], (angles[1] + angles[2]) / 2]), rates

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
        angles, rates = domains.ANGLE.array("q", q, (2,)), domains.RATE.array("dq", dq, (2,))
        after, n = self.rates_after_touchdown(angles[[0, 1, 1]], rates[[0, 1, 1]]), 3 if self.knee_opens else 2
        return angles[[1, 0, 0]][:n], after[:n]

    def flexion(self, qpos: ArrayLike, leg: ArrayLike) -> Array:
        """Flexion of the knee of a leg (0 left, 1 right) in postures `qpos`, shape (..., 6): shape (...,), rad."""
        places, legs = np.asarray(qpos, dtype=np.float64), np.asarray(leg)
        return np.where(legs == 0, places[..., 4], places[..., 5])

    def posture(
        self, foot: Numbers, stance: int, angles: Numbers, stance_flexion: float = 0.0, slope: float = 0.0
    ) -> tuple[float, ...]:
        """Posture `qpos` on one foot, of stance leg, swing thigh and swing shank; see `Robot.posture`."""
        line, swing, shank = angles
        length, lean = self.leg_length - self.radius, 0.0
        if stance_flexion:
            length, lean = bent_leg(self.thigh_length, self.shank_length, stance_flexion)
        hip = (foot[0] + length * math.sin(line), foot[1] + length * math.cos(line))
        thighs, knees = [line + lean - stance_flexion, swing], [stance_flexion, shank - swing]
        return (*hip, *(thighs[::-1] if stance else thighs), *(knees[::-1] if stance else knees))


@dataclass(frozen=True)
class KneedBiped(KneedLegs):
    """A planar biped of two equal legs with knees and point feet; by default light shanks and a heavy hip.

    The defaults walk passively: as much mass is at the hip as in a leg. `halved_rods` is the other robot with knees of
    this laboratory.

    Attributes:
        thigh_mass: Mass of one thigh, kg.
        shank_mass: Mass of one shank, kg.
        hip_mass: Mass at the hip, kg.
        thigh_length: From the hip to the knee, m.
        shank_length: From the knee to the foot, m.
        thigh_centre: From the hip down to the thigh's centre of mass, m. It is at most the thigh's length.
        shank_centre: From the knee down to the shank's centre of mass, m. It is at most the shank's length.
        thigh_inertia: Inertia of a thigh about its centre of mass, kg m^2; it follows mass and length unless given.
            None is replaced by that of a uniform rod, m l^2/12 (which `dataclasses.replace` then keeps).
        shank_inertia: Inertia of a shank about its centre of mass, kg m^2; it follows mass and length unless given.
        gravity: Acceleration of gravity, m/s^2.
        sole: Distances from the ankle to the heel and to the toe of a flat, massless sole, m, or one for both. They
            bound the ankle's torque; without a sole it is not bounded.

    Raises:
        InputError: a value is not a finite number of its domain, or a centre of mass lies beyond the end of its link.
    """

    sole: Annotated[tuple[float, float] | None, domains.SOLE] = None

    kind: ClassVar[str] = "kneed"
    lands_bent: ClassVar[bool] = True

    @classmethod
    def halved_rods(cls) -> KneedBiped:
        """The legs of Table I cut at the knee: uniform rods of 2.5 kg and 0.5 m, and no mass at the hip."""
        return cls(thigh_mass=2.5, shank_mass=2.5, hip_mass=0.0, thigh_centre=0.25, shank_centre=0.25)

    @property
    def leg_length(self) -> float:
        """Length of a straight leg, m."""
        return self.thigh_length + self.shank_length

    @property
    def bodies(self) -> Bodies:
        """Thigh and shank on either side of the hip."""
        thigh = Segment("thigh", self.thigh_mass, self.thigh_length, self.thigh_centre, self.thigh_inertia)
        shank = Segment("shank", self.shank_mass, self.shank_length, self.shank_centre, self.shank_inertia)
        return Bodies("kneed_scene.xml", self.hip_mass, (thigh, shank))


def stance_knee_torque(
    robot: KneedLegs,
    q: ArrayLike,
    dq: ArrayLike,
    torque: ArrayLike,
    slope: ArrayLike,
    *,
    locked: ArrayLike,
    stance_flexion: ArrayLike = 0.0,
) -> Array:
    """Torque that a motor at the stance knee has to give to hold it as it is, N m.

    It is positive where the motor must keep the knee from bending further. Where it is negative the load straightens
    the knee: its stop bears that if the knee is straight, and no motor is needed; a motor must give it if the knee is
    bent.

    Any number of instants may be asked for at once; the leading shapes of all arguments are broadcast.

    Args:
        robot: The robot.
        q: Stance leg, swing thigh and swing shank from the ground's normal, shape (..., 3), rad. A stance leg that is
            bent has the angle of the line from its foot to the hip.
        dq: Their rates, shape (..., 3), rad/s.
        torque: Of ankle, hip and swing knee, shape (..., 3), N m.
        slope: Of the ground, shape (...), rad, positive downhill.
        locked: Whether the swing knee is locked as well, shape (...).
        stance_flexion: At which the stance knee is held, shape (...), rad.

    Returns:
        Shape (...). NaN where a torque is no finite number.

    Raises:
        InputError: An angle or a rate is outside its domain, or of another shape.
    """
    for name, given in (("q", q), ("dq", dq), ("torque", torque)):
        if np.shape(given)[-1:] != (3,):
            raise InputError(f"{name}: expected shape (..., 3), got {np.shape(given)}")
    by_instant = (np.asarray(each, dtype=np.float64)[..., None] for each in (slope, locked, stance_flexion))
    given = np.broadcast_arrays(*(np.asarray(each, dtype=np.float64) for each in (q, dq, torque)), *by_instant)
    leading, (lean, held, flexion) = given[0].shape, (each[..., 0] for each in given[3:])
    # of all four segments, stance shank first
    angles = domains.ANGLE.array("q", given[0], leading)[..., [0, 0, 1, 2]]
    rates = domains.RATE.array("dq", given[1], leading)[..., [0, 0, 1, 2]]
    ankle, hip, knee = np.moveaxis(given[2], -1, 0)
    lean = domains.ANGLE.array("slope", lean, lean.shape)
    flexion = domains.ANGLE.array("stance_flexion", flexion, lean.shape)
    upper, lower = (segment.length for segment in robot.bodies.leg)
    angles[..., :2] += np.arctan2(upper * np.sin(flexion), lower + upper * np.cos(flexion))[..., None]
    angles[..., 1] -= flexion
    # the equations, and a row for each knee: the swing knee's is zero where it is free
    whole, equations = robot.chains[4], np.zeros((*lean.shape, 6, 6))
    equations[..., :4, :4] = whole.mass_matrix(angles)
    equations[..., 4, :2], equations[..., 5, 2:4] = (1.0, -1.0), np.multiply.outer(held, (-1.0, 1.0))
    equations[..., :4, 4:] = -np.swapaxes(equations[..., 4:, :4], -1, -2)
    equations[..., 5, 5] = held == 0.0
    right = np.concatenate([np.stack([ankle, -hip, hip - knee, knee], -1), np.zeros((*lean.shape, 2))], -1)
    right[..., :4] -= whole.pull(angles, rates, lean)
    return np.asarray(-np.linalg.solve(equations, right[..., None])[..., 4, 0])
