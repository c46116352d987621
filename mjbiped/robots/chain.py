"""Any planar chain of rigid segments on a pinned foot: its equations of motion and its plastic impacts.

Each segment has one angle q_i, absolute: from the normal of the ground, rad, positive forward. The centre of mass of
each body then stands at the sum of lever_ki (sin q_i, cos q_i), with constant levers, and Lagrange's equations are

    M_ij = A_ij cos(q_i - q_j),   C_ij = A_ij sin(q_i - q_j) dq_j,   g_i = -b_i sin(q_i + slope)

with A_ij = sum_k m_k lever_ki lever_kj, plus the inertia of the bodies of segment i where i = j, and with
b_i = g sum_k m_k lever_ki. Two, three or four segments make no difference. Segments that a locked joint makes one, at
equal angles, are a chain again, of E'AE, E'b, where E has a column for each group of them.

An impact that is plastic and without slip projects the momentum of the chain, its base floating, on what the joints and
the ground still allow: u = (J'FJ)^-1 J'F v. Where the far end strikes and becomes the new pivot, J'FJ and J'F have the
form of M again, of the weights `Chain.about_end` and `Chain.onto_end`; where a joint locks, of E'AE and E'A.

The functions below hold these laws once, for plain Python as for Numba. They write into arrays that they are given, and
allocate none. docs/knees.md derives the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.numerics import jit
from mjbiped.numerics.trigonometry import sine_cosine

Array = NDArray[np.float64]


def with_room(chain: Chain, beside: float = 0.0) -> SimpleNamespace:
    """A chain of n segments with room to compute in, for functions that hand all of it on as one thing.

    Args:
        chain: The chain.
        beside: How far its far end lies beside the line of each segment, a right angle ahead of it, m.

    Returns:
        Copies of weights, moments and reach, `beside` and gravity; rooms `q`, `dq`, `ddq` for a motion, `row` and
        `push` for a point's Jacobian and the motion that a force makes, all of shape (n,), and `even` and `odd` of
        shape (n, n).
    """
    n = len(chain.reach)
    room = {name: np.zeros(n) for name in ("q", "dq", "ddq", "row", "push")}
    squares = {name: np.zeros((n, n)) for name in ("even", "odd")}
    arrays = {name: getattr(chain, name).copy() for name in ("weights", "moments", "reach")}
    return SimpleNamespace(beside=np.full(n, beside), gravity=chain.gravity, **arrays, **room, **squares)


def hold_end(s: Any, slope: float, x: float, z: float) -> float:
    """Let a surface hold the chain's far end along its normal (x, z), without friction; returns the force along it, N.

    Args:
        s: The chain `with_room`, the motion in it. Accelerations are changed. If the rates are zero, and rates stand in
            the place of accelerations, the force is the impulse that stops the far end, N s.
        slope: Of the ground that the angles are measured from the normal of, rad.
        x: Horizontal component of the normal.
        z: Vertical component.
    """
    bend = 0.0
    for i in range(len(s.q)):
        sine, cosine = sine_cosine(s.q[i] + slope)
        turned, bent = cosine * x - sine * z, sine * x + cosine * z
        s.row[i] = s.reach[i] * turned - s.beside[i] * bent
        bend -= (s.reach[i] * bent + s.beside[i] * turned) * s.dq[i] * s.dq[i]
    return constrain(s.weights, s.q, s.row, bend, s.even, s.odd, s.push, s.ddq)


def stop_end(s: Any, w: Any, first: int) -> float:
    """Impulse, N s, of a plastic, frictionless impact that stops the chain's far end along (w.pushed_x, w.pushed_z).

    Args:
        s: The chain of n segments `with_room`; the rates after the impact stand in `s.ddq`.
        w: Direction, slope of the ground, and state `y`.
        first: Index in `y` of the first of the n rates; the angles are its first n numbers.
    """
    for i in range(len(s.q)):
        s.q[i], s.ddq[i], s.dq[i] = w.y[i], w.y[first + i], 0.0
    return hold_end(s, w.slope, w.pushed_x, w.pushed_z)


def coupled(weight: float, angle: float) -> tuple[float, float]:
    """A_ij cos(q_i - q_j), of M, and A_ij sin(q_i - q_j), of C, for one A_ij and the angle q_i - q_j, rad."""
    sine, cosine = sine_cosine(angle)
    return weight * cosine, weight * sine


def pulled(moment: float, angle: float) -> float:
    """Gravity's pull -b_i sin(angle) on a segment, N m, for its b_i (N m) and its angle from the vertical, rad."""
    sine, _ = sine_cosine(angle)
    return -moment * sine


