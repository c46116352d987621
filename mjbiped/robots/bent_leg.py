"""A leg that stands with its knee locked while it is bent, as after a touchdown with a bent knee.

It is one body, told by the angle of the line from its foot to the hip. What hangs at the hip moves as on a straight leg
of that line's length, so that M and C keep their form. Only the leg's own mass stands beside the line.
"""

from __future__ import annotations

import math

from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots.chain import Array


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


def stand_bent(
    weights: Array,
    moments: Array,
    flexion: float,
    free_weights: Array,
    free_moments: Array,
    reach: Array,
    locked_weights: Array,
    locked_moments: Array,
    locked_reach: Array,
    knee_before: Array,
) -> float:
    """Write what the flexion of the locked stance knee changes in the chains of three and of two segments.

    Args:
        weights: A of four segments.
        moments: b of four.
        flexion: Of the stance knee, rad.
        free_weights: A of three; changed, as all that follows.
        free_moments: b of three.
        reach: Levers of the swing foot of three, whose last two are those of its thigh and shank, m.
        locked_weights: A of two.
        locked_moments: b of two.
        locked_reach: Levers of two.
        knee_before: Weights of J'F of the knee strike.

    Returns:
        Moment of the stance leg's weight beside its line, N m: it turns the leg forward by that times cos(q_1 + slope).
    """
    length, lean = bent_leg(-reach[1], -reach[2], flexion)
    shank_sine, shank_cosine = math.sin(lean), math.cos(lean)
    thigh_sine, thigh_cosine = math.sin(lean - flexion), math.cos(lean - flexion)
    knee = math.cos(flexion)
    free_weights[0, 0] = (weights[0, 0] + weights[1, 0] * knee) + (weights[0, 1] * knee + weights[1, 1])
    for j in range(1, 3):
        free_weights[0, j] = weights[0, j + 1] * shank_cosine + weights[1, j + 1] * thigh_cosine
        free_weights[j, 0] = free_weights[0, j]
    free_moments[0] = moments[0] * shank_cosine + moments[1] * thigh_cosine
    reach[0] = locked_reach[0] = length
    locked_weights[0, 0], locked_moments[0] = free_weights[0, 0], free_moments[0]
    locked_weights[0, 1] = locked_weights[1, 0] = free_weights[0, 1] + free_weights[0, 2]
    for j in range(3):
        knee_before[0, j] = free_weights[0, j]
    knee_before[1, 0] = free_weights[1, 0] + free_weights[2, 0]
    return float(moments[0] * shank_sine + moments[1] * thigh_sine)


def force_beside(across: float, gravity: float, angle: float, rate: float, acceleration: float) -> tuple[float, float]:
    """What the mass of a bent stance leg beside its line adds to the force of the ground, forward and upward, N.

    Args:
        across: Of `stand_bent`, N m.
        gravity: m/s^2.
        angle: Of the line, from the vertical, rad.
        rate: rad/s.
        acceleration: rad/s^2.
    """
    sine, cosine = sine_cosine(angle)
    # as `ground_force` of a segment a right angle ahead
    forward = across / gravity * (-sine * acceleration - cosine * rate * rate)
    upward = across / gravity * (sine * rate * rate - cosine * acceleration)
    return forward, upward
