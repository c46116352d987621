"""Times and impulses of pushes, the same in both engines, as functions of plain numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

from mjbiped.disturbances.chance import uniform
from mjbiped.numerics.blocks import Floats, numbers

_TIME, _SIGN = 1000, 1001  # channels of chance that no sensor has


class Pushes(NamedTuple):
    """The pushes of a walk, at given times or at random.

    Attributes:
        times: Times at which pushes begin, s.
        impulses: Impulse of each push, N s.
        listed: Number of these.
        duration: Duration of each push, s.
        size: Impulse of random pushes, N s.
        interval: Mean time between random pushes, s; 0: there are none.
        seed_low: Seed of random pushes.
        seed_high: The same.
    """

    times: Floats
    impulses: Floats
    listed: int
    duration: float
    size: float
    interval: float
    seed_low: int
    seed_high: int


def following(pushes: Pushes, number: int, after: float) -> tuple[float, float]:
    """Time at which a push begins (s), and its impulse (N s); the time is infinite after the last one.

    Args:
        pushes: The `Pushes` of the walk.
        number: Index of the push, from 0 on.
        after: End of the push before it, s.
    """
    if pushes.interval > 0.0:
        size = pushes.size if uniform(pushes, number, _SIGN) < 0.5 else -pushes.size
        return after - pushes.interval * math.log(uniform(pushes, number, _TIME)), size
    if number < pushes.listed:
        times, impulses = numbers(pushes.times, pushes.listed), numbers(pushes.impulses, pushes.listed)
        return float(times[number]), float(impulses[number])
    return math.inf, 0.0
