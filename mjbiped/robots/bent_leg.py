"""A leg that stands with its knee locked while it is bent, as after a touchdown with a bent knee.

It is one body, told by the angle of the line from its foot to the hip. What hangs at the hip moves as on a straight leg
of that line's length, so that M and C keep their form. Only the leg's own mass stands beside the line.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots.chain import Array, segment_force

FLEXION, LEAN, ACROSS, LENGTH = 0, 1, 2, 3  # indices of what tells how a leg stands


def straight_leg(length: float) -> Array:
    """How a straight leg of a length (m) stands, as `stand` writes it."""
    return np.array([0.0, 0.0, 0.0, length])


def bent_leg(upper: float, lower: float, flexion: float) -> tuple[float, float]:
    """A leg whose knee is bent: its length from foot to hip, and how far its shank leans forward of that line.

    A leg that stands bent is told by the angle of the line from its foot to the hip. Its shank's angle is that plus the
    lean, its thigh's that plus the lean less the flexion.

    Args:
        upper: Length of the thigh, m.
        lower: Length of the shank, m.
        flexion: Of the knee, rad.

    Returns:
        Length, m, and lean, rad.
    """
    along, across = lower + upper * math.cos(flexion), upper * math.sin(flexion)
    # hypot has other last bits compiled
    return math.sqrt(along * along + across * across), math.atan2(across, along)


def stand(standing: Array, flexion: float, whole: Any, free: Any, locked: Any) -> None:
    """Write what the flexion of the locked stance knee changes in the chains of three and of two segments.

    Args:
        standing: Flexion and lean of the shank (rad), the moment of the leg's weight beside its line (N m), and the
            length of that line (m), at the indices above; changed.
        flexion: Of the stance knee from now on, rad.
        whole: The chain of four segments, with the arrays of `mjbiped.robots.chain.Chain`.
        free: That of three, whose last two levers of the swing foot are those of its thigh and shank; changed.
        locked: That of two; changed.
    """
    length, lean = bent_leg(-free.reach[1], -free.reach[2], flexion)
    shank_sine, shank_cosine = math.sin(lean), math.cos(lean)
    thigh_sine, thigh_cosine = math.sin(lean - flexion), math.cos(lean - flexion)
    knee, weights, moments = math.cos(flexion), whole.weights, whole.moments
    standing[FLEXION], standing[LEAN], standing[LENGTH] = flexion, lean, length
    standing[ACROSS] = moments[0] * shank_sine + moments[1] * thigh_sine
    free.weights[0, 0] = (weights[0, 0] + weights[1, 0] * knee) + (weights[0, 1] * knee + weights[1, 1])
    for j in range(1, 3):
        free.weights[0, j] = weights[0, j + 1] * shank_cosine + weights[1, j + 1] * thigh_cosine
        free.weights[j, 0] = free.weights[0, j]
    free.moments[0] = moments[0] * shank_cosine + moments[1] * thigh_cosine
    free.reach[0] = locked.reach[0] = length
    locked.weights[0, 0], locked.moments[0] = free.weights[0, 0], free.moments[0]
    locked.weights[0, 1] = locked.weights[1, 0] = free.weights[0, 1] + free.weights[0, 2]


def gravity_beside(across: float, angle: float, sin_slope: float, cos_slope: float) -> float:
    r"""What the mass of a bent stance leg beside its line adds to that leg's generalised gravity, N m.

    .. math:: -a \cos(q_1 + \varphi)

    Args:
        across: Moment of the leg's weight beside its line, a, N m.
        angle: Of the line from the ground's normal, q_1, rad.
        sin_slope: Sine of the ground's slope, or what is taken for it.
        cos_slope: Its cosine, likewise.
    """
    sine, cosine = sine_cosine(angle)
    return across * (sine * sin_slope - cosine * cos_slope)


def force_beside(across: float, gravity: float, angle: float, rate: float, acceleration: float) -> tuple[float, float]:
    """What the mass of a bent stance leg beside its line adds to the force of the ground, forward and upward, N.

    Args:
        across: Moment of the leg's weight beside its line, N m.
        gravity: m/s^2.
        angle: Of the line, from the vertical, rad.
        rate: rad/s.
        acceleration: rad/s^2.
    """
    sine, cosine = sine_cosine(angle)
    # of a segment a right angle ahead
    ahead, above = segment_force(across / gravity, cosine, -sine, rate, acceleration)
    return ahead, above
