"""The base class of bipeds in space: a planar robot's legs, set apart by a hip of some width, on feet that roll, too.

Angles are the pitch angles of the planar robot, and the roll behind them; `mjbiped.robots.space` has the equations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.numerics.blocks import Numbers
from mjbiped.robots.bodies import Bodies
from mjbiped.robots.footing import Footing, first_footing, robot_axes
from mjbiped.robots.robot import Robot
from mjbiped.robots.space import Array, SpatialLinkage


class InSpace(Robot):
    """A biped with two equal legs that stand side by side; subclasses are frozen dataclasses.

    Attributes:
        in_plane: Kind of the planar robot with the same legs.
        groupings: With which pitch angle each segment moves, from the stance foot up and down again, by the number of
            pitch angles.
        knee_lock: Angles of a robot whose swing knee is locked as sums of those of straight legs, and the roll.
        hips: Names of the places that turn the legs aside, by leg; empty: none does.
        sole_width: Width of the flat, massless sole, m: it bounds the torque about the heading as `sole` that of the
            ankle's pitch. None: that torque is not bounded.
        hip_width: Distance between the legs, m.
        axial_inertia: Inertia of a leg about its own line, kg m^2.
    """

    in_plane: ClassVar[type[Robot]]
    groupings: ClassVar[Mapping[int, tuple[int, ...]]]
    knee_lock: ClassVar[Array]
    hips: ClassVar[tuple[str, ...]] = ()
    runs: ClassVar[Mapping[str, str]] = {
        "hybrid": "mjbiped.engines.space.hybrid:HybridSpaceRun",
        "mujoco": "mjbiped.engines.space.mujoco:MujocoSpaceRun",
    }
    hip_mass: float
    hip_width: float
    axial_inertia: float
    sole_width: float | None

    @cached_property
    def in_space(self) -> Mapping[int, SpatialLinkage]:
        """The equations, by the number of pitch angles."""
        return {n: spatial(self.bodies, groups, self.gravity) for n, groups in self.groupings.items()}

    @property
    def bodies(self) -> Bodies:
        """The legs on either side of a hip, a rod; the parts of a leg share its axial inertia by their masses."""
        flat = self.planar.bodies
        mass = sum(segment.mass for segment in flat.leg)
        leg = (segment._replace(axial=self.axial_inertia * segment.mass / mass) for segment in flat.leg)
        half = 0.5 * self.hip_width
        sides = (limb._replace(across=0.0, aside=aside) for limb, aside in zip(flat.limbs, (half, -half), strict=True))
        rod = self.hip_mass * self.hip_width**2 / 12
        return flat._replace(scene=f"{self.kind}_scene.xml", leg=tuple(leg), limbs=tuple(sides), hip_inertia=rod)

    @property
    def planar(self) -> Robot:
        """The planar robot with the same legs."""
        names = (name for name in self.in_plane.parameters() if name != "sole")
        return self.in_plane(**{name: getattr(self, name) for name in names})

    def set_apart(self, width: float) -> Self:
        """The robot with another distance between its legs, m."""
        return replace(self, hip_width=width)  # type: ignore[type-var]  # subclasses are dataclasses

    def spread(self, state: Array) -> Array:
        """State of straight legs, two pitch angles and the roll, then their rates, as one of all angles."""
        return np.concatenate([self.knee_lock @ state[:3], self.knee_lock @ state[3:]])

    def pitches(self, q: Array) -> Array:
        """The pitch angles among all angles, rad."""
        return q[:-1]

    def opening(self, q: Array) -> float:
        """The angle by which either leg is turned aside, rad."""
        return 0.0

    def straightened(self, q: Array) -> Array:
        """The three angles of straight legs among all angles, shape (n, ...), where the swing knee is straight."""
        return q[[0, 1, -1]]

    @cached_property
    def motors(self) -> Mapping[int, Array]:
        """Joint torques of generalised forces, by the number of angles that move: a locked knee's motor rests."""
        whole = self.input_matrix
        locked, free = np.linalg.pinv(self.knee_lock.T @ whole), np.linalg.inv(whole)
        return {3: np.asarray(locked), len(self.angles): np.asarray(free)}

    def _linkage(self, q: Array) -> SpatialLinkage:
        return self.in_space[len(q) - 1]

    @cached_property
    def falling(self) -> float:
        """Omega, at which an upright robot falls to the side, 1/s."""
        upright = self.in_space[2]
        inertia = upright.mass_matrix(np.zeros(3))[-1, -1]
        return float(np.sqrt(upright.gravity * upright.moments.sum() / inertia))

    def divergent_component(self, q: Array, dq: Array) -> float:
        """Divergent component y + dy / omega of the centre of mass across the heading, m.

        Args:
            q: Angles, rad.
            dq: Rates, rad/s.

        Returns:
            The component from the stance foot towards the swing side.
        """
        linkage = self._linkage(q)
        y, rate = linkage.moment_across(q, dq)
        return float((y + rate / self.falling) / linkage.masses.sum())

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q), shape (n, n), kg m^2, for pitch angles and roll, rad."""
        angles = np.asarray(q, dtype=np.float64)
        return self._linkage(angles).mass_matrix(angles)

    def gravity_vector(self, q: ArrayLike, slope: float, lateral: float = 0.0) -> Array:
        """Forces of gravity, shape (n,), N m, on ground that falls forward and to the swing side by two angles, rad."""
        angles = np.asarray(q, dtype=np.float64)
        return np.asarray(self._linkage(angles).gravity_forces(angles) @ pull_of(slope, lateral))

    def energy(self, q: ArrayLike, dq: ArrayLike, slope: float, lateral: float = 0.0) -> float:
        """Kinetic plus potential energy about the stance foot, J."""
        angles = np.asarray(q, dtype=np.float64)
        return self._linkage(angles).energy(angles, np.asarray(dq, dtype=np.float64), pull_of(slope, lateral))

    def impact(self, q: ArrayLike, dq: ArrayLike) -> tuple[Array, Array]:
        """State after the plastic impact of the swing foot on the stance foot's plane, in the legs' new roles."""
        angles = np.asarray(q, dtype=np.float64)
        return self._linkage(angles).touchdown(angles, np.asarray(dq, dtype=np.float64))

    def landed(self, q: Array, dq: Array, turn: float = 0.0) -> tuple[Array, Array]:
        """All angles and rates after a touchdown, whose swing knee is locked; see `SpatialLinkage.touchdown`."""
        after, rates = self.in_space[2].touchdown(self.straightened(q), self.straightened(dq), turn)
        return self.knee_lock @ after, self.knee_lock @ rates

    def rates_after_touchdown(self, q: ArrayLike, dq: ArrayLike, stance_flexion: float = 0.0) -> Array:
        """Rates after the plastic impact of a touchdown on the same plane, in the legs' new roles, rad/s."""
        return self.landed(np.asarray(q, dtype=np.float64), np.asarray(dq, dtype=np.float64))[1]

    def ground_force(
        self, q: object, dq: object, torque: object, slope: float, *, locked: bool = True, stance_flexion: float = 0.0
    ) -> tuple[float, float]:
        """Force of the ground on the stance foot, forward and upward, N, on ground that is level across the heading.

        See `Robot.ground_force`.
        """
        angles, rates, motors = (np.asarray(each, dtype=np.float64) for each in (q, dq, torque))
        ahead, _, normal = self.force_on_foot(angles, rates, motors, pull_of(slope), locked=locked).tolist()
        cosine, sine = np.cos(slope), np.sin(slope)
        return float(ahead * cosine + normal * sine), float(normal * cosine - ahead * sine)

    def swing_foot(self, q: ArrayLike) -> Array:
        """The swing foot from the stance foot, shape (3,), m: forward, to the swing side, along the ground's normal."""
        angles = np.asarray(q, dtype=np.float64)
        return self._linkage(angles).swing_foot(angles)

    def posture(
        self, foot: Numbers, stance: int, angles: Numbers, stance_flexion: float = 0.0, slope: float = 0.0
    ) -> tuple[float, ...]:
        """Posture `qpos` on a foot that heads along x, of angles and roll from the vertical; see `Robot.posture`.

        The middle of the hip is over y = 0 where the robot does not roll.
        """
        across = 0.5 * self.hip_width * (-1.0 if stance else 1.0)
        standing = first_footing(np.array([foot[0], across, foot[1]]), np.array([0.0, 0.0, 1.0]))
        standing = standing if stance == 0 else replace(standing, stance=1, aside=-standing.aside)
        return tuple(standing.posture(self, np.asarray(angles, dtype=np.float64)).tolist())

    def started(self, place: Array, normal: Array, q: Array, dq: Array) -> tuple[Array, Array]:
        """Posture `qpos` and its rates on the left foot at rest, heading along x.

        Args:
            place: Of the foot, shape (3,), m.
            normal: Of the ground there.
            q: Angles, rad.
            dq: Their rates, rad/s.
        """
        footing = first_footing(place, normal)
        return footing.posture(self, q), footing.rates(self, q, dq)

    def footing(self, qpos: ArrayLike, stance: int, normal: Array) -> Footing:
        """The footing of a stance leg in a posture `qpos` on ground with a normal, shape (3,)."""
        legs = self.points(qpos)
        axle = legs[1 - stance, 0] - legs[stance, 0]
        aside = axle - (axle @ normal) * normal
        aside /= np.linalg.norm(aside)
        return Footing(stance, legs[stance, -1], np.cross(aside, normal) * (1.0 if stance else -1.0), aside, normal)

    def force_on_foot(self, q: Array, dq: Array, torque: Array, pull: Array, *, locked: bool = True) -> Array:
        """Force of the ground on the stance foot, shape (3,), N: ahead, to the swing side, along the ground's normal.

        Args:
            q: Angles, rad.
            dq: Their rates, rad/s.
            torque: Of the joints, N m.
            pull: Gravity's components; see `pull_of`.
            locked: Whether the swing knee is locked, if there is one.
        """
        ddq = self.accelerations(self.input_matrix @ torque, q, dq, pull, locked=locked)
        return self._linkage(q).ground_force(q, dq, ddq, pull)

    def accelerations(self, forces: Array, q: Array, dq: Array, pull: Array, *, locked: bool) -> Array:
        """Accelerations of all angles under generalised forces, N m; see `force_on_foot`: shape (n,), rad/s^2."""
        if not locked:
            return self._linkage(q).accelerations(forces, q, dq, pull)
        lock, straight = self.knee_lock, (self.straightened(q), self.straightened(dq))
        return np.asarray(lock @ self.in_space[2].accelerations(lock.T @ forces, *straight, pull))

    def points(self, qpos: ArrayLike) -> Array:
        """Positions of hip joint, knee and foot of each leg in postures `qpos`, shape (..., legs, points, 3), m."""
        places = np.asarray(qpos, dtype=np.float64)
        across, roll, yaw = (places[..., self.places.index(name)] for name in ("hip_y", "roll", "yaw"))
        ahead, left, over = robot_axes(yaw, roll)
        hip = np.stack([places[..., 0], across, places[..., 1]], axis=-1)
        aside = np.array([limb.aside for limb in self.bodies.limbs])
        opening = places[..., [self.places.index(name) for name in self.hips], None]
        points, angles = [hip[..., None, :] + aside[:, None] * left[..., None, :]], np.zeros(2)
        for k, segment in enumerate(self.bodies.leg):
            angles = angles + places[..., 2 + 2 * k : 4 + 2 * k]
            line = np.sin(angles)[..., None] * ahead[..., None, :] + np.cos(angles)[..., None] * over[..., None, :]
            if self.hips:
                line = np.cos(opening) * line - np.sin(opening) * np.sign(aside)[:, None] * left[..., None, :]
            points.append(points[-1] - segment.length * line)
        return np.stack(points, axis=-2)

    def limbs(self, qpos: ArrayLike) -> Array:
        """Positions seen from the side, x and z; see `Shape.limbs`."""
        return self.points(qpos)[..., [0, 2]]

    def centre_of_mass(self, qpos: ArrayLike) -> Array:
        """Position x, z of the centre of mass in postures `qpos`, shape (..., 2), m."""
        return self.centre_in_space(qpos)[..., [0, 2]]

    def centre_in_space(self, qpos: ArrayLike) -> Array:
        """Position of the centre of mass in postures `qpos`, shape (..., 3), m."""
        points = self.points(qpos)
        moment = self.hip_mass * points[..., 0, :].mean(axis=-2)
        for k, segment in enumerate(self.bodies.leg):
            upper, lower = points[..., k, :], points[..., k + 1, :]
            moment = moment + segment.mass * (upper + segment.centre / segment.length * (lower - upper)).sum(axis=-2)
        return np.asarray(moment / self.total_mass)

    @cached_property
    def input_matrix(self) -> Array:
        """B, shape (len(angles), len(joints)): the roll has a motor of its own."""
        B = np.eye(len(self.angles)) - np.eye(len(self.angles), k=1)
        B[-2, -1] = 0.0
        return B

    def joint_rates(self, dq: ArrayLike) -> Array:
        """Convert rates of the angles to rates of the joints, shape (..., len(joints)), rad/s."""
        return np.asarray(dq, dtype=np.float64) @ self.input_matrix


