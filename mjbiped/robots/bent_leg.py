"""A leg that stands with its knee locked while it is bent, as after a touchdown with a bent knee.

It is one body, told by the angle of the line from its foot to the hip. What hangs at the hip moves as on a straight leg
of that line's length; only the leg's own mass stands beside the line.
"""

from __future__ import annotations

import math


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
