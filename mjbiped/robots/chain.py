"""A robot's linkage by the angles of its legs, with its matrices and energies for NumPy.

A `Chain` is the linkage of `mjbiped.dynamics` with the segments that a locked joint makes one at equal angles: of the
same form, with E'AE for A, where E has a column for each group of them. On a point foot, with masses on the segments'
lines, its equations are

    M_ij = A_ij cos(q_i - q_j),   C_ij = A_ij sin(q_i - q_j) dq_j,   g_i = -b_i sin(q_i + slope).

docs/knees.md derives them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.dynamics.linkage import END, MASS, POINTS, WEIGHT, Linkage, Motion, room, stand
from mjbiped.dynamics.linkage import accelerate as move
from mjbiped.numerics.blocks import packed, reader, share_arrays
from mjbiped.numerics.trigonometry import sine_cosine

Array = NDArray[np.float64]

_NONE: Array = np.zeros(1)


def coupled(weight: float, angle: float) -> tuple[float, float]:
    """A_ij cos(q_i - q_j), of M, and A_ij sin(q_i - q_j), of C, for one A_ij and the angle q_i - q_j, rad."""
    sine, cosine = sine_cosine(angle)
    return weight * cosine, weight * sine


def pulled(moment: float, angle: float) -> float:
    """Gravity's pull -b_i sin(angle) on a segment, N m, for its b_i (N m) and its angle from the vertical, rad."""
    sine, _ = sine_cosine(angle)
    return -moment * sine


def segment_force(moment: Any, sine: Any, cosine: Any, rate: Any, acceleration: Any) -> tuple[Any, Any]:
    """Share of a segment in the force of the ground, forward and upward, N: rate of the momentum along its line.

    Args:
        moment: First moment of mass that moves with the segment, its b over gravity, kg m.
        sine: Sine of its angle from the vertical.
        cosine: Cosine of that angle.
        rate: Rate of the angle, rad/s.
        acceleration: Acceleration of the angle, rad/s^2.
    """
    square = rate * rate
    return moment * (cosine * acceleration - sine * square), -moment * (sine * acceleration + cosine * square)


class Chain(NamedTuple):
    """A linkage of n angles on one foot.

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
        """Weights of the momentum about the swing foot that strikes, by the rates before: A - reach b'/g, kg m^2."""
        return self.weights - np.outer(self.reach, self.moments) / self.gravity

    @property
    def about_end(self) -> Array:
        """A about the swing foot: A - (reach b' + b reach')/g + m reach reach', shape (n, n), kg m^2."""
        return self.onto_end + np.outer(self.mass * self.reach - self.moments / self.gravity, self.reach)

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (n, n), kg m^2."""
        turned, matrix = q[:, None] - q, np.zeros((len(q), len(q)))
        matrix += self.weights * np.cos(turned) + self.odd * np.sin(turned)
        forward, _ = self._moments(q)
        matrix[0] += self.radius * forward
        matrix[:, 0] += self.radius * forward
        matrix[0, 0] += self.radius**2 * self.mass
        return matrix

    def coriolis_matrix(self, q: Array, dq: Array) -> Array:
        """C(q, dq), shape (n, n), kg m^2/s; dM/dt - 2 C is skew."""
        turned, matrix = q[:, None] - q, np.zeros((len(q), len(q)))
        matrix += self.weights * np.sin(turned) - self.odd * np.cos(turned)
        matrix[0] += self.radius * self._moments(q)[1]
        return matrix * dq

    def gravity_vector(self, q: Array, slope: float) -> Array:
        """g(q, slope), shape (n,), N m."""
        forward, upward = self._moments(q)
        forces = self.gravity * (np.cos(slope) * upward - np.sin(slope) * forward)
        forces[0] -= self.gravity * self.radius * self.mass * np.sin(slope)
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

    def accelerations(self, forces: Array, q: Array, dq: Array, slope: float) -> Array:
        """Accelerations under generalised forces, N m: shape (n,), rad/s^2."""
        pull = forces - self.coriolis_matrix(q, dq) @ dq - self.gravity_vector(q, slope)
        return np.linalg.solve(self.mass_matrix(q), pull).astype(np.float64)

    @property
    def linkage(self) -> Linkage:
        """The linkage of the chain's angles alone."""
        n, levers = len(self.reach), np.zeros((POINTS, len(self.reach)))
        levers[MASS], levers[MASS + 1] = self.moments / self.gravity, self.across / self.gravity
        even, odd = self.weights.tolist(), np.broadcast_to(self.odd, (n, n)).tolist()
        return Linkage(n, n, False, self.mass, self.gravity, self.radius, even, odd, levers.tolist())

    @property
    def free_motion(self) -> Callable[[Array, Array, float], Array]:
        """The motion without torques, compiled: (q, dq, slope) -> accelerations, rad/s^2, shape (n,)."""
        n, linkage = len(self.reach), self.linkage
        motion = Motion(free=n, **room())
        stand(linkage, motion)
        share_arrays(motion)
        (fixed, below), (made, _) = packed(linkage), packed(motion)
        moved = _machine_code()

        def accelerations(q: Array, dq: Array, slope: float) -> Array:
            motion.ddq[:] = 0.0
            moved(fixed.ctypes.data, made.ctypes.data, slope, q, dq)
            return np.array(motion.ddq[:n])

        accelerations.kept = below  # type: ignore[attr-defined]  # lives as long as machine code reads it
        return accelerations

    def joints_lock(self, groups: ArrayLike, q: Array, dq: Array) -> Array:
        """Rates after joints have locked at once, shape (k,), rad/s.

        Args:
            groups: Says with 1 which angles (rows) move as one afterwards (columns), shape (n, k).
            q: Angles, shape (n,), rad.
            dq: Rates before, shape (n,), rad/s.
        """
        E = np.asarray(groups, dtype=np.float64)
        momentum = E.T @ self.mass_matrix(q)
        return np.linalg.solve(momentum @ E, momentum @ dq).astype(np.float64)

    def _moments(self, q: Array) -> tuple[Array, Array]:
        """Derivatives of the first moments of mass by the angles, along the ground and along its normal, kg m."""
        sine, cosine = np.sin(q), np.cos(q)
        forward, upward = self.moments * cosine - self.across * sine, -self.moments * sine - self.across * cosine
        return forward / self.gravity, upward / self.gravity


