"""The equations of a biped in space whose hips abduct: both legs open by the same angle, so that the feet stand apart.

The frame is that of `mjbiped.robots.space`, and so are pitch and roll. Each leg turns about the axle of the hip by its
pitch, and then about its own forward direction by half of the abduction a, rad, positive where the feet are farther
apart; a gear between the hips keeps both halves equal, so that the legs exchange their roles as if they were mirrored.
The angles are

    q_1, q_2, a, s    pitch of the stance leg and of the swing leg, abduction, and roll.

A leg is six points of equal mass that have its mass, its centre and its inertias: two on its line and four about that;
the hip's rod is two. So all equations follow from the places of points in the frame that rolls along,
B_1 r_1 + B_2 r_2 + y, with the attitudes B = R_y(q) R_x(-+a / 2) of the legs. With a = 0 they are those of
`mjbiped.robots.space`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from mjbiped.robots.bodies import Segment
from mjbiped.robots.space import Array, SpatialLinkage

_HALVES = (-0.5, 0.5)  # share of the abduction by which the stance leg and the swing leg turn about their forward axes
_ALONG = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # vectors' rates of a turn about x
_ACROSS = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])  # and about y
_PULLS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]).T  # directions of gravity's three components


@dataclass(frozen=True, eq=False)
class AbductingLinkage(SpatialLinkage):
    """Constants of the equations of straight legs that abduct.

    Attributes:
        points: Masses of the points of stance leg, hip and swing leg, from foot to foot, shape (k,), kg.
        arms: Their places in the frame of either leg, shape (k, 2, 3), m.
        aside: And along the axle of the hip, shape (k,), m.
    """

    points: Array
    arms: Array
    aside: Array

    def places(self, q: Array) -> tuple[Array, Array]:
        """Places of the points in the frame that rolls along, shape (k, 3), m, and what the angles do to them.

        Returns:
            The places, and their derivatives by the angles, shape (k, 3, 4), m.
        """
        return _places(self, tuple(q.tolist()))

    def drift(self, q: Array, dq: Array) -> Array:
        """Accelerations of the points without any of the angles, in the frame that rolls along, shape (k, 3), m/s^2."""
        return _drift(self, tuple(q.tolist()), tuple(dq.tolist()))

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (4, 4), kg m^2."""
        flat = self.places(q)[1].reshape(-1, 4)
        return np.asarray(flat.T * np.repeat(self.points, 3) @ flat)

    def _forces(self, q: Array, accelerations: Array) -> Array:
        """Generalised forces that give the points accelerations, shape (k, 3, ...), m/s^2."""
        return np.asarray(np.einsum("k,kij,ki...->j...", self.points, self.places(q)[1], accelerations))

    def coriolis_forces(self, q: Array, dq: Array) -> Array:
        """Coriolis and centrifugal forces, shape (4,), N m."""
        return self._forces(q, self.drift(q, dq))

    def gravity_forces(self, q: Array) -> Array:
        """Forces of gravity for each of its three components, shape (4, 3), N m."""
        pulls = np.broadcast_to(_rolled(q).T @ _PULLS, (len(self.points), 3, 3))
        return -self.gravity * self._forces(q, pulls)

    def energy(self, q: Array, dq: Array, pull: Array) -> float:
        """Kinetic plus potential energy about the stance foot, J; constant while no torque acts."""
        moment = _rolled(q) @ (self.points @ self.places(q)[0])
        return float(0.5 * dq @ self.mass_matrix(q) @ dq - self.gravity * (_PULLS @ pull) @ moment)

    def pushed(self, q: Array, force: Array) -> Array:
        """Generalised forces of a force on the middle of the hip, shape (4,), N m; see `SpatialLinkage.pushed`."""
        middle = len(self.points) // 2
        return np.asarray(self.places(q)[1][middle - 1 : middle + 1].mean(axis=0).T @ _rolled(q).T @ force)

    def swing_foot(self, q: Array) -> Array:
        """The swing foot from the stance foot, shape (3,), m; see `SpatialLinkage.swing_foot`."""
        legs = [_attitude(q[leg], half * q[2])[:, 2] for leg, half in enumerate(_HALVES)]
        return np.asarray(_rolled(q) @ (self.hip[0] * (legs[0] - legs[1]) + [0.0, self.width, 0.0]))

    def ground_force(self, q: Array, dq: Array, ddq: Array, pull: Array) -> Array:
        """Force of the ground on the stance foot, shape (3,), N: ahead, to the swing side, along its normal."""
        moved = self.points @ (self.drift(q, dq) + self.places(q)[1] @ ddq)
        return np.asarray(_rolled(q) @ moved - self.gravity * self.points.sum() * _PULLS @ pull)

    def moment_across(self, q: Array, dq: Array) -> tuple[float, float]:
        """First moment of the masses to the swing side, kg m, and its rate, kg m/s."""
        places, derivatives = self.places(q)
        side = _rolled(q)[1]
        return float(side @ (self.points @ places)), float(side @ (self.points @ (derivatives @ dq)))

    def touchdown(self, q: Array, dq: Array, turn: float = 0.0) -> tuple[Array, Array]:
        """Angles and rates after the plastic impact of the swing foot; see `SpatialLinkage.touchdown`."""
        after = np.array([q[1] - turn, q[0] - turn, q[2], -q[3]])
        # in the new frame, whose upright is turned forward in the robot, and whose side is the other one
        view = _attitude(-turn, 0.0) * np.array([1.0, -1.0, 1.0])
        velocities = self.places(q)[1] @ dq @ view.T
        return after, np.asarray(np.linalg.solve(self.mass_matrix(after), self._forces(after, velocities[::-1])))


