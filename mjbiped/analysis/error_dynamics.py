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
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import expm
from threadpoolctl import threadpool_limits

from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.robots import compass
from mjbiped.robots.compass import Array
from mjbiped.robots.model import solve_pair

SIZE = 6  # of eta: z1 (2, rad), z2 (2, rad/s), errors of sine and cosine
ESTIMATES = slice(4, 6)  # of eta: the errors of sine and cosine

_NODES = (0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0)  # Gauss and Legendre's, of order 4


def regressor(constants: compass.Constants, q: Array) -> Array:
    """Compute the two columns of the regressor W(t) of (22) that are not zero: [g_c, g_s]' M^-1.

    Args:
        constants: Constants of the controller's robot model.
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
        rows.append((*solve_pair(m11, m12, m22, gc1, gc2), *solve_pair(m11, m12, m22, gs1, gs2)))
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
    """The solution of (22) along one stretch of motion.

    Attributes:
        transitions: Phi(t, t_0) at each time, shape (n, 6, 6); the first is the identity.
        gramian: Integral of W W' over the stretch, shape (2, 2) in (sine, cosine), 1/s³.
    """

    transitions: Array
    gramian: Array


def evolve(controller: AdaptiveTracking, time: Array, q: Array, dq: Array) -> Evolution:
    """Integrate the transition matrix and the excitation of (22) along a motion.

    The motion between two times is the cubic through angles and rates (Hermite); the transition matrix is Magnus'
    expansion to order 4 at the two nodes of Gauss and Legendre, the integral their quadrature. The errors are of fourth
    order in the distance of the times. The expansion solves stretches of constant W exactly, however large the gains.

    Args:
        controller: The controller, of which robot model and gains are used.
        time: Ascending, shape (n,), s.
        q: Stance and swing angle, shape (n, 2), rad.
        dq: Their rates, rad/s.
    """
    h, angles = np.diff(time), CubicHermiteSpline(time, q, dq)
    at_nodes = [regressor(controller.robot.constants, angles(time[:-1] + node * h)) for node in _NODES]
    first, second = (system_matrix(controller, w) for w in at_nodes)
    width = h[:, None, None]
    exponent = width / 2 * (first + second) + math.sqrt(3.0) / 12 * width**2 * (second @ first - first @ second)
    with threadpool_limits(1, "blas"):  # several threads take forty times as long for matrices as small
        advances = expm(exponent)
    transitions = np.array(list(itertools.accumulate(advances, lambda so_far, new: new @ so_far, initial=np.eye(SIZE))))
    gramian = (width / 2 * sum(w @ w.transpose(0, 2, 1) for w in at_nodes)).sum(axis=0)
    return Evolution(transitions, gramian)


def lyapunov_weights(controller: AdaptiveTracking) -> Array:
    """Diagonal of P, with V_a = eta' P eta / 2 (15); shape (6,)."""
    return np.array([1.0] * 4 + [1.0 / controller.adaptation_gain] * 2)


def impact_matrix(constants: compass.Constants, q: Array) -> Array:
    """The matrix of the impact map (2) for the rates, shape (2, 2), at a posture q before it, shape (2,)."""
    q1, q2 = q.tolist()
    columns = [compass.impact_rates(constants, q1, q2, *unit) for unit in ((1.0, 0.0), (0.0, 1.0))]
    return np.array(columns).T


def impact_gain(position_gain: float, alpha: float, beta: float) -> float:
    """The constant k_Delta of (20)."""
    first = 2 * position_gain**2 + 8 * beta**2 * position_gain**2 + 4 * alpha**2 + 1
    return math.sqrt(max(first, 8 * beta**2))
