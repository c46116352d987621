"""A robot's equations as functions that a user's compiled laws can call: of tuples, without allocating anything.

`Robot.model` has the constants, plain numbers that stand among a law's parameters. The functions below return the same
as the robot's methods of similar names, for as many angles as the robot has. They check nothing.

    model = robot.model
    M, C = mass_matrix(model, q), coriolis_matrix(model, q, dq)  # M[i][j]
    g = gravity_vector(model, q, slope)

The equations are those of `mjbiped.robots.chain`, of a robot that stands on a straight leg.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots.chain import Chain

Numbers: TypeAlias = tuple[float, ...]
"""A number for each of the robot's angles: one, two or three."""

Matrix: TypeAlias = tuple[Numbers, ...]
"""The rows of a matrix."""

_ODD, _EVEN = 0, 1  # sine and cosine, as `sine_cosine` returns them
_ONES = (1.0, 1.0, 1.0)


class Model(NamedTuple):
    """The constants of a robot's equations, with n angles.

    Attributes:
        weights: A of `mjbiped.robots.chain`, n rows of n, kg m^2.
        moments: b of it, n of them, N m.
        about_end: Weights of the momentum about the foot that strikes the ground, n rows of n, kg m^2.
        onto_end: Those of the same momentum by the rates before the impact, n rows of n, kg m^2.
    """

    weights: Matrix
    moments: Numbers
    about_end: Matrix
    onto_end: Matrix


def model_of(chain: Chain) -> Model:
    """The constants of a robot that is a chain of segments whose far end becomes the stance foot."""
    weights, about, onto = (
        tuple(tuple(row) for row in matrix.tolist()) for matrix in (chain.weights, chain.about_end, chain.onto_end)
    )
    return Model(weights, tuple(chain.moments.tolist()), about, onto)


def mass_matrix(model: Model, q: Numbers) -> Matrix:
    """M(q), kg m^2, for angles in rad; see `Robot.mass_matrix`."""
    return _matrix(model.weights, q, _ONES, _EVEN)


def coriolis_matrix(model: Model, q: Numbers, dq: Numbers) -> Matrix:
    """C(q, dq), kg m^2/s, for angles and rates in rad and rad/s; see `Robot.coriolis_matrix`."""
    return _matrix(model.weights, q, dq, _ODD)


def gravity_vector(model: Model, q: Numbers, slope: float) -> Numbers:
    """g(q, slope), N m, for angles and the slope in rad; see `Robot.gravity_vector`.

    It is linear in the slope's sine and cosine: g(q, slope) = g(q, pi/2) sin(slope) + g(q, 0) cos(slope), as (13).
    """
    b = model.moments
    if len(q) == 1:
        return (_pulled(b[0], q[0] + slope),)
    if len(q) == 2:
        return _pulled(b[0], q[0] + slope), _pulled(b[1], q[1] + slope)
    return _pulled(b[0], q[0] + slope), _pulled(b[1], q[1] + slope), _pulled(b[2], q[2] + slope)


def rates_after_touchdown(model: Model, q: Numbers, dq: Numbers) -> Numbers:
    """Rates after a touchdown's plastic impact, in the new roles, rad/s; see `Robot.rates_after_touchdown`.

    The knee of the leg that strikes locks in the same instant, bent as it is.
    """
    landed, left = _impact(model.about_end, model.onto_end, q, dq)
    if len(q) == 1:
        return (left,)
    if len(q) == 2:
        return landed, left
    return landed, left, left


def rates_after_knee_strike(model: Model, q: Numbers, dq: Numbers) -> Numbers:
    """Rates after the swing knee's plastic impact on its stop, rad/s, of three; see `KneedBiped.knee_impact`."""
    swing, stance = _impact(model.weights, model.weights, q, dq)
    return stance, swing, swing


def _pulled(moment: float, angle: float) -> float:
    """Gravity's pull -b_i sin(angle) on a segment, N m, for its b_i (N m) and its angle from the vertical, rad."""
    return -moment * sine_cosine(angle)[0]


def solve_pair(m11: float, m12: float, m22: float, f1: float, f2: float) -> tuple[float, float]:
    """M^-1 f for a symmetric, positive definite matrix of two rows, such as a mass matrix."""
    share = 1.0 / (m11 * m22 - m12 * m12)
    return (m22 * f1 - m12 * f2) * share, (m11 * f2 - m12 * f1) * share


def _impact(after: Matrix, before: Matrix, q: Numbers, dq: Numbers) -> tuple[float, float]:
    """Rates, after an impact by which each leg becomes one body, of the swing leg and of the stance leg, rad/s.

    It is (J'FJ)^-1 J'F dq, with the weights of J'FJ and of J'F; see `mjbiped.robots.chain`.
    """
    m, p = _matrix(after, q, _ONES, _EVEN), _matrix(before, q, dq, _EVEN)
    if len(q) == 1:
        return 0.0, p[0][0] / m[0][0]
    if len(q) == 2:
        stance, swing = solve_pair(m[0][0], m[0][1], m[1][1], p[0][0] + p[0][1], p[1][0] + p[1][1])
        return swing, stance
    of_stance = p[0][0] + p[0][1] + p[0][2]
    of_swing = p[1][0] + p[1][1] + p[1][2] + p[2][0] + p[2][1] + p[2][2]
    m12, m22 = m[0][1] + m[0][2], m[1][1] + m[1][2] + m[2][1] + m[2][2]
    stance, swing = solve_pair(m[0][0], m12, m22, of_stance, of_swing)
    return swing, stance


def _matrix(weights: Matrix, q: Numbers, factors: Numbers, part: int) -> Matrix:
    """Weights_ij times the sine of q_i - q_j (part 0) or its cosine (part 1), times factor j."""
    if len(q) == 1:
        return (_row(weights[0], q[0], q, factors, part),)
    first, second = _row(weights[0], q[0], q, factors, part), _row(weights[1], q[1], q, factors, part)
    if len(q) == 2:
        return first, second
    return first, second, _row(weights[2], q[2], q, factors, part)


def _row(weights: Numbers, angle: float, q: Numbers, factors: Numbers, part: int) -> Numbers:
    """The row of `_matrix` of one angle."""
    first = weights[0] * sine_cosine(angle - q[0])[part] * factors[0]
    if len(q) == 1:
        return (first,)
    second = weights[1] * sine_cosine(angle - q[1])[part] * factors[1]
    if len(q) == 2:
        return first, second
    return first, second, weights[2] * sine_cosine(angle - q[2])[part] * factors[2]