def moved_at(linkage: int, motion: int, slope: float, q: Array, dq: Array) -> None:
    """Turn the forces of a motion into accelerations on a slope, rad; linkage and motion are addresses."""
    w = _motion_at(motion, 0)
    w.sine, w.cosine = sine_cosine(slope)
    move(_linkage_at(linkage, 0), w, q, dq)


_linkage_at, _motion_at = reader(Linkage), reader(Motion)


@cache
def _machine_code() -> Any:
    """`moved_at` as machine code; compiled once, and kept on disk."""
    from mjbiped.numerics.machine import compiled

    return compiled(moved_at, "void(int64, int64, float64, float64[::1], float64[::1])")


def chain_by(linkage: Linkage, groups: Sequence[int]) -> Chain:
    """A linkage by fewer angles.

    Args:
        linkage: The linkage.
        groups: With which angle each segment moves; -1: it rests.
    """
    E = (np.asarray(groups)[:, None] == np.arange(max(groups) + 1)).astype(np.float64)
    levers = np.asarray(linkage.levers) @ E
    return Chain(
        weights=E.T @ linkage.even @ E,
        moments=levers[WEIGHT],
        reach=levers[END],
        mass=linkage.mass,
        gravity=linkage.gravity,
        odd=E.T @ linkage.odd @ E,
        across=levers[WEIGHT + 1],
        beside=levers[END + 1],
        radius=linkage.radius,
    )


def chain_of(
    bodies: Sequence[tuple[float, float, int | None, Sequence[float]]], reach: Sequence[float], gravity: float
) -> Chain:
    """The chain of some bodies.

    Args:
        bodies: Of each its mass (kg), its inertia about its own centre of mass (kg m^2), the segment that it turns with
            (None for a point mass), and the levers of its centre of mass, one of each segment (m).
        reach: Levers of the chain's far end, m.
        gravity: m/s^2.
    """
    weights, moments = np.zeros((len(reach), len(reach))), np.zeros(len(reach))
    for mass, inertia, segment, levers in bodies:
        weights += mass * np.outer(levers, levers)
        moments += gravity * mass * np.asarray(levers)
        if segment is not None:
            weights[segment, segment] += inertia
    return Chain(weights, moments, np.array(reach, dtype=np.float64), sum(body[0] for body in bodies), gravity)
