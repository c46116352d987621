"""Re-planning, section IV-B of the paper: a Bézier curve of degree 5 from an off-track state back to the reference."""

from __future__ import annotations

import math

from mjbiped.control.controller import Memory, Numbers, Room
from mjbiped.controllers.dynamics import inverse_dynamics, move_end, observe, solve
from mjbiped.controllers.layout import (
    ADDITIVE,
    BENT_TABLE,
    CYCLE,
    IMITATED_SLOPE,
    KNEE_BUMP,
    KNEE_BUMP_PER_STEP,
    REPLANNING_THRESHOLD,
    SEGMENTS,
    TRANSITION_TIME,
    gait_of,
    moving_chain,
    table_of_step,
)
from mjbiped.controllers.room import ANGLES, BUMP, CURVES, FORCE, LOCKED, POINTS, REFERENCE, REPLANNED
from mjbiped.gaits.reference import reference_at, reference_discontinuity


def transition(
    duration: float, start: tuple[float, float, float], end: tuple[float, float, float]
) -> tuple[float, float, float, float, float, float]:
    """Return the control points of one angle's transition curve, rad.

    A curve of degree 5 has as many control points as there are conditions: position, rate and acceleration at both
    ends.

    Args:
        duration: t_c = zeta T, s.
        start: Angle (rad), rate (rad/s) and acceleration (rad/s²) at the start.
        end: Angle, rate and acceleration at the end.
    """
    q, dq, ddq = start
    q_end, dq_end, ddq_end = end
    p1 = q + dq * duration / 5.0
    p2 = 2.0 * p1 - q + ddq * duration * duration / 20.0
    p4 = q_end - dq_end * duration / 5.0
    p3 = 2.0 * p4 - q_end + ddq_end * duration * duration / 20.0
    return q, p1, p2, p3, p4, q_end


def transition_at(points: Numbers, first: int, duration: float, t: float) -> tuple[float, float, float]:
    r"""Return angle (rad), rate (rad/s) and acceleration (rad/s²) of a transition curve.

    .. math:: q(u) = \sum_k \binom{5}{k} (1-u)^{5-k} u^k P_k, \quad u = t / t_c

    Args:
        points: Numbers with six control points from index `first` on, rad.
        first: Index of the first control point.
        duration: t_c, s.
        t: Time since the support transfer, s, in [0, t_c].
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


def bump_at(height: float, duration: float, t: float) -> tuple[float, float, float]:
    r"""Return the flexion that is added to the shank's curve, rad, with its rate and acceleration: zero at both ends.

    .. math:: 64 A u^3 (1 - u)^3, \quad u = t / t_c

    Args:
        height: A, rad.
        duration: t_c, s.
        t: Time since the support transfer, s.
    """
    u, rate = t / duration, 1.0 / duration
    v = 1.0 - u
    product, change = u * v, v - u
    whole = 64.0 * height * product
    return (
        whole * product * product,
        3.0 * whole * product * change * rate,
        6.0 * whole * (change * change - product) * rate * rate,
    )


def reference(parameters: Numbers, memory: Numbers, t: float, n: int, room: Room) -> None:
    """Write what n angles track at time t of the step: the transition's curves until they end, then the gait."""
    gait = gait_of(parameters, memory)
    duration = parameters[gait + TRANSITION_TIME]
    additive, in_transition = parameters[ADDITIVE] != 0.0, memory[REPLANNED] != 0.0 and t < duration
    if additive or not in_transition:
        reference_at(parameters, table_of_step(parameters, memory, gait), t, room, REFERENCE)
        if not in_transition:
            return
    for i in range(n):
        q, dq, ddq = transition_at(memory, CURVES + POINTS * i, duration, t)
        if i == 2:
            more = bump_at(memory[BUMP], duration, t)
            q, dq, ddq = q + more[0], dq + more[1], ddq + more[2]
        if additive:
            q, dq = room[REFERENCE + i] + q, room[REFERENCE + ANGLES + i] + dq
            ddq += room[REFERENCE + 2 * ANGLES + i]
        room[REFERENCE + i], room[REFERENCE + ANGLES + i], room[REFERENCE + 2 * ANGLES + i] = q, dq, ddq


def next_discontinuity(parameters: Numbers, memory: Numbers, t: float) -> float:
    """Return the first time after t at which what is tracked has a kink, s: the transition's end, then the gait's."""
    gait = gait_of(parameters, memory)
    duration = parameters[gait + TRANSITION_TIME]
    if memory[REPLANNED] != 0.0 and t < duration:
        return duration
    return reference_discontinuity(parameters, table_of_step(parameters, memory, gait), t)


def plan(parameters: Numbers, memory: Memory, rise: float, q: Numbers, dq: Numbers) -> None:
    """Begin a step, and lay transition curves if it starts off the limit cycle.

    Args:
        parameters: Of the law.
        memory: Of the controller, to be changed.
        rise: How much higher the new foothold is than the old one, m.
        q: Angles after the touchdown, rad.
        dq: Rates after it, rad/s.
    """
    memory[LOCKED] = memory[REPLANNED] = 0.0
    n, gait = int(parameters[SEGMENTS]), gait_of(parameters, memory)
    duration, cycle = parameters[gait + TRANSITION_TIME], gait + CYCLE
    off = 0.0
    for i in range(n):
        off = max(off, abs(q[i] - parameters[cycle + i]), abs(dq[i] - parameters[cycle + n + i]))
    if duration == 0.0 or off <= parameters[REPLANNING_THRESHOLD]:
        return
    memory[REPLANNED] = 1.0
    memory[BUMP] = parameters[KNEE_BUMP_PER_STEP] * abs(rise)
    if parameters[ADDITIVE] != 0.0:
        for i in range(n):
            away, rate = q[i] - parameters[cycle + i], dq[i] - parameters[cycle + n + i]
            lay(memory, i, transition(duration, (away, rate, 0.0), (0.0, 0.0, 0.0)))
        return
    memory[BUMP] += parameters[KNEE_BUMP]
    # the curve leaves the measured state with the acceleration that the imitated passive walker would have there
    falling = fall(parameters, memory, parameters[gait + IMITATED_SLOPE], q, dq)
    reference_at(parameters, int(parameters[gait + BENT_TABLE]), duration, memory, REFERENCE)
    for i in range(n):
        at = REFERENCE + i
        end = memory[at], memory[at + ANGLES], memory[at + 2 * ANGLES]
        lay(memory, i, transition(duration, (q[i], dq[i], -falling[i]), end))


def fall(parameters: Numbers, memory: Memory, slope: float, q: Numbers, dq: Numbers) -> tuple[float, float, float]:
    """Return the accelerations M^-1 (C dq + g), times -1 those of a passive walker on a slope (rad), rad/s²."""
    n, chain, first = moving_chain(parameters, memory)
    observe(n, q, dq, memory)
    for i in range(n):
        move_end(i, 0.0, memory)
    inverse_dynamics(chain, first, n, (math.sin(slope), math.cos(slope)), memory)
    return solve(chain, first, n, memory, FORCE)


def lay(memory: Memory, index: int, points: tuple[float, float, float, float, float, float]) -> None:
    """Write the control points of one angle's curve, rad, into the memory."""
    for point in range(POINTS):
        memory[CURVES + POINTS * index + point] = points[point]