def weighted(weights: Array, rows: Array, columns: Array, even: Array, odd: Array) -> None:
    """Write weights_ij cos(rows_i - columns_j) into `even`, and weights_ij sin(rows_i - columns_j) into `odd`.

    Of one chain's A and angles, `even` is M, and `odd` times dq_j is C_ij.
    """
    for i in range(len(rows)):
        for j in range(len(columns)):
            even[i, j], odd[i, j] = coupled(weights[i, j], rows[i] - columns[j])


def add_gravity(moments: Array, q: Array, slope: float, sign: float, forces: Array) -> None:
    """Add the generalised gravity g(q, slope), times `sign`, to the forces, N m."""
    for i in range(len(q)):
        forces[i] += pulled(sign * moments[i], q[i] + slope)


def solve(matrix: Array, vector: Array) -> None:
    """Solve a symmetric positive definite system in place: the vector becomes matrix^-1 vector, the matrix is lost."""
    n = len(vector)
    for j in range(n):
        for i in range(j + 1, n):
            share = matrix[i, j] / matrix[j, j]
            for k in range(j + 1, n):
                matrix[i, k] -= share * matrix[j, k]
            vector[i] -= share * vector[j]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            vector[i] -= matrix[i, k] * vector[k]
        vector[i] /= matrix[i, i]


def accelerate(
    weights: Array, moments: Array, slope: float, q: Array, dq: Array, even: Array, odd: Array, ddq: Array
) -> None:
    """Turn generalised forces into accelerations, M^-1 (forces - C dq - g), rad/s^2.

    Args:
        weights: A, shape (n, n), kg m^2.
        moments: b, shape (n,), N m.
        slope: Of the ground, rad, positive downhill.
        q: Angles from its normal, shape (n,), rad.
        dq: Rates, shape (n,), rad/s.
        even: Room of shape (n, n).
        odd: The same.
        ddq: The forces of motors, shape (n,), N m; afterwards the accelerations.
    """
    weighted(weights, q, q, even, odd)
    for i in range(len(q)):
        for j in range(len(q)):
            ddq[i] -= odd[i, j] * dq[j] * dq[j]
    add_gravity(moments, q, slope, -1.0, ddq)
    solve(even, ddq)


def inverse_dynamics(
    moments: Array,
    sin_slope: float,
    cos_slope: float,
    q: Array,
    dq: Array,
    even: Array,
    odd: Array,
    motion: Array,
    forces: Array,
) -> None:
    """Write the generalised forces that make a motion, M ddq + C dq + g, into `forces`, N m.

    Args:
        moments: b, shape (n,), N m.
        sin_slope: Sine of the ground's slope, or what is taken for it.
        cos_slope: Its cosine, likewise.
        q: Angles from its normal, shape (n,), rad.
        dq: Rates, shape (n,), rad/s.
        even: M, as `weighted` has written it of A and the angles.
        odd: As `weighted` has written it.
        motion: Accelerations, shape (n,), rad/s^2.
        forces: Shape (n,).
    """
    for i in range(len(q)):
        sine, cosine = sine_cosine(q[i])
        forces[i] = -moments[i] * (cosine * sin_slope + sine * cos_slope)
        for j in range(len(q)):
            forces[i] += even[i, j] * motion[j] + odd[i, j] * dq[j] * dq[j]


def strike(after: Array, before: Array, q_after: Array, q: Array, dq: Array, even: Array, odd: Array) -> None:
    """Rates after a plastic impact, rad/s: what is left of the rates before it stands in the first places of `dq`.

    Args:
        after: Weights of J'FJ, shape (k, k), kg m^2.
        before: Weights of J'F, shape (k, n).
        q_after: Angles of the segments that are left, shape (k,), rad.
        q: Angles before, shape (n,).
        dq: Rates before, shape (n,); afterwards the first k of them are the new ones.
        even: Room of shape (n, n).
        odd: The same.
    """
    k, n = len(q_after), len(q)
    weighted(before, q_after, q, even, odd)
    for i in range(k):
        odd[0, i] = 0.0
        for j in range(n):
            odd[0, i] += even[i, j] * dq[j]
    for i in range(k):
        dq[i] = odd[0, i]
    weighted(after, q_after, q_after, even, odd)
    solve(even[:k, :k], dq[:k])