def abducting(plain: SpatialLinkage, leg: Segment) -> AbductingLinkage:
    """The linkage of straight legs that abduct.

    Args:
        plain: Of the same legs without abduction.
        leg: One of them.
    """
    about = 1.5 * (leg.axial or 0.0) / leg.mass
    along, off, centre = np.sqrt(3.0 * leg.inertia / leg.mass - about), np.sqrt(about), leg.length - leg.centre
    stance = np.array([[0, 0, along], [0, 0, -along], [off, 0, 0], [-off, 0, 0], [0, off, 0], [0, -off, 0]])
    count, hip = len(stance), np.array([0.0, 0.0, leg.length])
    arms = np.zeros((2 * count + 2, 2, 3))
    arms[:count, 0], arms[count:, 0] = stance + np.array([0.0, 0.0, centre]), hip
    # the same points, mirrored, in the order in which they are those of the stance leg after the touchdown
    arms[count + 2 :, 1] = (stance * [1.0, -1.0, 1.0])[::-1] - [0.0, 0.0, leg.centre]
    mass, rod = [leg.mass / count] * count, [plain.masses[1] / 2] * 2
    axle = 0.5 * plain.width * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))  # of a rod's inertia
    return AbductingLinkage(
        **{field.name: getattr(plain, field.name) for field in fields(plain)},
        points=np.array([*mass, *rod, *mass]),
        arms=arms,
        aside=np.repeat([0.0, *axle, plain.width], [count, 1, 1, count]),
    )


def _attitude(pitch: float, opening: float) -> Array:
    """Rotation of a leg by its pitch and its share of the abduction, rad, shape (3, 3)."""
    c, s, co, so = math.cos(pitch), math.sin(pitch), math.cos(opening), math.sin(opening)
    return np.array([[c, s * so, s * co], [0.0, co, -so], [-s, c * so, c * co]])


def _rolled(q: Array) -> Array:
    """Rotation of the robot by its roll, shape (3, 3)."""
    return _attitude(0.0, q[-1])


@lru_cache(maxsize=8)
def _places(linkage: AbductingLinkage, q: tuple[float, ...]) -> tuple[Array, Array]:
    """See `AbductingLinkage.places`; a law and a step of the physics ask several times at the same angles."""
    aside = linkage.aside
    places, derivatives = aside[:, None] * np.array([0.0, 1.0, 0.0]), np.zeros((len(aside), 3, 4))
    for leg, half in enumerate(_HALVES):
        attitude, arms = _attitude(q[leg], half * q[2]), linkage.arms[:, leg]
        there = arms @ attitude.T
        places = places + there
        derivatives[:, :, leg] = there @ _ACROSS.T
        derivatives[:, :, 2] += half * arms @ (attitude @ _ALONG).T
    derivatives[:, :, 3] = places @ _ALONG.T
    return places, derivatives


@lru_cache(maxsize=8)
def _drift(linkage: AbductingLinkage, q: tuple[float, ...], dq: tuple[float, ...]) -> Array:
    """See `AbductingLinkage.drift`."""
    places, derivatives = _places(linkage, q)
    found = 2.0 * dq[3] * (derivatives[:, :, :3] @ dq[:3]) @ _ALONG.T + dq[3] ** 2 * places @ (_ALONG @ _ALONG).T
    for leg, half in enumerate(_HALVES):
        attitude, opening = _attitude(q[leg], half * q[2]), half * dq[2]
        rate = dq[leg] * _ACROSS @ attitude + opening * attitude @ _ALONG
        change = dq[leg] * _ACROSS @ rate + opening * rate @ _ALONG
        found = found + linkage.arms[:, leg] @ change.T
    return np.asarray(found)
