"""A planar biped with knees and point feet: parameters, equations of motion, energy and both of its impacts.

The equations are those of `mjbiped.robots.chain`; this file says what chain the robot is. From the stance foot up and
down again, its segments are stance shank, stance thigh, swing thigh, swing shank. A straight knee that is locked makes
one segment of a leg, so that angles q come in three lengths:

    2: stance leg, swing leg                                 both knees locked, as a compass biped
    3: stance leg, swing thigh, swing shank                  the swing knee free, as in swing
    4: stance shank, stance thigh, swing thigh, swing shank  both free

Angles are from the normal of the ground, rad, positive forward. The knee bends backward: the flexion of the swing knee
is shank less thigh, q[2] - q[1] of three, and is 0 where the knee has struck its stop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.errors import InputError
from mjbiped.robots.bent_leg import ACROSS, bent_leg, force_beside, gravity_beside, stand, straight_leg
from mjbiped.robots.bodies import Bodies, Segment
from mjbiped.robots.chain import Array, Chain, chain_of, ground_force
from mjbiped.robots.equations import Equations
from mjbiped.robots.kneed_equations import EQUATIONS, LEGS, SWING_LOCKED
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains

STANCE_LOCKED = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
STRAIGHT = 1e-6  # rad; integrators find the stop more exactly than that


@dataclass(frozen=True)
class KneedBiped(Robot):
    """A planar biped of two equal legs with knees and point feet.

    The defaults walk passively: light shanks, and as much mass at the hip as in a leg. `halved_rods` is the other robot
    of this laboratory.

    Attributes:
        thigh_mass: kg, > 0.
        shank_mass: kg, > 0.
        hip_mass: point mass at the hip, kg, >= 0.
        thigh_length: from the hip to the knee, m, > 0.
        shank_length: from the knee to the foot, m, > 0.
        thigh_centre: from the hip down to the thigh's centre of mass, m, > 0 and at most the thigh's length.
        shank_centre: from the knee down to the shank's centre of mass, m, > 0 and at most the shank's length.
        thigh_inertia: of a thigh about its own centre of mass, kg m^2, >= 0. None stands for a uniform rod's, m l^2/12,
            and is replaced by that number (which `dataclasses.replace` then keeps).
        shank_inertia: of a shank, the same.
        gravity: m/s^2, > 0.

    Raises:
        InputError: a value is not a finite number of its domain, or a centre of mass lies beyond the end of its link.
    """

    thigh_mass: float = 4.5
    shank_mass: float = 0.5
    hip_mass: float = 5.0
    thigh_length: float = 0.5
    shank_length: float = 0.5
    thigh_centre: float = 0.30
    shank_centre: float = 0.09
    thigh_inertia: float = None  # type: ignore[assignment]  # a number after __post_init__
    shank_inertia: float = None  # type: ignore[assignment]  # the same
    gravity: float = 9.81

    kind: ClassVar[str] = "kneed"
    angles: ClassVar[tuple[str, ...]] = ("stance", "swing", "shank")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "knee")
    places: ClassVar[tuple[str, ...]] = ("hip_x", "hip_z", "left", "right", "left_knee", "right_knee")
    controller: ClassVar[str] = "KneedController"
    collides_from_lift_off: ClassVar[bool] = True
    equations: ClassVar[Equations] = EQUATIONS

    def __post_init__(self) -> None:
        """Check every value, and turn it into a plain float."""
        masses: Mapping[str, domains.Domain] = {"thigh_mass": domains.LEG_MASS, "shank_mass": domains.LEG_MASS}
        lengths = ("thigh_length", "shank_length", "thigh_centre", "shank_centre")
        domains.check_fields(self, **masses, hip_mass=domains.HIP_MASS, **dict.fromkeys(lengths, domains.LENGTH))
        for link in ("thigh", "shank"):
            length, centre = getattr(self, f"{link}_length"), getattr(self, f"{link}_centre")
            if centre > length:
                raise InputError(
                    f"{link}_centre = {centre:g}: must lie on the link, at most {link}_length = {length:g} m from its "
                    "upper end"
                )
            if getattr(self, f"{link}_inertia") is None:
                object.__setattr__(self, f"{link}_inertia", getattr(self, f"{link}_mass") * length**2 / 12)
        domains.check_fields(self, thigh_inertia=domains.INERTIA, shank_inertia=domains.INERTIA)
        domains.check_fields(self, gravity=domains.GRAVITY)
        domains.LEG.check("thigh_length + shank_length", self.leg_length)

    @classmethod
    def halved_rods(cls) -> KneedBiped:
        """The legs of Table I cut at the knee: uniform rods of 2.5 kg and 0.5 m, and no mass at the hip."""
        return cls(thigh_mass=2.5, shank_mass=2.5, hip_mass=0.0, thigh_centre=0.25, shank_centre=0.25)

    @property
    def leg_length(self) -> float:
        """Length of a straight leg, m."""
        return self.thigh_length + self.shank_length

    @property
    def total_mass(self) -> float:
        """Mass of the whole robot, kg."""
        return 2 * (self.thigh_mass + self.shank_mass) + self.hip_mass

    @property
    def bodies(self) -> Bodies:
        """Thigh and shank on either side of the hip."""
        thigh = Segment("thigh", self.thigh_mass, self.thigh_length, self.thigh_centre, self.thigh_inertia)
        shank = Segment("shank", self.shank_mass, self.shank_length, self.shank_centre, self.shank_inertia)
        return Bodies("kneed_scene.xml", self.hip_mass, (thigh, shank))

    @property
    def input_matrix(self) -> Array:
        """B, shape (3, 3): the ankle acts on the stance leg, hip and knee between the segments that they join."""
        return np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [0.0, 0.0, 1.0]])

    @cached_property
    def chains(self) -> Mapping[int, Chain]:
        """The robot as a chain of two, three or four segments, by their number."""
        upper, lower = self.thigh_length, self.shank_length
        thigh, shank = (self.thigh_mass, self.thigh_inertia), (self.shank_mass, self.shank_inertia)
        four = chain_of(
            [
                (*shank, 0, (lower - self.shank_centre, 0.0, 0.0, 0.0)),
                (*thigh, 1, (lower, upper - self.thigh_centre, 0.0, 0.0)),
                (self.hip_mass, 0.0, None, (lower, upper, 0.0, 0.0)),
                (*thigh, 2, (lower, upper, -self.thigh_centre, 0.0)),
                (*shank, 3, (lower, upper, -upper, -self.shank_centre)),
            ],
            reach=(lower, upper, -upper, -lower),
            gravity=self.gravity,
        )
        three = four.locked(STANCE_LOCKED)
        return {4: four, 3: three, 2: three.locked(SWING_LOCKED)}

    def chains_on(self, flexion: float) -> tuple[Mapping[int, Chain], float]:
        """The chains of two and of three segments on a stance leg whose knee is locked at a flexion, rad.

        Also the moment of its weight beside its line, N m, which no `Chain` has; see `mjbiped.robots.bent_leg`.
        """
        four, three, two = (self.chains[n] for n in (4, 3, 2))
        three, two = (
            chain._replace(weights=chain.weights.copy(), moments=chain.moments.copy(), reach=chain.reach.copy())
            for chain in (three, two)
        )
        standing = straight_leg(self.leg_length)
        stand(standing, flexion, four.weights, four.moments, *three[:3], *two[:3])
        return {3: three, 2: two}, float(standing[ACROSS])

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q), shape (n, n), kg m^2, for q of shape (n,) in rad with n = 2, 3 or 4."""
        return self._chain(angles := _angles(q)).mass_matrix(angles)

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq), shape (n, n), kg m^2/s; dM/dt - 2 C is skew. q, dq of shape (n,) in rad and rad/s."""
        angles = _angles(q)
        return self._chain(angles).coriolis_matrix(angles, _rates(dq, angles))

    def gravity_vector(self, q: ArrayLike, slope: float) -> Array:
        """g(q, slope), shape (n,), N m, for q of shape (n,) and the slope in rad, > 0 downhill."""
        angles = _angles(q)
        return self._chain(angles).gravity_vector(angles, domains.ANGLE.check("slope", slope))

    def kinetic_energy(self, q: ArrayLike, dq: ArrayLike) -> float:
        """Kinetic energy, J, for q and dq of shape (n,) in rad and rad/s."""
        angles = _angles(q)
        return self._chain(angles).kinetic_energy(angles, _rates(dq, angles))

    def potential_energy(self, q: ArrayLike, slope: float) -> float:
        """Potential energy about the stance foot, J, for q of shape (n,) and the slope in rad."""
        angles = _angles(q)
        return self._chain(angles).potential_energy(angles, domains.ANGLE.check("slope", slope))

    def swing_foot(self, q: ArrayLike) -> Array:
        """Swing foot from the stance foot, shape (2,), m: (along the ground, along its normal), for q of shape (n,)."""
        angles = _angles(q)
        return self._chain(angles).end(angles)

    def knee_impact(self, q: ArrayLike, dq: ArrayLike) -> tuple[Array, Array]:
        """State (q_plus, dq_plus), each of shape (2,), after the swing knee's plastic impact on its stop: it locks.

        The stance foot stays where it stands, and the stance knee stays locked.

        Args:
            q: stance leg, swing thigh, swing shank, shape (3,), rad; thigh and shank in line.
            dq: their rates, shape (3,), rad/s.

        Raises:
            InputError: the knee is bent, or the shapes are others.
        """
        angles = domains.ANGLE.array("q", q, (3,))
        if abs(angles[2] - angles[1]) > STRAIGHT:
            bent = math.degrees(angles[2] - angles[1])
            raise InputError(f"the swing knee is bent by {bent:.4g} degrees: it strikes its stop where it is straight")
        rates = self.chains[3].joints_lock(SWING_LOCKED, angles, _rates(dq, angles))
        return np.array([angles[0], (angles[1] + angles[2]) / 2]), rates

    def heel_impact(self, q: ArrayLike, dq: ArrayLike) -> tuple[Array, Array]:
        """State (q_plus, dq_plus), each of shape (2,), after the straight swing leg's impact, with the legs exchanged.

        It is plastic and without slip, the other foot leaves the ground, and both knees stay locked; the knee of the
        new swing leg is free from then on. The angles stay relative to the normal that `q` was measured from.

        Args:
            q: stance and swing leg, shape (2,), rad.
            dq: their rates, shape (2,), rad/s.
        """
        angles = domains.ANGLE.array("q", q, (2,))
        rates = self.chains[2].end_strikes(angles, _rates(dq, angles))
        return angles[::-1].copy(), rates[::-1].copy()

    def rates_after_touchdown(self, q: ArrayLike, dq: ArrayLike, stance_flexion: float = 0.0) -> Array:
        """The heel's impact, with bent knees too; see `Robot.rates_after_touchdown`.

        The knee of the swing leg locks in the same instant; that of the other leg stays locked through the impact.

        Args:
            q: stance leg (the line from its foot to the hip), swing thigh and swing shank, shape (3,), rad.
            dq: their rates, rad/s.
            stance_flexion: flexion at which the stance knee is locked, rad.
        """
        (leg, thigh, shank), rates = np.asarray(q).tolist(), np.asarray(dq, dtype=np.float64)[[0, 0, 1, 2]]
        _, lean = bent_leg(self.thigh_length, self.shank_length, stance_flexion)
        angles = np.array([leg + lean, leg + lean - stance_flexion, thigh, shank])
        return self.chains[4].end_strikes_stiff(LEGS, angles, rates)[[1, 0, 0]]

    def flexion(self, qpos: ArrayLike, leg: ArrayLike) -> Array:
        """Flexion of the knee of a leg (0 left, 1 right) in postures `qpos`, shape (..., 6): shape (...,), rad."""
        places, legs = np.asarray(qpos, dtype=np.float64), np.asarray(leg)
        return np.where(legs == 0, places[..., 4], places[..., 5])

    def posture(self, foot: Any, stance: int, angles: Any, stance_flexion: float = 0.0) -> tuple[float, ...]:
        """Posture `qpos` on one foot, of stance leg, swing thigh and swing shank; see `Robot.posture`."""
        line, swing, shank = angles
        length, lean = bent_leg(self.thigh_length, self.shank_length, stance_flexion)
        hip = (foot[0] + length * math.sin(line), foot[1] + length * math.cos(line))
        thighs, knees = [line + lean - stance_flexion, swing], [stance_flexion, shank - swing]
        return (*hip, *(thighs[::-1] if stance else thighs), *(knees[::-1] if stance else knees))

    def limbs(self, qpos: ArrayLike) -> Array:
        """Hip, knee and foot of either leg, shape (..., 2, 3, 2); see `Robot.limbs`."""
        places = np.asarray(qpos, dtype=np.float64)
        hip, thighs = places[..., None, :2], places[..., 2:4]
        shanks = thighs + places[..., 4:6]
        knee = hip - self.thigh_length * np.stack([np.sin(thighs), np.cos(thighs)], axis=-1)
        foot = knee - self.shank_length * np.stack([np.sin(shanks), np.cos(shanks)], axis=-1)
        return np.stack([np.broadcast_to(hip, knee.shape), knee, foot], axis=-2)

    def centre_of_mass(self, qpos: ArrayLike) -> Array:
        """Place of the centre of mass in postures `qpos`, shape (..., 2), m."""
        points = self.limbs(qpos)
        thighs, shanks = (np.diff(points[..., k : k + 2, :], axis=-2).sum(axis=(-3, -2)) for k in (0, 1))
        knees = 2 * points[..., 0, 0, :] + thighs
        moment = self.hip_mass * points[..., 0, 0, :]
        moment = moment + self.thigh_mass * (2 * points[..., 0, 0, :] + self.thigh_centre / self.thigh_length * thighs)
        moment = moment + self.shank_mass * (knees + self.shank_centre / self.shank_length * shanks)
        return np.asarray(moment / self.total_mass)

    def ground_force(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        torque: ArrayLike,
        slope: float,
        *,
        locked: bool = True,
        stance_flexion: float = 0.0,
    ) -> tuple[float, float]:
        """Force of the ground on the stance foot, forward and upward, N, by the equations of motion.

        Args:
            q: stance leg, swing thigh and swing shank, shape (3,), rad.
            dq: their rates, rad/s.
            torque: of ankle, hip and swing knee, N m.
            slope: of the ground, rad.
            locked: whether the swing knee is.
            stance_flexion: flexion at which the stance knee is locked, rad.
        """
        n = 2 if locked else 3
        angles, rates = _angles(q)[:n], _rates(dq, _angles(q))[:n]
        chains, across = self.chains_on(stance_flexion)
        forces = (self.input_matrix @ np.asarray(torque, dtype=np.float64))[:n]
        forces[0] -= gravity_beside(across, angles[0] + slope, 0.0, 1.0)
        if locked:  # the knee's motor acts within the leg
            forces[1] += np.asarray(torque)[2]
        chain = chains[n]
        pull = forces - chain.coriolis_matrix(angles, rates) @ rates - chain.gravity_vector(angles, slope)
        ddq: Array = np.linalg.solve(chain.mass_matrix(angles), pull).astype(np.float64)
        forward, upward = ground_force(chain.moments, self.total_mass, self.gravity, angles + slope, rates, ddq)
        beside = force_beside(across, self.gravity, angles[0] + slope, rates[0], ddq[0])
        return forward + beside[0], upward + beside[1]

    def _chain(self, angles: Array) -> Chain:
        return self.chains[len(angles)]


def _angles(q: ArrayLike) -> Array:
    angles = domains.ANGLE.array("q", q, (None,))
    if len(angles) not in (2, 3, 4):
        raise InputError(f"q: expected 2, 3 or 4 angles, got {len(angles)}")
    return angles


def _rates(dq: ArrayLike, angles: Array) -> Array:
    return domains.RATE.array("dq", dq, angles.shape)
