"""The closed loop's error as a linear time-varying system, equation (22): regressor, transition matrix, excitation.

With z1, z2 of (5), (9), the error of the estimates (s~, c~) and eta = (z1, z2, s~, c~), the torque (14) and the
adaptive law (17) make

    d/dt z1 = -K1 z1 + z2
    d/dt z2 = -z1 - K2 z2 + M^-1 [g_c g_s] (s~, c~)
    d/dt (s~, c~) = -gamma [g_c g_s]' M^-1 z2

along *any* motion q(t) of the robot that the law models: linear in eta, for M, g_c and g_s depend on q alone.
docs/stability.md derives it and says what follows.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.gaits.passive import eigenvalues
from mjbiped.robots import compass
from mjbiped.robots.compass import Array

SIZE = 6  # of eta: z1 (2, rad), z2 (2, rad/s), errors of sine and cosine
ESTIMATES = slice(4, 6)

_NODES = (0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0)  # Gauss and Legendre's, of order 4


def regressor(constants: compass.Constants, q: Array) -> Array:
    """W(t) of (22), its two columns that are not zero: [g_c, g_s]' M^-1.

    Args:
        constants: Of the controller's robot model.
        q: Stance and swing angle, rad, shape (n, 2).

    Returns:
        Shape (n, 2, 2), 1/s²: the angular accelerations of the legs (columns) that an error of one in the estimate of
        sine (first row) and cosine (second row) makes.
    """
    rows = []
    for q1, q2 in q.tolist():
        legs = compass.legs_of(q1, q2)
        m11, m12, m22 = compass.mass_terms(constants, legs)
        gc1, gc2, gs1, gs2 = compass.gravity_terms(constants, legs)
        rows.append((*compass.solve_mass(m11, m12, m22, gc1, gc2), *compass.solve_mass(m11, m12, m22, gs1, gs2)))
    return np.array(rows, dtype=np.float64).reshape(-1, 2, 2)


def system_matrix(controller: AdaptiveTracking, w: Array) -> Array:
    """The matrix of (22), shape (n, 6, 6), from the regressor w of shape (n, 2, 2)."""
    eye = np.eye(2)
    matrix = np.zeros((len(w), SIZE, SIZE))
    matrix[:, 0:2, 0:2] = -controller.position_gain * eye
    matrix[:, 0:2, 2:4] = eye
    matrix[:, 2:4, 0:2] = -eye
    matrix[:, 2:4, 2:4] = -controller.velocity_gain * eye
    matrix[:, 2:4, 4:6] = w.transpose(0, 2, 1)
    matrix[:, 4:6, 2:4] = -controller.adaptation_gain * w
    return matrix


class Evolution(NamedTuple):
    """What (22) does along one stretch of motion.

    Attributes:
        transitions: Phi(t, t_0) at each time, shape (n, 6, 6); the first is the identity.
        gramian: Integral of W W' over the stretch, shape (2, 2) in (sine, cosine), 1/s³.
    """

    transitions: Array
    gramian: Array


def evolve(controller: AdaptiveTracking, time: Array, q: Array, dq: Array) -> Evolution:
    """Transition matrix and excitation of (22) along a motion.

    The motion between two times is the cubic through angles and rates (Hermite); the transition matrix is Magnus'
    expansion to order 4 at the two nodes of Gauss and Legendre, the integral their quadrature. The errors are of fourth
    order in the distance of the times. The expansion solves stretches of constant W exactly, however large the gains.

    Args:
        controller: Its robot model and gains.
        time: Ascending, shape (n,), s.
        q: Stance and swing angle, shape (n, 2), rad.
        dq: Their rates, rad/s.
    """
    h = np.diff(time)
    at_nodes = [regressor(controller.robot.constants, _hermite(h[:, None], q, dq, node)) for node in _NODES]
    first, second = (system_matrix(controller, w) for w in at_nodes)
    width = h[:, None, None]
    exponent = width / 2 * (first + second) + math.sqrt(3.0) / 12 * width**2 * (second @ first - first @ second)
    transitions = np.array(
        list(itertools.accumulate(expm(exponent), lambda so_far, new: new @ so_far, initial=np.eye(SIZE)))
    )
    gramian = (width / 2 * sum(w @ w.transpose(0, 2, 1) for w in at_nodes)).sum(axis=0)
    return Evolution(transitions, gramian)


def _hermite(h: Array, q: Array, dq: Array, x: float) -> Array:
    """Angles at the share x of each interval, of the cubic through angles and rates at its ends."""
    q0, q1, dq0, dq1 = q[:-1], q[1:], h * dq[:-1], h * dq[1:]
    y = 1.0 - x
    result: Array = y * y * (1 + 2 * x) * q0 + x * x * (1 + 2 * y) * q1 + x * y * (y * dq0 - x * dq1)
    return result


class Envelope(NamedTuple):
    """k exp(-rate (t - t_0)), a bound of the norm of Phi over a step that is sharp at its end: (23).

    Attributes:
        gain: k_C.
        rate: lambda_alpha, 1/s.
    """

    gain: float
    rate: float


def envelope(time: Array, transitions: Array) -> Envelope:
    """The bound (23) with the smallest k_C among those whose value at the end is the norm of Phi there.

    No other pair of constants makes the left side of (24) smaller, for none can be below the norm itself.

    Args:
        time: Shape (n,), s.
        transitions: Phi(t, t_0) at them, shape (n, 6, 6).
    """
    logs = np.log(np.linalg.norm(transitions, 2, axis=(1, 2)))
    left = time[-1] - time[:-1]
    rate = float(np.max((logs[:-1] - logs[-1]) / left))
    return Envelope(math.exp(logs[-1] + rate * (time[-1] - time[0])), rate)


def lyapunov_weights(controller: AdaptiveTracking) -> Array:
    """Diagonal of P, with V_a = eta' P eta / 2 (15); shape (6,)."""
    return np.array([1.0] * 4 + [1.0 / controller.adaptation_gain] * 2)