def pull_of(slope: float, lateral: float = 0.0) -> Array:
    """Gravity's direction in the frame of ground that falls forward by `slope` and to the swing side by `lateral`, rad.

    Returns:
        Components downhill along the heading, into the ground, and towards the swing side.
    """
    normal = np.array([np.tan(slope), 1.0, np.tan(lateral)])
    normal /= np.linalg.norm(normal)
    # the heading lies in the ground, and in the vertical plane along x
    return np.array([np.sin(slope), normal[1], normal[2] * np.cos(slope)])


def spatial(bodies: Bodies, groups: tuple[int, ...], gravity: float) -> SpatialLinkage:
    """The linkage in space of a robot's legs.

    Args:
        bodies: The legs and the hip.
        groups: With which pitch angle each segment moves.
        gravity: m/s^2.
    """
    leg, width = bodies.leg, bodies.limbs[0].aside - bodies.limbs[1].aside
    segments = (*reversed(leg), *leg)
    moves = (np.asarray(groups)[:, None] == np.arange(max(groups) + 1)).astype(float)
    lengths = np.array([segment.length for segment in leg])
    hip = np.append(lengths[::-1], 0.0 * lengths)
    foot = np.append(lengths[::-1], -lengths)
    centres = [np.where(np.arange(len(foot)) < k, hip, 0.0) for k in range(len(leg))]  # of the joint below a segment
    for k, segment in enumerate(reversed(leg)):
        centres[k][k] = segment.length - segment.centre
    swings = [np.where(np.arange(len(foot)) < len(leg) + k, foot, 0.0) for k in range(len(leg))]
    for k, segment in enumerate(leg):
        swings[k][len(leg) + k] = -segment.centre
    masses = np.array([segment.mass for segment in segments])
    return SpatialLinkage(
        masses=np.insert(masses, len(leg), bodies.hip_mass),
        levers=np.array([*centres, hip, *swings]) @ moves,
        lateral=np.repeat([0.0, width / 2, width], [len(leg), 1, len(leg)]),
        hip=hip @ moves,
        foot=foot @ moves,
        width=width,
        inertia=np.array([segment.inertia for segment in segments]) @ moves,
        axial=np.array([segment.axial or 0.0 for segment in segments]) @ moves,
        pelvis=bodies.hip_inertia,
        gravity=gravity,
    )
