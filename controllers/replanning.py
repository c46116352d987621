"""Re-planning, section IV-B of the paper: a Bézier curve of degree 5 from an off-track state back to the reference."""

from __future__ import annotations

from collections.abc import Sequence


def transition(
    duration: float, q: float, dq: float, ddq: float, q_end: float, dq_end: float, ddq_end: float
) -> tuple[float, float, float, float, float, float]:
    """Control points of one leg's transition curve.

    A curve of degree 5 has as many control points as there are conditions: position, rate and acceleration at both
    ends.

    Args:
        duration: t_c = zeta T, s.
        q: Angle at the start, rad.
        dq: Its rate, rad/s.
        ddq: Its acceleration, rad/s².
        q_end: Angle at the end, rad.
        dq_end: Its rate, rad/s.
        ddq_end: Its acceleration, rad/s².

    Returns:
        Six control points, rad.
    """
    p1 = q + dq * duration / 5.0
    p2 = 2.0 * p1 - q + ddq * duration * duration / 20.0
    p4 = q_end - dq_end * duration / 5.0
    p3 = 2.0 * p4 - q_end + ddq_end * duration * duration / 20.0
    return q, p1, p2, p3, p4, q_end


def transition_at(points: Sequence[float], first: int, duration: float, t: float) -> tuple[float, float, float]:
    r"""A transition curve and its derivatives.

    .. math:: q(u) = \sum_k \binom{5}{k} (1-u)^{5-k} u^k P_k, \quad u = t / t_c

    Args:
        points: Holds six control points from index `first` on, rad.
        first: Place of the first of them.
        duration: t_c, s.
        t: Time since the support transfer, s, in [0, t_c].

    Returns:
        Angle (rad), rate (rad/s), acceleration (rad/s²).
    """
    p0, p1, p2 = points[first], points[first + 1], points[first + 2]
    p3, p4, p5 = points[first + 3], points[first + 4], points[first + 5]
    rate = 1.0 / duration
    u = t * rate
    v = 1.0 - u
    # control points of the first and second derivative's curves
    d0, d1, d2, d3, d4 = p1 - p0, p2 - p1, p3 - p2, p4 - p3, p5 - p4
    e0, e1, e2, e3 = d1 - d0, d2 - d1, d3 - d2, d4 - d3
    u2, v2 = u * u, v * v
    u3, v3 = u2 * u, v2 * v
    q = v3 * v2 * p0 + u3 * u2 * p5 + 5.0 * u * v * (v3 * p1 + u3 * p4) + 10.0 * u2 * v2 * (v * p2 + u * p3)
    dq = v2 * v2 * d0 + u2 * u2 * d4 + 4.0 * u * v * (v2 * d1 + u2 * d3) + 6.0 * u2 * v2 * d2
    ddq = v3 * e0 + u3 * e3 + 3.0 * u * v * (v * e1 + u * e2)
    return q, 5.0 * rate * dq, 20.0 * rate * rate * ddq
