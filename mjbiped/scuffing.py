"""The scuffing rule: when a straight swing leg may touch the ground.

Straight legs of equal length must scuff: the swing foot of a passive walker passes below the ground from 8.6 cm behind
the stance foot until level with it, and is hardly above it for another 10 cm. The rule stands for a foot that is drawn
in during the early swing, as physical compass walkers do it, and is the same object in every engine. Results on
ascending steps depend on it: a riser nearer than `reach` is passed as if it were not there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mjbiped.errors import InputError


@dataclass(frozen=True)
class ScuffingRule:
    """The swing foot starts to collide, and keeps colliding until touchdown, at the first moment when all three hold.

    Attributes:
        reach: It is this far ahead of the stance foot, horizontally, in leg lengths.
        delay: This much time has passed since the leg exchange, s.
        name: For records; the third condition, that it is above the ground at its own place, has no parameter.
    """

    reach: float = 0.20
    delay: float = 0.1
    name: str = "drawn in until ahead"

    def __post_init__(self) -> None:
        """Refuse a reach or delay that is negative or not finite.

        Raises:
            InputError: One is.
        """
        for field, value in (("reach", self.reach), ("delay", self.delay)):
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"scuffing rule: {field} must be a finite number not below zero, got {value!r}")


def swing_foot_collides(reach: float, delay: float, time: float, ahead: float, clearance: float) -> bool:
    """Whether the rule lets the swing foot collide from now on.

    Args:
        reach: Distance ahead that the rule asks for, m (leg lengths times leg length).
        delay: Time since the leg exchange that it asks for, s.
        time: Time since the leg exchange, s.
        ahead: Horizontal distance of the swing foot ahead of the stance foot, m.
        clearance: Height of the swing foot over the ground at its own place, m.
    """
    return time > delay and ahead >= reach and clearance > 0.0
