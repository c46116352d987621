r"""Equations of motion of a chain of two or three segments for control laws; `layout` says what stands where.

Unit vectors e_i along the segments, with x forward along the ground and z along its normal, have the accelerations

.. math:: \\ddot e_i = (c_i \\ddot q_i - s_i \\dot q_i^2, \\; -s_i \\ddot q_i - c_i \\dot q_i^2)

With these, A and b of `mjbiped.robots.chain`, and gravity on a slope, the generalised forces of (1) are

.. math:: f_i = c_i [\\sum_j A_{ij} \\ddot e_{jx} - b_i \\sin\\varphi]
                - s_i [\\sum_j A_{ij} \\ddot e_{jz} + b_i \\cos\\varphi]

The centre of mass of a bent stance leg lies beside the line from foot to hip; its moment is added to gravity's.

Sums over the segments are written without loops, which are slow in plain Python; straight legs skip the third segment.
"""

from __future__ import annotations

from mjbiped.control.controller import Numbers, Room
from mjbiped.controllers.room import COSINE, DQ, FORCE, FORWARD, SINE, UPWARD, Q
from mjbiped.numerics.trigonometry import sine_cosine


def observe(n: int, q: Numbers, dq: Numbers, room: Room) -> None:
    """Write angles (rad) and rates (rad/s) of n segments into the room, with the angles' sines and cosines."""
    _observe(0, q, dq, room)
    _observe(1, q, dq, room)
    if n > 2:
        _observe(2, q, dq, room)


def _observe(i: int, q: Numbers, dq: Numbers, room: Room) -> None:
    """Write the state of one segment into the room."""
    angle = q[i]
    room[Q + i], room[DQ + i] = angle, dq[i]
    room[SINE + i], room[COSINE + i] = sine_cosine(angle)


def move_end(i: int, ddq: float, room: Room) -> None:
    """Write the acceleration of the end of the unit vector along segment i, 1/s², from its ddq (rad/s²)."""
    s, c, rate = room[SINE + i], room[COSINE + i], room[DQ + i]
    square = rate * rate
    room[FORWARD + i] = c * ddq - s * square
    room[UPWARD + i] = -s * ddq - c * square


def inverse_dynamics(chain: Numbers, first: int, n: int, slope: tuple[float, float], room: Room) -> None:
    """Write the generalised forces M ddq + C dq + g of (1), N m, that make the accelerations of the segments' ends.

    Args:
        chain: Numbers among which the chain stands; see `layout.chain_block`.
        first: Index at which it begins.
        n: Number of segments.
        slope: Sine and cosine of the ground's slope, or their estimates.
        room: Has the state, and accelerations as `move_end` writes them; receives the forces.
    """
    moments = first + n * n
    _force(chain, first, chain[moments], n, slope, 0, room)
    _force(chain, first + n, chain[moments + 1], n, slope, 1, room)
    if n > 2:
        _force(chain, first + 2 * n, chain[moments + 2], n, slope, 2, room)
    beside = chain[moments + n]
    if beside != 0.0:
        room[FORCE] += beside * (room[SINE] * slope[0] - room[COSINE] * slope[1])


def _force(chain: Numbers, row: int, moment: float, n: int, slope: tuple[float, float], i: int, room: Room) -> None:
    """Write the generalised force on segment i, N m; `row` is the index at which the segment's row of A begins."""
    forward = chain[row] * room[FORWARD] + chain[row + 1] * room[FORWARD + 1] - moment * slope[0]
    upward = chain[row] * room[UPWARD] + chain[row + 1] * room[UPWARD + 1] + moment * slope[1]
    if n > 2:
        forward += chain[row + 2] * room[FORWARD + 2]
        upward += chain[row + 2] * room[UPWARD + 2]
    room[FORCE + i] = room[COSINE + i] * forward - room[SINE + i] * upward


def masses(chain: Numbers, first: int, n: int, room: Numbers) -> tuple[float, float, float, float, float, float]:
    """Return m11, m12, m22, m13, m23, m33 of M of (1), A_ij cos(q_i - q_j), kg m²; the last three are 0 for two legs.

    The arguments are those of `inverse_dynamics`.
    """
    s1, c1, s2, c2 = room[SINE], room[COSINE], room[SINE + 1], room[COSINE + 1]
    m11, m12, m22 = chain[first], chain[first + 1] * (c1 * c2 + s1 * s2), chain[first + n + 1]
    if n == 2:
        return m11, m12, m22, 0.0, 0.0, 0.0
    s3, c3 = room[SINE + 2], room[COSINE + 2]
    m13, m23 = chain[first + 2] * (c1 * c3 + s1 * s3), chain[first + 5] * (c2 * c3 + s2 * s3)
    return m11, m12, m22, m13, m23, chain[first + 8]


def solve(chain: Numbers, first: int, n: int, room: Numbers, right: int) -> tuple[float, float, float]:
    """Return M^-1 times the n numbers at index `right` of the room; other arguments as for `inverse_dynamics`."""
    m11, m12, m22, m13, m23, m33 = masses(chain, first, n, room)
    f1, f2, f3, share1, share2 = room[right], room[right + 1], 0.0, 0.0, 0.0
    if n > 2:  # the third row first: without it straight legs remain
        f3, share1, share2 = room[right + 2] / m33, m13 / m33, m23 / m33
        f1, f2 = f1 - m13 * f3, f2 - m23 * f3
        m11, m12, m22 = m11 - share1 * m13, m12 - share1 * m23, m22 - share2 * m23
    scale = 1.0 / (m11 * m22 - m12 * m12)
    w1, w2 = (m22 * f1 - m12 * f2) * scale, (m11 * f2 - m12 * f1) * scale
    return w1, w2, f3 - share1 * w1 - share2 * w2


def write_torques(n: int, room: Numbers, out: Room, place: int) -> None:
    """Write the torques that make the generalised forces in the room, B^-1 f: ankle, hip, swing knee, N m."""
    knee = 0.0
    if n > 2:
        out[place + 2] = knee = room[FORCE + 2]
    hip = room[FORCE + 1] + knee
    out[place], out[place + 1] = room[FORCE] + hip, hip