def strike_stiff(
    after: Array, before: Array, body: NDArray[np.int64], q: Array, dq: Array, even: Array, odd: Array
) -> None:
    """As `strike`, of segments that an impact makes rigid bodies, bent as they are.

    Args:
        after: Weights of F about the struck point, shape (n, n), kg m^2.
        before: Those of F from the rates before it, shape (n, n).
        body: Of each segment, the number of the body that it is part of: 0 and on, ascending, integers, shape (n,).
        q: Angles, shape (n,), rad.
        dq: Rates before, shape (n,); afterwards those of the bodies stand in the first places.
        even: Room of shape (n, n).
        odd: The same.
    """
    n, k = len(q), body[-1] + 1
    weighted(before, q, q, even, odd)
    for j in range(n):
        odd[0, j] = 0.0
    for i in range(n):
        for j in range(n):
            odd[0, body[i]] += even[i, j] * dq[j]
    for i in range(n):
        dq[i] = odd[0, i]
    weighted(after, q, q, even, odd)
    for i in range(n):
        for j in range(n):
            odd[i, j] = 0.0
    for i in range(n):
        for j in range(n):
            odd[body[i], body[j]] += even[i, j]
    solve(odd[:k, :k], dq[:k])


def constrain(
    weights: Array, q: Array, row: Array, rest: float, even: Array, odd: Array, push: Array, motion: Array
) -> float:
    """Let a force along one direction bring row . motion + rest to zero; returns that force, or that impulse.

    The motion are accelerations (the force then holds a point), or rates (an impulse stops it, where rest is 0).

    Args:
        weights: A, shape (n, n), kg m^2.
        q: Angles, shape (n,), rad.
        row: The point's Jacobian along the direction, shape (n,), m.
        rest: What the point has of that motion without `motion`: m/s^2 by the rates, 0 in an impact.
        even: Room of shape (n, n).
        odd: The same.
        push: Room of shape (n,).
        motion: Accelerations or rates, shape (n,); changed.
    """
    weighted(weights, q, q, even, odd)
    for i in range(len(q)):
        push[i] = row[i]
    solve(even, push)
    along = 0.0
    for i in range(len(q)):
        rest += row[i] * motion[i]
        along += row[i] * push[i]
    force = -rest / along
    for i in range(len(q)):
        motion[i] += push[i] * force
    return force


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


def ground_force(moments: Array, mass: float, gravity: float, q: Array, dq: Array, ddq: Array) -> tuple[float, float]:
    """Force of the ground on the chain, forward and upward, N: the rate of its momentum, and its weight.

    Args:
        moments: b, shape (n,), N m.
        mass: Of the whole chain, kg.
        gravity: m/s^2.
        q: Angles from the vertical, shape (n,), rad.
        dq: Rates, rad/s.
        ddq: Accelerations, rad/s^2.
    """
    forward, upward = 0.0, mass * gravity
    for i in range(len(q)):
        sine, cosine = sine_cosine(q[i])
        ahead, above = segment_force(moments[i] / gravity, sine, cosine, dq[i], ddq[i])
        forward, upward = forward + ahead, upward + above
    return forward, upward


@cache
def machine_code() -> Any:
    """`accelerate` as machine code, one for chains of every length; compiled once, and kept on disk."""
    digest = jit.prepared((accelerate,), inlined=(accelerate,))
    return jit.from_source(jit.jitted, "moved", _SOURCE, {"accelerate": accelerate}, digest)


_SOURCE = """
def moved(weights, moments, slope, q, dq, even, odd, ddq):
    accelerate(weights, moments, slope, q, dq, even, odd, ddq)
"""


