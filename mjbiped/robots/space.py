"""The equations of a biped in space that stands on one point: a planar linkage across a hip of some width, which rolls.

The stance foot is the origin; x points along the heading in the plane of the ground, z along the ground's normal, and y
towards the side of the swing leg. All segments turn about axes that are parallel to the hip. The angles are

    s                 roll of the whole robot about x, rad, positive where it leans towards the stance side,
    q_1, ..., q_n     pitch of each segment from the normal that rolls with the robot, rad, positive forward.

In the frame that rolls along, a body k of mass m_k stands at (x_k, y_k, z_k) = (sum_i L_ki sin q_i, y_k,
sum_i L_ki cos q_i), with constant levers L_ki and lateral places y_k. So its velocity is
(dx_k, -z_k ds, dz_k + y_k ds), and with the planar matrices A_ij = sum_k m_k L_ki L_kj (+ the inertia of segment i
where i = j), the moments E_j = sum_k m_k y_k L_kj, and the axial inertias I_i of the segments,

    M_ij = A_ij cos(q_i - q_j),    M_sj = -E_j sin q_j,
    M_ss = sum_ij A_ij cos q_i cos q_j + sum_i I_i sin^2 q_i + sum_k m_k y_k^2 + I_pelvis.

Gravity is linear in three numbers, its components (g_x, g_y, g_z) in the ground's frame over the acceleration of
gravity: downhill along the heading, towards the swing side, and into the ground. Those are what a controller that does
not know where down is has to estimate (equation (13) of the paper has two). Yaw is held: a foot whose torsional
friction does not slip turns about no vertical axis.
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

    def mass_matrix(self, q: Array) -> Array:
        """M(q) for angles (s, q_1, ..., q_n), shape (n + 1, n + 1), kg m^2."""
        sine, cosine = np.sin(q[1:]), np.cos(q[1:])
        M = np.empty((len(q), len(q)))
        M[1:, 1:] = self.weights * (np.outer(sine, sine) + np.outer(cosine, cosine))
        M[0, 1:] = M[1:, 0] = -self.across * sine
        M[0, 0] = cosine @ self.weights @ cosine + self.axial @ sine**2 + self.masses @ self.lateral**2 + self.pelvis
        return M

    def coriolis_forces(self, q: Array, dq: Array) -> Array:
        """Coriolis and centrifugal forces C(q, dq) dq, shape (n + 1,), N m."""
        sine, cosine, rates, roll = np.sin(q[1:]), np.cos(q[1:]), dq[1:], dq[0]
        slopes = -2.0 * sine * (self.weights @ cosine) + 2.0 * self.axial * sine * cosine  # of M_ss by each angle
        odd = self.weights * (np.outer(sine, cosine) - np.outer(cosine, sine))
        pitch = odd @ rates**2 - 0.5 * slopes * roll**2
        return np.append(roll * (slopes @ rates) - (self.across * cosine) @ rates**2, pitch)

    def gravity_forces(self, q: Array) -> Array:
        """Forces of gravity for each of its three components, shape (n + 1, 3), N m: G (g_x, g_y, g_z)."""
        sine, cosine, down, aside = np.sin(q[1:]), np.cos(q[1:]), np.cos(q[0]), np.sin(q[0])
        height, out = self.moments @ cosine, self.masses @ self.lateral
        G = np.zeros((len(q), 3))
        G[0, 1:] = out * aside + height * down, out * down - height * aside
        G[1:, 0] = -self.moments * cosine
        G[1:, 1], G[1:, 2] = -aside * self.moments * sine, -down * self.moments * sine
        return self.gravity * G

    def accelerations(self, forces: Array, q: Array, dq: Array, pull: Array) -> Array:
        """Accelerations under generalised forces, N m, where gravity has components `pull`: shape (n + 1,), rad/s^2."""
        right = forces - self.coriolis_forces(q, dq) - self.gravity_forces(q) @ pull
        return np.linalg.solve(self.mass_matrix(q), right)

    def energy(self, q: Array, dq: Array, pull: Array) -> float:
        """Kinetic plus potential energy about the stance foot, J; constant while no torque acts."""
        x, z = self.moments @ np.sin(q[1:]), self.moments @ np.cos(q[1:])
        out, down, aside = self.masses @ self.lateral, np.cos(q[0]), np.sin(q[0])
        place = np.array([x, out * down - z * aside, -out * aside - z * down])
        return float(0.5 * dq @ self.mass_matrix(q) @ dq - self.gravity * pull @ place)

    def swing_foot(self, q: Array) -> Array:
        """The swing foot from the stance foot, shape (3,), m: along the heading, to the swing side, along the normal."""
        x, z = self.foot @ np.sin(q[1:]), self.foot @ np.cos(q[1:])
        down, aside = np.cos(q[0]), np.sin(q[0])
        return np.array([x, self.width * down - z * aside, self.width * aside + z * down])

    def momenta_after_touchdown(self, q: Array, dq: Array) -> Array:
        """Momenta of the angles in their new roles about the foot that strikes the ground, shape (n + 1,), kg m^2/s.

        The ground's impulse acts on that foot alone and leaves them as they are. The angles in their new roles are
        those of `exchanged`.
        """
        sine, cosine = np.sin(q[1:]), np.cos(q[1:])
        z, rates = self.levers @ cosine, self.levers @ (cosine * dq[1:])
        sinking = self.levers @ (sine * dq[1:])
        forward, sideways, upward = rates, -z * dq[0], self.lateral * dq[0] - sinking
        # levers of the same bodies from the foot that stands next: those of the bodies whose roles they take
        arms, m = self.levers[::-1, ::-1], self.masses
        turned = (m * forward) @ arms * cosine - (m * upward) @ arms * sine + self.inertia * dq[1:]
        height, out = arms @ cosine, self.lateral[::-1]
        rolled = m @ (sideways * height + upward * out)
        rolled -= (self.inertia @ cosine**2 + self.axial @ sine**2 + self.pelvis) * dq[0]
        return np.append(rolled, turned[::-1])


def exchanged(q: Array) -> Array:
    """Angles, or rates, in their new roles: the other side is the stance side, and its leg comes first."""
    return np.append(-q[0], q[:0:-1])
