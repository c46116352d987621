"""Re-planning, section IV-B of the paper: a Bézier curve of degree 5 from an off-track state back to the reference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.controller import Memory
from mjbiped.controllers.settings import REPLANNED, Gains
from mjbiped.gaits.reference import Table, reference_at, reference_discontinuity

POINTS = 6
"""Control points of one angle's curve."""

Motion: TypeAlias = tuple[float, float, float, float, float, float]
"""q (rad), its rates and its accelerations of stance and swing leg, stance leg first in each pair."""


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
    r"""Evaluate a transition curve and its derivatives.

    .. math:: q(u) = \sum_k \binom{5}{k} (1-u)^{5-k} u^k P_k, \quad u = t / t_c

    Args:
        points: Numbers with six control points from index `first` on, rad.
        first: Index of the first control point.
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


def begin_step(
    gains: Gains,
    memory: Memory,
    first: int,
    cycle: Sequence[float] | NDArray[np.float64],
    q: tuple[float, ...],
    dq: tuple[float, ...],
) -> bool:
    """Decide whether a step that starts off the limit cycle is re-planned, and lay curves that are added to the gait.

    Args:
        gains: Gains of the law.
        memory: Memory of the controller, which is changed in place.
        first: Index of the first angle's curve; the others follow.
        cycle: First state on the limit cycle, angles then rates.
        q: Angles now, rad.
        dq: Their rates, rad/s.

    Returns:
        Whether the caller must lay curves, by `lay`, that replace the gait until they reach it.
    """
    off = 0.0
    for index in range(len(q)):
        off = max(off, abs(q[index] - cycle[index]), abs(dq[index] - cycle[len(q) + index]))
    memory[REPLANNED] = 0.0
    if gains.transition_time == 0.0 or off <= gains.replanning_threshold:
        return False
    memory[REPLANNED] = 1.0
    if gains.additive:
        for index in range(len(q)):
            away, rate = q[index] - cycle[index], dq[index] - cycle[len(q) + index]
            lay(memory, first, index, transition(gains.transition_time, away, rate, 0.0, 0.0, 0.0, 0.0))
    return not gains.additive


def lay(memory: Memory, first: int, index: int, points: Motion) -> None:
    """Write the control points of one angle's curve into the memory, where `first` is the first angle's."""
    for point in range(POINTS):
        memory[first + POINTS * index + point] = points[point]


def legs_at(gains: Gains, memory: Memory, first: int, table: Table, t: float) -> Motion:
    """Reference of both legs at time t of the step: the transition's curves until they end, then the gait."""
    duration = gains.transition_time
    if memory[REPLANNED] == 0.0 or t >= duration:
        return reference_at(table, t)
    q1, dq1, ddq1 = transition_at(memory, first, duration, t)
    q2, dq2, ddq2 = transition_at(memory, first + POINTS, duration, t)
    if not gains.additive:
        return q1, q2, dq1, dq2, ddq1, ddq2
    gait = reference_at(table, t)
    return gait[0] + q1, gait[1] + q2, gait[2] + dq1, gait[3] + dq2, gait[4] + ddq1, gait[5] + ddq2


def discontinuity_after(gains: Gains, memory: Memory, table: Table, t: float) -> float:
    """The first time after t at which what is tracked has a kink, s: the transition's end, then the gait's."""
    if memory[REPLANNED] != 0.0 and t < gains.transition_time:
        return gains.transition_time
    return reference_discontinuity(table, t)
