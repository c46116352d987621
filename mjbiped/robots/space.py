"""The equations of a biped in space that stands on one point: a planar linkage across a hip of some width, which rolls.

The stance foot is the origin; x points along the heading in the plane of the ground, z along the ground's normal, and y
towards the side of the swing leg. All segments turn about axes that are parallel to the hip. The angles are

    q_1, ..., q_n     pitch of each segment from the normal that rolls with the robot, rad, positive forward,
    s                 roll of the whole robot about x, rad, positive where it leans towards the stance side.

In the frame that rolls along, a body k of mass m_k stands at (x_k, y_k, z_k) = (sum_i L_ki sin q_i, y_k,
sum_i L_ki cos q_i), with constant levers L_ki and lateral places y_k. So its velocity is
(dx_k, -z_k ds, dz_k + y_k ds), and with the planar matrices A_ij = sum_k m_k L_ki L_kj (+ the inertia of segment i
where i = j), the moments E_j = sum_k m_k y_k L_kj, and the axial inertias I_i of the segments,

    M_ij = A_ij cos(q_i - q_j),    M_sj = -E_j sin q_j,
    M_ss = sum_ij A_ij cos q_i cos q_j + sum_i I_i sin^2 q_i + sum_k m_k y_k^2 + I_pelvis.

Gravity is linear in three numbers, its components in the ground's frame over the acceleration of gravity: downhill
along the heading, into the ground, and towards the swing side. A controller that does not know where down is has to
estimate them (equation (13) of the paper has the first two). Yaw is held: a foot whose torsional friction does not slip
turns about no normal.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpatialLinkage:
    """Constants of the equations, of n segments and k bodies; stance leg first, from its foot up and down again.

    Attributes:
        masses: Of the bodies, shape (k,), kg.
        levers: L, shape (k, n), m.
        lateral: Places of the bodies from the stance foot towards the swing side, shape (k,), m.
        hip: Levers of the hip, shape (n,), m.
        foot: Levers of the swing foot, shape (n,), m.
        width: Between the feet of a robot that stands upright, m.
        inertia: Of each segment about axes across it, shape (n,), kg m^2.
        axial: Of each segment about its line, shape (n,), kg m^2.
        pelvis: Inertia of what the hip carries about the heading, kg m^2.
        gravity: Acceleration of gravity, m/s^2.
    """

    masses: Array
    levers: Array
    lateral: Array
    hip: Array
    foot: Array
    width: float
    inertia: Array
    axial: Array
    pelvis: float
    gravity: float

    @cached_property
    def weights(self) -> Array:
        """A, shape (n, n), kg m^2."""
        return np.asarray(self.levers.T * self.masses @ self.levers + np.diag(self.inertia))

    @cached_property
    def moments(self) -> Array:
        """First moments sum_k m_k L_kj of the pitch angles, shape (n,), kg m."""
        return self.masses @ self.levers

    @cached_property
    def across(self) -> Array:
        """E, shape (n,), kg m^2."""
        return (self.masses * self.lateral) @ self.levers

    @cached_property
    def out(self) -> float:
        """First moment of the bodies' lateral places, kg m."""
        return float(self.masses @ self.lateral)

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (n + 1, n + 1), kg m^2."""
        sine, cosine = np.sin(q[:-1]), np.cos(q[:-1])
        M = np.empty((len(q), len(q)))
        M[:-1, :-1] = self.weights * np.cos(q[:-1, None] - q[:-1])
        M[-1, :-1] = M[:-1, -1] = -self.across * sine
        M[-1, -1] = cosine @ self.weights @ cosine + self.axial @ sine**2 + self.masses @ self.lateral**2 + self.pelvis
        return M

    def coriolis_forces(self, q: Array, dq: Array) -> Array:
        """Coriolis and centrifugal forces C(q, dq) dq, shape (n + 1,), N m."""
        sine, cosine, rates, roll = np.sin(q[:-1]), np.cos(q[:-1]), dq[:-1], dq[-1]
        slopes = 2.0 * sine * (self.axial * cosine - self.weights @ cosine)  # derivatives of M_ss
        forces = np.empty(len(q))
        forces[:-1] = (self.weights * np.sin(q[:-1, None] - q[:-1])) @ rates**2 - 0.5 * roll**2 * slopes
        forces[-1] = roll * (slopes @ rates) - (self.across * cosine) @ rates**2
        return forces

    def gravity_forces(self, q: Array) -> Array:
        """Forces of gravity for each of its three components, shape (n + 1, 3), N m."""
        sine, cosine, down, aside = np.sin(q[:-1]), np.cos(q[:-1]), np.cos(q[-1]), np.sin(q[-1])
        height = self.moments @ cosine
        G = np.zeros((len(q), 3))
        G[:-1, 0] = -self.moments * cosine
        G[:-1, 1], G[:-1, 2] = -down * self.moments * sine, -aside * self.moments * sine
        G[-1, 1:] = self.out * down - height * aside, self.out * aside + height * down
        return self.gravity * G

    def accelerations(self, forces: Array, q: Array, dq: Array, pull: Array) -> Array:
        """Accelerations under generalised forces, N m, where gravity has components `pull`: shape (n + 1,), rad/s^2."""
        right = forces - self.coriolis_forces(q, dq) - self.gravity_forces(q) @ pull
        return np.asarray(np.linalg.solve(self.mass_matrix(q), right))

    def energy(self, q: Array, dq: Array, pull: Array) -> float:
        """Kinetic plus potential energy about the stance foot, J; constant while no torque acts."""
        x, z = self.moments @ np.sin(q[:-1]), self.moments @ np.cos(q[:-1])
        down, aside = np.cos(q[-1]), np.sin(q[-1])
        place = np.array([x, -self.out * aside - z * down, self.out * down - z * aside])
        return float(0.5 * dq @ self.mass_matrix(q) @ dq - self.gravity * pull @ place)

    def pushed(self, q: Array, force: Array) -> Array:
        """Generalised forces of a force on the middle of the hip, shape (n + 1,), N m.

        Args:
            q: Angles.
            force: Ahead, to the swing side and along the ground's normal, N.
        """
        sine, cosine, down, aside = np.sin(q[:-1]), np.cos(q[:-1]), np.cos(q[-1]), np.sin(q[-1])
        along, up = force[1] * down + force[2] * aside, force[2] * down - force[1] * aside
        pitch = self.hip * (force[0] * cosine - up * sine)
        return np.append(pitch, 0.5 * self.width * up - along * (self.hip @ cosine))

    def swing_foot(self, q: Array) -> Array:
        """The swing foot from the stance foot, shape (3,), m: ahead, to the swing side, along the ground's normal."""
        x, z = self.foot @ np.sin(q[:-1]), self.foot @ np.cos(q[:-1])
        down, aside = np.cos(q[-1]), np.sin(q[-1])
        return np.array([x, self.width * down - z * aside, self.width * aside + z * down])

    def ground_force(self, q: Array, dq: Array, ddq: Array, pull: Array) -> Array:
        """Force of the ground on the stance foot, shape (3,), N: ahead, to the swing side, along its normal."""
        sine, cosine = np.sin(q[:-1]), np.cos(q[:-1])
        down, aside, roll, turning = np.cos(q[-1]), np.sin(q[-1]), dq[-1], ddq[-1]
        z, dz = self.moments @ cosine, -(self.moments * sine) @ dq[:-1]
        ddx = self.moments @ (cosine * ddq[:-1] - sine * dq[:-1] ** 2)
        ddz = -self.moments @ (sine * ddq[:-1] + cosine * dq[:-1] ** 2)
        across = -z * turning - 2.0 * dz * roll - self.out * roll**2  # along the axle, and upright in the robot
        up = ddz + self.out * turning - z * roll**2
        weight = self.gravity * self.masses.sum()
        return np.array(
            [
                ddx - weight * pull[0],
                across * down - up * aside - weight * pull[2],
                across * aside + up * down + weight * pull[1],
            ]
        )

    def moment_across(self, q: Array, dq: Array) -> tuple[float, float]:
        """First moment of the masses towards the swing side, kg m, and its rate, kg m/s."""
        z, dz = self.moments @ np.cos(q[:-1]), -(self.moments * np.sin(q[:-1])) @ dq[:-1]
        down, aside = np.cos(q[-1]), np.sin(q[-1])
        return self.out * down - z * aside, -(self.out * aside + z * down) * dq[-1] - dz * aside

    def touchdown(self, q: Array, dq: Array, turn: float = 0.0) -> tuple[Array, Array]:
        """Angles and rates after the plastic impact of the swing foot, in the legs' new roles.

        The other foot leaves the ground without an impulse. The ground's impulse acts on the struck foot alone, and
        leaves the momenta about that foot as they are: of each segment about the hip's axle, and of the robot about its
        heading.

        Args:
            q: Angles before the impact, in the old ground's frame; those after it are in the same frame, mirrored.
            dq: Rates before the impact.
            turn: Angle by which the upright direction of the new ground's frame is turned forward from that of the old
                one in the robot, rad; pitch angles are then less by it.
        """
        sine, cosine = np.sin(q[:-1]), np.cos(q[:-1])
        forward, sinking = self.levers @ (cosine * dq[:-1]), self.levers @ (sine * dq[:-1])
        sideways, upward = -(self.levers @ cosine) * dq[-1], self.lateral * dq[-1] - sinking
        # levers of the same bodies from the foot that stands next: those of the bodies whose roles they take
        arms, out, m = self.levers[::-1, ::-1], self.lateral[::-1], self.masses
        pitch = (m * forward) @ arms * cosine - (m * upward) @ arms * sine + self.inertia * dq[:-1]
        about_heading = m @ (sideways * (arms @ cosine) + upward * out)
        about_heading -= (self.inertia @ cosine**2 + self.axial @ sine**2 + self.pelvis) * dq[-1]
        about_upright = -(m @ (forward * out)) - m @ (sideways * (arms @ sine))
        about_upright += (self.inertia - self.axial) @ (sine * cosine) * dq[-1]
        roll = about_heading * np.cos(turn) - about_upright * np.sin(turn)
        after = exchanged(q)
        after[:-1] -= turn
        return after, np.linalg.solve(self.mass_matrix(after), np.append(pitch[::-1], roll))


def exchanged(q: Array) -> Array:
    """Angles, or rates, in their new roles: the other side is the stance side, and its leg comes first."""
    return np.append(q[-2::-1], -q[-1])


def joined(linkage: SpatialLinkage, groups: Array, q: Array, dq: Array) -> Array:
    """Rates after joints have locked at once, of fewer pitch angles and the roll.

    Args:
        linkage: The linkage before.
        groups: Says with 1 which angles (rows) move as one afterwards (columns).
        q: Angles.
        dq: Rates before.
    """
    momentum = groups.T @ linkage.mass_matrix(q)
    return np.asarray(np.linalg.solve(momentum @ groups, momentum @ dq))