class Chain(NamedTuple):
    """The constants of a chain of n segments.

    Attributes:
        weights: A, shape (n, n), kg m^2, symmetric.
        moments: b, shape (n,), N m.
        reach: Levers of the chain's far end, the swing foot: shape (n,), m.
        mass: Of the whole chain, kg.
        gravity: m/s^2.
    """

    weights: Array
    moments: Array
    reach: Array
    mass: float
    gravity: float

    @property
    def onto_end(self) -> Array:
        """Weights of J'F where the far end strikes and the foot leaves: A - reach b'/g, shape (n, n), kg m^2."""
        return self.weights - np.outer(self.reach, self.moments) / self.gravity

    @property
    def about_end(self) -> Array:
        """Weights of J'FJ then, the chain's A about its far end: A - (reach b' + b reach')/g + m reach reach'."""
        return self.onto_end + np.outer(self.mass * self.reach - self.moments / self.gravity, self.reach)

    def locked(self, groups: ArrayLike) -> Chain:
        """The chain whose joints are locked: E of shape (n, k) says with 1 which segments (rows) move as one (columns).

        The segments of a group are at equal angles.
        """
        E = np.asarray(groups, dtype=np.float64)
        return Chain(E.T @ self.weights @ E, E.T @ self.moments, E.T @ self.reach, self.mass, self.gravity)

    @property
    def free_motion(self) -> Callable[[Array, Array, float], Array]:
        """The motion without torques, compiled: (q, dq, slope) -> accelerations, rad/s^2, shape (n,)."""
        (even, odd), moved = np.empty((2, *self.weights.shape)), machine_code()

        def motion(q: Array, dq: Array, slope: float) -> Array:
            ddq = np.zeros(len(q))
            moved(self.weights, self.moments, slope, q, dq, even, odd, ddq)
            return ddq

        return motion

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (n, n), kg m^2."""
        return self._weighted(q)[0]

    def coriolis_matrix(self, q: Array, dq: Array) -> Array:
        """C(q, dq), shape (n, n), kg m^2/s; dM/dt - 2 C is skew."""
        return self._weighted(q)[1] * dq

    def gravity_vector(self, q: Array, slope: float) -> Array:
        """g(q, slope), shape (n,), N m."""
        forces = np.zeros(len(q))
        add_gravity(self.moments, q, slope, 1.0, forces)
        return forces

    def kinetic_energy(self, q: Array, dq: Array) -> float:
        """Kinetic energy, J."""
        return 0.5 * float(dq @ self.mass_matrix(q) @ dq)

    def potential_energy(self, q: Array, slope: float) -> float:
        """Potential energy, J, zero at the height of the pinned foot."""
        return float(self.moments @ np.cos(q + slope))

    def end(self, q: Array) -> Array:
        """The far end from the pinned foot, shape (..., 2), m: along the ground, along its normal; q: (..., n)."""
        return np.stack([np.sin(q) @ self.reach, np.cos(q) @ self.reach], axis=-1)

    def ground_force(self, forces: Array, q: Array, dq: Array, slope: float) -> tuple[tuple[float, float], Array]:
        """Force of the ground, forward and upward, N, and accelerations, rad/s^2, under generalised forces, N m."""
        pull = forces - self.coriolis_matrix(q, dq) @ dq - self.gravity_vector(q, slope)
        ddq: Array = np.linalg.solve(self.mass_matrix(q), pull).astype(np.float64)
        return ground_force(self.moments, self.mass, self.gravity, q + slope, dq, ddq), ddq

    def end_strikes(self, q: Array, dq: Array) -> Array:
        """Rates after the far end's plastic impact, by which the foot leaves the ground: shape (n,), rad/s."""
        return _struck(self.about_end, self.onto_end, q, q, dq)

    def end_strikes_stiff(self, body: ArrayLike, q: Array, dq: Array) -> Array:
        """The same where segments become rigid bodies, bent as they are, shape (k,), rad/s; see `strike_stiff`."""
        rates, numbers = np.array(dq, dtype=np.float64), np.asarray(body, dtype=np.int64)
        even, odd = np.empty((2, len(q), len(q)))
        strike_stiff(self.about_end, self.onto_end, numbers, q, rates, even, odd)
        return rates[: numbers[-1] + 1]

    def joints_lock(self, groups: ArrayLike, q: Array, dq: Array) -> Array:
        """Rates after joints have locked at once, shape (k,), rad/s: of segments as `locked` groups them.

        `q`, of shape (n,), has equal angles within each group.
        """
        E = np.asarray(groups, dtype=np.float64)
        return _struck(E.T @ self.weights @ E, E.T @ self.weights, E.T @ q / E.sum(axis=0), q, dq)

    def _weighted(self, q: Array) -> tuple[Array, Array]:
        even, odd = np.empty((2, len(q), len(q)))
        weighted(self.weights, q, q, even, odd)
        return even, odd


def _struck(after: Array, before: Array, q_after: Array, q: Array, dq: Array) -> Array:
    rates = np.array(dq, dtype=np.float64)
    even, odd = np.empty((2, len(q), len(q)))
    strike(after, before, q_after, q, rates, even, odd)
    return rates[: len(q_after)]


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
