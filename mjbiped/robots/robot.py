"""Base class of robots: their angles, joints and dynamics, and the positions of their limbs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.dynamics.linkage import Linkage, Motion, room
from mjbiped.dynamics.modes import bend_stance_knee, land, opens
from mjbiped.errors import InputError
from mjbiped.robots.bodies import linkages_of
from mjbiped.robots.chain import SWING_LOCKED, Chain, chain_by
from mjbiped.robots.model import Model, model_of
from mjbiped.robots.shape import Shape
from mjbiped.utils import domains

Array = NDArray[np.float64]


_STRAIGHT, _KNEED = ((0, 1, -1, -1),), ((0, 1, 1, 0), (0, 1, 2, 0), (1, 2, 3, 0))
"""With which angle each segment of a linkage moves, in each `Chain` of the robot; feet do not."""


class Robot(Shape):
    """A planar robot with equal legs; subclasses are frozen dataclasses of its parameters.

    Engines, records, figures and videos take the sizes of states, torques and postures from its attributes.

    Attributes:
        kind: Name of the kind in records; see `mjbiped.robots.kinds`.
        angles: Names of the angles q, from the ground's normal, rad, positive forward, stance leg first.
        joints: Names of the joints with motors, in the order of torques.
        collides_from_lift_off: Whether the swing foot can touch the ground from lift-off on; if not, the scuffing rule
            decides when it can.
        knee_opens: Whether a touchdown can bend the knee of the leg that leaves the ground, which is then free at once.
        lands_bent: Whether a leg whose knee is bent can become the stance leg.
        gravity: Acceleration of gravity, m/s^2.
        sole: Distances from the ankle to the heel and to the toe of the flat, massless sole on which the stance leg
            stands, m: they bound the ankle's torque (`mjbiped.rules.sole`). None: the ankle is not bounded. A foot that
            is a body (`bodies.foot`) bounds nothing, and tips.
    """

    kind: ClassVar[str]
    angles: ClassVar[tuple[str, ...]]
    joints: ClassVar[tuple[str, ...]]
    collides_from_lift_off: ClassVar[bool]
    knee_opens: ClassVar[bool] = False
    runs: ClassVar[Mapping[str, str]] = {}
    lands_bent: ClassVar[bool] = False
    gravity: float
    sole: tuple[float, float] | None = None

    @cached_property
    def linkages(self) -> tuple[Linkage, ...]:
        """The robot as a linkage on its flat foot; where feet are bodies, also on its toe and on its heel."""
        return linkages_of(self.bodies, self.radius, self.gravity)

    @property
    def between(self) -> float:
        """Angle between two legs that are one rigid body, rad; 0 for legs that move by themselves."""
        return 0.0

    @property
    def flat(self) -> Robot:
        """The robot whose gaits and equations are this one's while its feet lie flat: itself, unless they have mass."""
        return self

    @property
    def mechanism(self) -> Self:
        """The robot without its sole, on which neither its equations of motion nor its passive gaits depend."""
        return self if self.sole is None else dataclasses.replace(self, sole=None)  # type: ignore[type-var]  # subclasses

    @property
    def weight(self) -> float:
        """Weight of the whole robot, N."""
        return self.total_mass * self.gravity

    @cached_property
    def chains(self) -> Mapping[int, Chain]:
        """The robot's linkage on a flat foot, its stance leg straight, by its number of angles.

        Two angles of a robot with knees are those of straight legs; three have the swing knee free; four are of stance
        shank, stance thigh, swing thigh and swing shank.
        """
        return self.chains_on(0.0)

    def chains_on(self, flexion: float) -> Mapping[int, Chain]:
        """The same on a stance leg whose knee is locked at a flexion, rad; four angles are absolute."""
        linkage, motion = self._standing(flexion)
        found, offsets = {}, motion.offsets[: linkage.segments]
        for every in _KNEED if linkage.knees else _STRAIGHT:
            groups = every[: linkage.segments]
            n = max(groups) + 1
            found[n] = chain_by(linkage, groups, offsets if n < linkage.segments else 0.0)
        return found

    @property
    def model(self) -> Model:
        """The constants of the robot's equations for compiled laws of users; see `mjbiped.robots.model`.

        Raises:
            InputError: The robot is on round feet.
        """
        if "foot_radius" in self.parameters():
            name = type(self).__name__
            raise InputError(f"robot.model is for robots that stand on a point or a sole; a {name} rolls")
        return model_of(self.chains[len(self.angles)])

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q), shape (n, n), kg m^2, for angles of shape (n,) in rad."""
        chain, angles = self._chain(q)
        return chain.mass_matrix(angles)

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq), shape (n, n), kg m^2/s; dM/dt - 2 C is skew. Angles and rates of shape (n,) in rad and rad/s."""
        chain, angles = self._chain(q)
        return chain.coriolis_matrix(angles, _rates(dq, angles))

    def gravity_vector(self, q: ArrayLike, slope: float) -> Array:
        """g(q, slope), shape (n,), N m, for angles of shape (n,) and the slope in rad, > 0 downhill."""
        chain, angles = self._chain(q)
        return chain.gravity_vector(angles, domains.ANGLE.check("slope", slope))

    @property
    def input_matrix(self) -> Array:
        """B, shape (len(angles), len(joints)): generalised forces of joint torques.

        The ankle acts on the stance leg, each other joint between the two segments that it joins.
        """
        shape = len(self.angles), len(self.joints)
        return np.eye(*shape) - np.eye(*shape, k=1)

    def kinetic_energy(self, q: ArrayLike, dq: ArrayLike) -> float:
        """Kinetic energy, J, for angles and rates of shape (n,) in rad and rad/s."""
        chain, angles = self._chain(q)
        return chain.kinetic_energy(angles, _rates(dq, angles))

    def potential_energy(self, q: ArrayLike, slope: float) -> float:
        """Potential energy about the stance foot, J, for angles of shape (n,) and the slope in rad."""
        chain, angles = self._chain(q)
        return chain.potential_energy(angles, domains.ANGLE.check("slope", slope))

    def energy(self, q: ArrayLike, dq: ArrayLike, slope: float) -> float:
        """Kinetic plus potential energy about the stance foot, J; constant between impacts while no torque acts."""
        return self.kinetic_energy(q, dq) + self.potential_energy(q, slope)

    def swing_foot(self, q: ArrayLike) -> Array:
        """Swing foot from the stance foot, shape (..., 2), m: (along the ground, along its normal).

        On a plane the second component is H of eq. (4).

        Args:
            q: Angles of one or of many postures, shape (..., n), rad.
        """
        chain, angles = self._chain(q, many=True)
        return chain.end(angles)

    def joint_rates(self, dq: ArrayLike) -> Array:
        """Convert rates of the angles to rates of the joints, shape (..., len(joints)), rad/s."""
        rates = np.asarray(dq, dtype=np.float64)
        return np.concatenate([rates[..., :1], np.diff(rates, axis=-1)], axis=-1)

    def ground_force(
        self, q: object, dq: object, torque: object, slope: float, *, locked: bool = True, stance_flexion: float = 0.0
    ) -> tuple[float, float]:
        """Force of the ground on the stance foot, forward and upward, N, by the equations of motion.

        Args:
            q: Angles, shape (len(angles),), rad.
            dq: Rates of the angles, rad/s.
            torque: Torques of the joints, shape (len(joints),), N m.
            slope: Slope of the ground, rad, > 0 downhill.
            locked: Whether the swing knee is locked; straight legs count as always locked.
            stance_flexion: Flexion at which the stance knee is locked, rad.
        """
        n = len(self.angles)
        angles, rates = domains.ANGLE.array("q", q, (n,)), domains.RATE.array("dq", dq, (n,))
        forces, slope = self.input_matrix @ np.asarray(torque, dtype=np.float64), domains.ANGLE.check("slope", slope)
        if locked and n == 3:
            angles, rates, forces = angles[:2], rates[:2], SWING_LOCKED.T @ forces
        chain = (self.chains_on(stance_flexion) if stance_flexion else self.chains)[len(angles)]
        ddq = chain.accelerations(forces, angles, rates, slope)
        forward, upward = chain.ground_force(angles, rates, ddq, slope).tolist()
        return forward, upward

    def _standing(self, stance_flexion: float) -> tuple[Linkage, Motion]:
        """The linkage on its flat foot, and room for its motion on a stance leg that is bent so far, rad."""
        leg, motion = self.bodies.leg, Motion(**room())
        bend_stance_knee(motion, leg[0].length, leg[-1].length, stance_flexion)
        return self.linkages[0], motion

    def after_touchdown(self, places: Array) -> Array:
        """States just after a touchdown on a plane, with both feet on it and both legs straight.

        Args:
            places: Angle of the stance leg (rad) and rates of stance and swing leg (rad/s), shape (..., 3).

        Returns:
            Angles and rates, shape (..., 2 len(angles)), rad and rad/s.
        """
        leg, stance, swing = (places[..., k, None] for k in range(3))
        behind = np.ones(len(self.angles) - 1)
        return np.concatenate([leg, -leg * behind, stance, swing * behind], axis=-1)

    def rates_after_touchdown(self, q: ArrayLike, dq: ArrayLike, stance_flexion: float = 0.0) -> Array:
        """Rates after the plastic impact of a touchdown, in the legs' new roles, shape (len(angles),), rad/s.

        The swing knee locks in the same instant. That of the other leg stays locked, or its stop alone holds it.

        Args:
            q: Angles just before the touchdown, in the old roles, shape (len(angles),), rad.
            dq: Rates of these angles, rad/s.
            stance_flexion: Flexion at which the stance knee is locked, rad.
        """
        (linkage, motion), n = self._standing(stance_flexion), len(self.angles)
        tip = [0.0] * (linkage.angles - n)  # of a foot
        state = [*np.asarray(q).tolist(), *tip, *np.asarray(dq).tolist(), *tip]
        held = not (self.knee_opens and opens(linkage, linkage, motion, state))
        land(linkage, linkage, motion, state, held)
        return np.array(motion.right[:n])

    def _chain(self, q: ArrayLike, *, many: bool = False) -> tuple[Chain, Array]:
        """Check angles of a posture, or of many; return the chain with that many angles, and the angles as an array."""
        counts = tuple(self.chains)
        angles = domains.ANGLE.array("q", q, None if many else counts if len(counts) == 1 else (None,))
        count = angles.shape[-1] if angles.ndim else 0
        if count not in counts:
            raise InputError(
                f"q: expected {' to '.join(str(n) for n in sorted({counts[0], counts[-1]}))} angles, got {count}"
            )
        return self.chains[count], angles

    @classmethod
    def parameters(cls) -> tuple[str, ...]:
        """Names of the parameters, which are the dataclass's fields."""
        return tuple(field.name for field in dataclasses.fields(cls))  # type: ignore[arg-type]  # subclasses are dataclasses

    @classmethod
    def numbers(cls) -> tuple[str, ...]:
        """Names of the parameters that are single numbers."""
        return tuple(name for name in cls.parameters() if name not in ("sole", "underside"))

    def to_dict(self) -> dict[str, Any]:
        """Kind and parameters in plain JSON types; `mjbiped.robots.kinds.robot_from` reads it."""
        return {"kind": self.kind, **self._told()}

    def _told(self) -> dict[str, Any]:
        """The parameters in plain JSON types; without a sole none is told, as in records of old."""
        told: dict[str, Any] = dataclasses.asdict(self)  # type: ignore[call-overload]  # subclasses are dataclasses
        sole = told.pop("sole", None)
        return told if sole is None else {**told, "sole": list(sole)}


def _rates(dq: ArrayLike, angles: Array) -> Array:
    return domains.RATE.array("dq", dq, angles.shape)
