"""A robot's linkage by the angles of its legs, with its matrices and energies for NumPy.

A `Chain` is the linkage of `mjbiped.dynamics` in which a locked joint keeps its segments at equal angles. Its equations
have the same form, with E'AE for A, where E has a column for each group of locked segments. On a point foot, with
masses on the segments' lines, its equations are

    M_ij = A_ij cos(q_i - q_j),   C_ij = A_ij sin(q_i - q_j) dq_j,   g_i = -b_i sin(q_i + slope).

docs/knees.md derives them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.dynamics.equations import accelerate
from mjbiped.dynamics.linkage import END, MASS, POINTS, Linkage, Motion, room, stand
from mjbiped.numerics.blocks import Numbers, packed, reader, share_arrays
from mjbiped.numerics.trigonometry import sine_cosine

Array = NDArray[np.float64]

SWING_LOCKED: Array = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
"""Says with 1 which of three angles (rows) move as one (columns) while the swing knee is locked."""

_NONE: Array = np.zeros(1)


class Chain(NamedTuple):
    """A linkage of n angles on one foot. Its functions take many postures at once, and complex angles.

    Attributes:
        weights: A, shape (n, n), kg m^2, symmetric.
        moments: b, gravity times the first moments of mass along the segments, shape (n,), N m.
        reach: Levers of the swing foot along the segments, shape (n,), m.
        mass: Of the whole robot, kg.
        gravity: m/s^2.
        odd: B of `mjbiped.dynamics.linkage`, shape (n, n), kg m^2: zero where all masses are on the segments' lines.
        across: Gravity times the first moments a right angle ahead of the segments, shape (n,), N m.
        beside: Levers of the swing foot a right angle ahead of them, shape (n,), m.
        radius: Of the feet, m.
    """

    weights: Array
    moments: Array
    reach: Array
    mass: float
    gravity: float
    odd: Array = _NONE
    across: Array = _NONE
    beside: Array = _NONE
    radius: float = 0.0

    @property
    def onto_end(self) -> Array:
        """Weights of the momentum about the swing foot that strikes, by the rates before: A - reach b'/g, kg m^2.

        A foot or masses beside the segments' lines count where there is one angle.
        """
        beside = np.outer(self.reach, self.moments) + np.outer(self.beside, self.across)
        return np.asarray(self.weights - beside / self.gravity)

    @property
    def about_end(self) -> Array:
        """A about the swing foot: A - (reach b' + b reach')/g + m reach reach', shape (n, n), kg m^2."""
        along, across = ((self.reach, self.moments), (self.beside, self.across))
        moved = [np.outer(self.mass * foot - pull / self.gravity, foot) for foot, pull in (along, across)]
        return np.asarray(self.onto_end + moved[0] + moved[1])

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (..., n, n), kg m^2, for angles of shape (..., n)."""
        turned, (forward, _) = q[..., :, None] - q[..., None, :], self._moments(q)
        matrix = self.weights * np.cos(turned) + self.odd * np.sin(turned)
        matrix[..., 0, :] += self.radius * forward
        matrix[..., :, 0] += self.radius * forward
        matrix[..., 0, 0] += self.radius**2 * self.mass
        return np.asarray(matrix)

    def coriolis_matrix(self, q: Array, dq: Array) -> Array:
        """C(q, dq), shape (..., n, n), kg m^2/s; dM/dt - 2 C is skew."""
        turned, (_, upward) = q[..., :, None] - q[..., None, :], self._moments(q)
        matrix = self.weights * np.sin(turned) - self.odd * np.cos(turned)
        matrix[..., 0, :] += self.radius * upward
        return np.asarray(matrix * dq[..., None, :])

    def gravity_vector(self, q: Array, slope: ArrayLike) -> Array:
        """g(q, slope), shape (..., n), N m."""
        (forward, upward), lean = self._moments(q), np.asarray(slope)[..., None]
        forces = self.gravity * (np.cos(lean) * upward - np.sin(lean) * forward)
        forces[..., 0] -= self.gravity * self.radius * self.mass * np.sin(slope)
        return np.asarray(forces)

    def kinetic_energy(self, q: Array, dq: Array) -> float:
        """Kinetic energy, J."""
        return 0.5 * float(dq @ self.mass_matrix(q) @ dq)

    def potential_energy(self, q: Array, slope: float) -> float:
        """Potential energy, J, zero at the height of the foot, or of a round one's arc's centre, with q_1 = 0."""
        heights = self.moments @ np.cos(q + slope) - np.sum(self.across * np.sin(q + slope))
        return float(heights - self.gravity * self.mass * self.radius * q[0] * np.sin(slope))

    def end(self, q: Array) -> Array:
        """The swing foot from the stance foot, shape (..., 2), m: along the ground, along its normal; q: (..., n)."""
        sine, cosine = np.sin(q), np.cos(q)
        along, up = sine @ self.reach, cosine @ self.reach
        return np.stack([along + (cosine * self.beside).sum(-1), up - (sine * self.beside).sum(-1)], axis=-1)

    def pull(self, q: Array, dq: Array, slope: ArrayLike) -> Array:
        """C dq + g, shape (..., n), N m: the forces that keep the rates as they are."""
        return (self.coriolis_matrix(q, dq) @ dq[..., None])[..., 0] + self.gravity_vector(q, slope)

    def accelerations(self, forces: Array, q: Array, dq: Array, slope: ArrayLike) -> Array:
        """Accelerations under generalised forces, N m: shape (..., n), rad/s^2."""
        right = (forces - self.pull(q, dq, slope))[..., None]
        return np.asarray(np.linalg.solve(self.mass_matrix(q), right)[..., 0])

    def ground_force(self, q: Array, dq: Array, ddq: Array, slope: float) -> Array:
        """Force of the ground on the stance foot, forward and upward, shape (..., 2), N."""
        (forward, upward), square = self._moments(q), dq * dq
        along = (forward * ddq + upward * square).sum(-1) + self.mass * self.radius * ddq[..., 0]
        normal, sine, cosine = (upward * ddq - forward * square).sum(-1), np.sin(slope), np.cos(slope)
        weight = self.mass * self.gravity
        return np.stack([along * cosine + normal * sine, normal * cosine - along * sine + weight], axis=-1)

    def joints_lock(self, groups: ArrayLike, q: Array, dq: Array) -> Array:
        """Rates after joints have locked at once, shape (..., k), rad/s.

        Args:
            groups: Says with 1 which angles (rows) move as one afterwards (columns), shape (n, k).
            q: Angles, shape (..., n), rad.
            dq: Rates before, shape (..., n), rad/s.
        """
        E = np.asarray(groups, dtype=np.float64)
        momentum = E.T @ self.mass_matrix(q)
        return np.asarray(np.linalg.solve(momentum @ E, momentum @ dq[..., None])[..., 0])

    @property
    def free_motion(self) -> Callable[[Numbers, Numbers, float], Numbers]:
        """The motion without torques: (q, dq, slope) -> accelerations, rad/s^2, shape (n,)."""
        n, levers = len(self.reach), np.zeros((POINTS, len(self.reach)))
        levers[MASS], levers[MASS + 1] = self.moments / self.gravity, self.across / self.gravity
        even, odd = self.weights.tolist(), np.broadcast_to(self.odd, (n, n)).tolist()
        linkage = Linkage(n, n, False, self.mass, self.gravity, self.radius, 0.0, even, odd, levers.tolist())
        motion = Motion(free=n, **room())
        stand(linkage, motion)
        if motion.closed or n == 1:  # so short that plain Python will do
            known = np.nan

            def moved(q: Numbers, dq: Numbers, slope: float) -> Numbers:
                nonlocal known
                motion.ddq[:n] = [0.0] * n
                if slope != known:
                    known, (motion.sine, motion.cosine) = slope, sine_cosine(slope)
                accelerate(linkage, motion, q, dq)
                return motion.ddq[:n]

            return moved
        share_arrays(motion)
        (fixed, below), (made, _) = packed(linkage), packed(motion)
        code = _machine_code()

        def accelerations(q: Numbers, dq: Numbers, slope: float) -> Numbers:
            motion.ddq[:] = [0.0] * len(motion.ddq)
            code(fixed.ctypes.data, made.ctypes.data, slope, np.array(q), np.array(dq))
            return np.array(motion.ddq[:n])

        accelerations.kept = below  # type: ignore[attr-defined]  # lives as long as machine code reads it
        return accelerations

    def _moments(self, q: Array) -> tuple[Array, Array]:
        """Derivatives of the first moments of mass by the angles, along the ground and along its normal, kg m."""
        sine, cosine = np.sin(q), np.cos(q)
        forward, upward = self.moments * cosine - self.across * sine, -self.moments * sine - self.across * cosine
        return forward / self.gravity, upward / self.gravity


def moved_at(linkage: int, motion: int, slope: float, q: Sequence[float], dq: Sequence[float]) -> None:
    """Turn the forces of a motion into accelerations on a slope, rad; linkage and motion are addresses."""
    w = _motion_at(motion, 0)
    w.sine, w.cosine = sine_cosine(slope)
    accelerate(_linkage_at(linkage, 0), w, q, dq)


_linkage_at, _motion_at = reader(Linkage), reader(Motion)


@cache
def _machine_code() -> Any:
    """`moved_at` as machine code; compiled once, and kept on disk."""
    from mjbiped.numerics.machine import compiled

    return compiled(moved_at, "void(int64, int64, float64, float64[::1], float64[::1])")


def chain_by(linkage: Linkage, groups: Sequence[int], offsets: ArrayLike = 0.0) -> Chain:
    """A linkage by fewer angles.

    Args:
        linkage: The linkage.
        groups: With which angle each segment moves.
        offsets: Angle of each segment less that with which it moves, rad.
    """
    moves = np.asarray(groups)[:, None] == np.arange(max(groups) + 1)
    E = moves * np.exp(1j * np.broadcast_to(offsets, len(groups)))[:, None]
    levers = (np.array(linkage.levers[::2]) + 1j * np.array(linkage.levers[1::2])) @ E
    products = E.conj().T @ (np.array(linkage.even) + 1j * np.array(linkage.odd)) @ E
    (reach, moments), gravity = levers[[END // 2, MASS // 2]], linkage.gravity
    return Chain(
        weights=products.real,
        moments=gravity * moments.real,
        reach=reach.real,
        mass=linkage.mass,
        gravity=gravity,
        odd=products.imag,
        across=gravity * moments.imag,
        beside=reach.imag,
        radius=linkage.radius,
    )
