"""Constraints on a linkage: a joint that is locked, and ground that holds the swing foot along its normal."""

from __future__ import annotations

from typing import Any

from mjbiped.robots.chain import solve


def settle(s: Any, size: int) -> None:
    """Turn the forces `s.force` into accelerations, or a momentum into rates; the last segments move as one.

    Args:
        s: The linkage, after `load` or `gather`; `s.matrix` is lost.
        size: Number of bodies that move by themselves: the last one is all segments from there on.
    """
    n, last = len(s.force), size - 1
    for i in range(size, n):
        s.force[last] += s.force[i]
        for j in range(n):
            s.matrix[last, j] += s.matrix[i, j]
    for j in range(size, n):
        for i in range(size):
            s.matrix[i, last] += s.matrix[i, j]
    solve(s.matrix[:size, :size], s.force[:size])
    for i in range(size, n):
        s.force[i] = s.force[last]


def press(s: Any, size: int, rest: float) -> float:
    """Let the ground hold the far end along its normal, without friction; returns the force, N, or the impulse, N s.

    Args:
        s: The linkage, after `load`, with accelerations in `s.motion`, or rates for an impulse; they are changed.
        size: As in `settle`.
        rest: Acceleration along the normal that the rates alone make, m/s^2; 0 in an impact.
    """
    n, last, along = len(s.force), len(s.mass), 0.0
    for i in range(n):
        s.force[i] = s.upward[last, i]
        rest += s.upward[last, i] * s.motion[i]
    settle(s, size)
    for i in range(n):
        along += s.upward[last, i] * s.force[i]
    force = -rest / along
    for i in range(n):
        s.motion[i] += force * s.force[i]
    return force
