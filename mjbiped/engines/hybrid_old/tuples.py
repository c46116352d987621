"""Postures as tuples, for a number of angles: functions without loops, written out as Python source.

Numba needs to know the length of a tuple, which a loop does not tell it; in plain Python the functions are faster too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, NamedTuple

from mjbiped.numerics.trigonometry import sine_cosine


class Tuples(NamedTuple):
    """The functions for states of some angles, their rates, a controller's states and the works of some joints.

    Attributes:
        q: (state) -> angles, rad.
        dq: (state) -> their rates, rad/s.
        own: (what a law returns) -> rates of the controller's states, which stand behind the torques.
        with_ankle: (what a law returns, torque) -> the same with another first torque.
        still: (state) -> as many zeros as there are angles.
        powers: (torques, dq) -> power of each joint, W: the first moves the first segment, the others turn two segments
            against each other.
        pose: (q, slope) -> sine and cosine of each angle from the vertical, and at last the first angle.
        told: (q) -> the angles that a law is told: from the normal of the stance foot's sole, where that tips.
        told_rates: (dq) -> their absolute rates, as gyros tell them.
        sole_slope: (slope, q) -> slope of the stance foot's sole, rad, on ground of a slope.
        reached: (along, beside, pose) -> place x, z of the point with these levers along the segments, and a right
            angle ahead of them, m.
    """

    q: Callable[..., Any]
    dq: Callable[..., Any]
    own: Callable[..., Any]
    with_ankle: Callable[..., Any]
    still: Callable[..., Any]
    powers: Callable[..., Any]
    pose: Callable[..., Any]
    told: Callable[..., Any]
    told_rates: Callable[..., Any]
    sole_slope: Callable[..., Any]
    reached: Callable[..., Any]


@cache
def tuples_of(angles: int, joints: int, own: int, tips: bool = False) -> Tuples:
    """The functions.

    Args:
        angles: Number of the angles of the robot's equations.
        joints: Number of its joints.
        own: Number of the controller's integrated states.
        tips: Whether the last angle is that of a stance foot which can tip, and on which the first joint acts.
    """
    foot = angles - 1
    every, others = range(angles), range(1, joints + own)
    pose = [f"    sine_{i}, cosine_{i} = sine_cosine(q[{i}] + slope)" for i in every]
    legs, pivot = (range(foot), foot) if tips else (every, -1)
    source = [
        f"def q(state):\n    return {_tuple(f'state[{i}]' for i in every)}",
        f"def dq(state):\n    return {_tuple(f'state[{angles + i}]' for i in every)}",
        f"def own(given):\n    return {_tuple(f'given[{joints + i}]' for i in range(own))}",
        f"def with_ankle(given, ankle):\n    return {_tuple(['ankle', *(f'given[{i}]' for i in others)])}",
        f"def still(state):\n    return {_tuple('0.0' for _ in every)}",
        f"def powers(torque, dq):\n    return {_tuple(f'torque[{i}] * {_turning(i, pivot)}' for i in range(joints))}",
        "\n".join(
            ["def pose(q, slope):", *pose, f"    return {_tuple([*(f'sine_{i}, cosine_{i}' for i in every), 'q[0]'])}"]
        ),
        f"def told(q):\n    return {_tuple(f'q[{i}] - q[{foot}]' for i in legs) if tips else 'q'}",
        f"def told_rates(dq):\n    return {_tuple(f'dq[{i}]' for i in legs) if tips else 'dq'}",
        f"def sole_slope(slope, q):\n    return {f'slope + q[{foot}]' if tips else 'slope'}",
        f"def reached(along, beside, pose):\n    return {_sum(every, 0, '+')}, {_sum(every, 1, '-')}",
    ]
    space: dict[str, Any] = {"__name__": __name__, "sine_cosine": sine_cosine}
    exec("\n".join(source), space)
    return Tuples(*(space[name] for name in Tuples._fields))


def _tuple(items: Iterable[str]) -> str:
    return f"({''.join(f'{item}, ' for item in items)})"


def _turning(joint: int, foot: int) -> str:
    if joint == 0:
        return "dq[0]" if foot < 0 else f"(dq[0] - dq[{foot}])"
    return f"(dq[{joint}] - dq[{joint - 1}])"


def _sum(every: range, part: int, sign: str) -> str:
    return " + ".join(f"along[{i}] * pose[{2 * i + part}] {sign} beside[{i}] * pose[{2 * i + 1 - part}]" for i in every)