def lyapunov_gain(controller: AdaptiveTracking, transition: Array) -> float:
    """Largest V_a at the end of a stretch over V_a at its start, of all first errors; at most 1 by (17)."""
    root = np.sqrt(lyapunov_weights(controller))
    return float(np.linalg.norm(root[:, None] * transition / root, 2)) ** 2


@dataclass(frozen=True, eq=False)
class CycleStability:
    """What becomes of small errors on the limit cycle, on ground of any constant slope.

    The cycle's angles are measured from the ground, and so is all of (22): nothing here depends on the slope.

    Attributes:
        evolution: Of (22) over a period, with q = q_r.
        envelope: The constants of (23).
        impact: eta after a touchdown from eta before it, to first order, shape (6, 6). The touchdown comes when the
            swing foot meets the ground, not when the reference would: the error moves it in time.
        alpha: Of (19), to first order: how the error of the angles makes one of the rates.
        beta: Of (19): norm of the impact map.
        return_map: eta after a touchdown from eta after the one before it, shape (6, 6).
    """

    evolution: Evolution
    envelope: Envelope
    impact: Array
    alpha: float
    beta: float
    return_map: Array

    def __repr__(self) -> str:
        """One line; the matrices are long."""
        largest = abs(self.multipliers[0])
        return f"<CycleStability: contraction {self.contraction:.6g} a step, largest multiplier {largest:.6g}>"

    @property
    def contraction(self) -> float:
        """Norm of Phi over the period: the sharp k_C exp(-lambda T) of (23)."""
        return float(np.linalg.norm(self.evolution.transitions[-1], 2))

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Eigenvalues of the return map, largest modulus first; the loop is stable where all lie in the unit circle."""
        return eigenvalues(self.return_map)

    @property
    def multipliers_replanned(self) -> NDArray[np.complex128]:
        """The same where each step is re-planned to begin without tracking error: of the estimates alone."""
        return eigenvalues(self.evolution.transitions[-1][ESTIMATES, ESTIMATES])


def cycle_stability(controller: AdaptiveTracking, intervals: int = 200) -> CycleStability:
    """Theorem 1's constants on the limit cycle, where they depend on robot, gait and gains alone.

    Args:
        controller: The law; its re-planning and its update (27) do not act in the neighbourhood of the cycle.
        intervals: Of the period; the error is of fourth order in their width.
    """
    gait = controller.gait
    time = np.linspace(0.0, gait.period, intervals + 1)
    q, dq, ddq = gait.reference(time)
    evolution = evolve(controller, time, q, dq)
    phi = evolution.transitions[-1]
    impact, alpha, beta = _impact(controller, q[-1], dq[-1], ddq[-1])
    return CycleStability(evolution, envelope(time, evolution.transitions), impact, alpha, beta, impact @ phi)


def impact_matrix(constants: compass.Constants, q: Array) -> Array:
    """The matrix of the impact map (2) for the rates, shape (2, 2), at a posture q before it, shape (2,)."""
    q1, q2 = q.tolist()
    columns = [compass.impact_rates(constants, q1, q2, *unit) for unit in ((1.0, 0.0), (0.0, 1.0))]
    return np.array(columns).T


def impact_gain(position_gain: float, alpha: float, beta: float) -> float:
    """k_Delta of (20)."""
    first = 2 * position_gain**2 + 8 * beta**2 * position_gain**2 + 4 * alpha**2 + 1
    return math.sqrt(max(first, 8 * beta**2))


def _impact(controller: AdaptiveTracking, q: Array, dq: Array, ddq: Array) -> tuple[Array, float, float]:
    """First-order map of eta at a touchdown of the cycle, whose state before it is q, dq, ddq; alpha and beta of (19).

    The robot is at q - z1 and meets the ground later by t with sum(q + dq t - z1) = 0; the reference begins anew.
    """
    constants = controller.robot.constants
    swap = np.array([[0.0, 1.0], [1.0, 0.0]])
    delay = np.array([1.0, 1.0]) / dq.sum()  # t per z1
    moved = np.outer(dq, delay) - np.eye(2)  # of the posture at touchdown, per z1
    hit = impact_matrix(constants, q)
    step = 1e-5  # central differences: truncation and rounding both some 1e-10
    turn = np.column_stack(
        [
            (impact_matrix(constants, q + step * unit) - impact_matrix(constants, q - step * unit)) @ dq / (2 * step)
            for unit in np.eye(2)
        ]
    )
    z1_z1 = -swap @ moved
    dz1_z1 = -(turn @ moved + hit @ np.outer(ddq, delay))
    gain = controller.position_gain
    result = np.eye(SIZE)
    # z2 = dz1 + K1 z1 on both sides
    result[0:2, 0:2], result[0:2, 2:4] = z1_z1, 0.0
    result[2:4, 0:2] = gain * z1_z1 + dz1_z1 - gain * hit
    result[2:4, 2:4] = hit
    return result, float(np.linalg.norm(dz1_z1, 2)), float(np.linalg.norm(hit, 2))
