"""Any planar linkage of rigid bodies whose first segment rolls on a circular arc: its equations and its impacts.

Each segment has one angle q_j, from the normal of the ground, rad, positive forward. The place of body k is the centre
of the stance foot's arc plus, for each segment, a lever: `along` its line and `ahead` of it by a right angle. Without
slip the centre moves by radius times dq_0 along the ground, so that, in the directions of ground and normal,

    v_k = sum_j J_kj dq_j,   J_kj = (along cos q_j - ahead sin q_j, -along sin q_j - ahead cos q_j),

plus (radius, 0) where j = 0. D'Alembert's principle then gives M ddq = sum_k m_k J_k' (g - c_k) + torques, where c_k is
what the rates alone make of the body's acceleration. `mjbiped.robots.chain` is the case of a point foot, and of masses
on the lines, summed up.

An impact that is plastic and without slip projects the momentum on what the ground then allows (McGeer 1990).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.numerics import jit
from mjbiped.numerics.records import in_one_block
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots.chain import Array, solve

Integers = NDArray[np.int64]


def turn(s: Any, q: Any) -> None:
    """Write the Jacobians of all bodies and of the far end at angles q, rad.

    Args:
        s: The linkage `with_room`: `forward` and `upward`, in the directions of the ground and its normal, are
            written, and `lever`, which is `forward` without rolling. Their derivatives are `upward` and -`lever`.
        q: Holds the angles in its first places, one for each segment.
    """
    for j in range(len(s.force)):
        sine, cosine = sine_cosine(q[j])
        for k in range(len(s.along)):
            along, ahead = s.along[k, j], s.ahead[k, j]
            s.lever[k, j] = along * cosine - ahead * sine
            s.forward[k, j] = s.lever[k, j] + (s.radius if j == 0 else 0.0)
            s.upward[k, j] = -along * sine - ahead * cosine


def load(s: Any, dq: Any, slope: float) -> None:
    """Write the mass matrix into `s.matrix`, kg m^2, and add gravity and what the rates make to the forces `s.force`.

    Args:
        s: The linkage, after `turn`.
        dq: Rates, rad/s.
        slope: Of the ground, rad, positive downhill.
    """
    n = len(s.force)
    sine, cosine = sine_cosine(slope)
    for i in range(n):
        for j in range(n):
            s.matrix[i, j] = 0.0
    for k in range(len(s.mass)):
        mass = s.mass[k]
        forward, upward = s.gravity * sine, -s.gravity * cosine
        for j in range(n):
            forward -= s.upward[k, j] * dq[j] * dq[j]
            upward += s.lever[k, j] * dq[j] * dq[j]
        for i in range(n):
            s.force[i] += mass * (s.forward[k, i] * forward + s.upward[k, i] * upward)
            for j in range(n):
                s.matrix[i, j] += mass * (s.forward[k, i] * s.forward[k, j] + s.upward[k, i] * s.upward[k, j])
        if s.segment[k] >= 0:
            s.matrix[s.segment[k], s.segment[k]] += s.inertia[k]


def accelerate(s: Any, q: Any, dq: Any, slope: float) -> None:
    """Turn the forces of motors in `s.force` (N m) into accelerations, rad/s^2; the arguments are those of `load`."""
    turn(s, q)
    load(s, dq, slope)
    solve(s.matrix, s.force)


def gather(s: Any, q: Any, dq: Any, q_after: Any) -> None:
    """Write the momentum that a heel strike leaves into `s.force`, and the mass matrix after it into `s.matrix`.

    The bodies are in the order from the stance foot to the swing foot, whose order the new roles reverse.

    Args:
        s: The linkage with room.
        q: Angles before the impact, rad.
        dq: Rates before it, rad/s.
        q_after: Angles in the new roles.
    """
    n, bodies = len(q), len(s.mass)
    turn(s, q)
    for k in range(bodies):
        s.speed[k, 0] = s.speed[k, 1] = s.speed[k, 2] = 0.0
        for j in range(n):
            s.speed[k, 0] += s.forward[k, j] * dq[j]
            s.speed[k, 1] += s.upward[k, j] * dq[j]
        if s.segment[k] >= 0:
            s.speed[k, 2] = dq[s.segment[k]]
    turn(s, q_after)
    for i in range(n):
        s.force[i] = 0.0
    load(s, s.still, 0.0)
    for i in range(n):
        s.force[i] = 0.0
        for k in range(bodies):
            was = bodies - 1 - k
            pushed = s.forward[k, i] * s.speed[was, 0] + s.upward[k, i] * s.speed[was, 1]
            s.force[i] += s.mass[k] * pushed
            if s.segment[k] == i:
                s.force[i] += s.inertia[k] * s.speed[was, 2]


def rolling_force(s: Any, slope: float, state: Any, ddq: Any, first: int) -> tuple[float, float]:
    """Rate of the momentum, forward and upward, N.

    Args:
        s: The linkage, after `turn`.
        slope: Of the ground, rad.
        state: Angles (rad) and rates (rad/s), one after the other.
        ddq: Holds the accelerations, rad/s^2.
        first: Index of the first of them.
    """
    n, along, normal = len(s.force), 0.0, 0.0
    for k in range(len(s.mass)):
        for j in range(n):
            motion, square = ddq[first + j], state[n + j] * state[n + j]
            along += s.mass[k] * (s.forward[k, j] * motion + s.upward[k, j] * square)
            normal += s.mass[k] * (s.upward[k, j] * motion - s.lever[k, j] * square)
    sine, cosine = sine_cosine(slope)
    return along * cosine + normal * sine, normal * cosine - along * sine


@cache
def machine_code() -> Any:
    """`accelerate` as machine code, compiled once, and kept on disk."""
    digest = jit.prepared((accelerate,), inlined=(accelerate,))
    source = "def moved(s, q, dq, slope):\n    accelerate(s, q, dq, slope)\n"
    return jit.from_source(jit.jitted, "moved", source, {"accelerate": accelerate}, digest)


class Linkage(NamedTuple):
    """The constants of a linkage of n segments and as many bodies as `mass` has; its methods are those of a `Chain`.

    Attributes:
        mass: kg, shape (bodies,), in the order from the stance foot to the swing foot.
        inertia: Of each body about its centre of mass, kg m^2.
        segment: That it turns with; -1 for a point mass.
        along: Levers along the segments, m, shape (bodies + 1, n); the last row is the swing foot's arc's centre.
        ahead: Levers a right angle ahead of the segments, m.
        radius: Of the feet, m.
        gravity: m/s^2.
    """

    mass: Array
    inertia: Array
    segment: Integers
    along: Array
    ahead: Array
    radius: float
    gravity: float

    def with_room(self) -> SimpleNamespace:
        """The linkage with room to compute in, as the functions of this module take it."""
        rows, n = self.along.shape
        room = {name: np.zeros((rows, n)) for name in ("lever", "forward", "upward")}
        vectors = {name: np.zeros(n) for name in ("force", "still")}
        return SimpleNamespace(
            mass=self.mass.copy(),
            inertia=self.inertia.copy(),
            segment=self.segment.copy(),
            along=self.along.copy(),
            ahead=self.ahead.copy(),
            reach=self.along[-1].copy(),
            beside=self.ahead[-1].copy(),
            radius=self.radius,
            gravity=self.gravity,
            speed=np.zeros((rows, 3)),
            matrix=np.zeros((n, n)),
            **room,
            **vectors,
        )

    @property
    def free_motion(self) -> Callable[[Array, Array, float], Array]:
        """The motion without torques, compiled: (q, dq, slope) -> accelerations, rad/s^2, shape (n,)."""
        moved, block = machine_code(), in_one_block(self.with_room())
        force = block.force  # a view: looking it up in the record takes longer than the motion

        def motion(q: Array, dq: Array, slope: float) -> Array:
            force[:] = 0.0
            moved(block, q, dq, slope)
            return np.array(force)

        return motion

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (n, n), kg m^2."""
        matrix: Array = self._loaded(q, np.zeros(len(q)), 0.0).matrix
        return matrix

    def coriolis_matrix(self, q: Array, dq: Array) -> Array:
        """C(q, dq), shape (n, n), kg m^2/s; dM/dt - 2 C is skew."""
        s, mass = self._loaded(q, np.zeros(len(q)), 0.0), self.mass[:, None]
        forward, upward, lever = s.forward[:-1], s.upward[:-1], s.lever[:-1]
        return np.asarray((mass * forward).T @ upward - (mass * upward).T @ lever) * dq

    def gravity_vector(self, q: Array, slope: float) -> Array:
        """g(q, slope), shape (n,), N m."""
        return -np.asarray(self._loaded(q, np.zeros(len(q)), slope).force)

    def kinetic_energy(self, q: Array, dq: Array) -> float:
        """Kinetic energy, J."""
        return 0.5 * float(dq @ self.mass_matrix(q) @ dq)

    def potential_energy(self, q: Array, slope: float) -> float:
        """Potential energy, J, zero at the height of the arc's centre where the stance leg is upright."""
        sine, cosine = np.sin(q + slope), np.cos(q + slope)
        heights = self.along[:-1] @ cosine - self.ahead[:-1] @ sine - self.radius * q[0] * np.sin(slope)
        return float(self.gravity * self.mass @ heights)

    def end(self, q: Array) -> Array:
        """The swing foot's arc's centre from the stance foot's, shape (..., 2), m, along the ground and its normal."""
        sine, cosine, along, ahead = np.sin(q), np.cos(q), self.along[-1], self.ahead[-1]
        return np.stack([sine @ along + cosine @ ahead, cosine @ along - sine @ ahead], axis=-1)

    def ground_force(self, forces: Array, q: Array, dq: Array, slope: float) -> tuple[tuple[float, float], Array]:
        """Force of the ground, forward and upward, N, and accelerations, rad/s^2, under generalised forces, N m."""
        s = self.with_room()
        s.force += forces
        accelerate(s, q, dq, slope)
        ddq: Array = s.force
        forward, upward = rolling_force(s, slope, np.concatenate([q, dq]), ddq, 0)
        return (forward, upward + self.gravity * float(self.mass.sum())), ddq

    def end_strikes(self, q: Array, dq: Array) -> Array:
        """Rates after the swing foot's plastic impact, in the new roles, shape (n,), rad/s.

        The leg that strikes the ground is one segment, and so is the other one before the impact.
        """
        s = self.with_room()
        gather(s, q, dq, q[[1] + [0] * (len(q) - 1)])
        solve(s.matrix, s.force)
        return np.asarray(s.force)

    def joints_lock(self, groups: ArrayLike, q: Array, dq: Array) -> Array:
        """Rates after joints have locked at once, shape (k,), rad/s; see `mjbiped.robots.chain.Chain.joints_lock`."""
        E = np.asarray(groups, dtype=np.float64)
        momentum = E.T @ self.mass_matrix(q)
        return np.linalg.solve(momentum @ E, momentum @ dq).astype(np.float64)

    def locked(self, groups: ArrayLike) -> Linkage:
        """The linkage whose joints are locked; see `mjbiped.robots.chain.Chain.locked`."""
        E = np.asarray(groups, dtype=np.float64)
        segment = np.where(self.segment < 0, -1, E.argmax(axis=1)[self.segment])
        return self._replace(segment=segment, along=self.along @ E, ahead=self.ahead @ E)

    def _loaded(self, q: Array, dq: Array, slope: float) -> SimpleNamespace:
        s = self.with_room()
        turn(s, q)
        load(s, dq, slope)
        return s


def linkage_of(
    bodies: Sequence[tuple[float, float, int, Sequence[complex]]],
    end: Sequence[complex],
    radius: float,
    gravity: float,
) -> Linkage:
    """The linkage of some bodies.

    Args:
        bodies: From the stance foot to the swing foot: of each its mass (kg), its inertia about its centre of mass
            (kg m^2), its segment (-1: a point mass), and its levers (m): the real part along, the imaginary one ahead.
        end: Levers of the swing foot's arc's centre, m.
        radius: Of the feet, m.
        gravity: m/s^2.
    """
    levers = np.array([*(one[3] for one in bodies), end], dtype=np.complex128)
    mass, inertia = np.array([one[0] for one in bodies]), np.array([one[1] for one in bodies])
    segment = np.array([one[2] for one in bodies], dtype=np.int64)
    along, ahead = np.ascontiguousarray(levers.real), np.ascontiguousarray(levers.imag)
    return Linkage(mass, inertia, segment, along, ahead, radius, gravity)
