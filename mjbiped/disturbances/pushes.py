"""Times and impulses of pushes, the same in both engines, as functions of plain numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.chance import Seed, uniform

_TIME, _SIGN = 1000, 1001  # channels of chance that no sensor has


class Pushes(NamedTuple):
    """The pushes of a walk, at given times or at random.

    Attributes:
        times: Times at which pushes begin, s.
        impulses: Impulse of each push, N s.
        duration: Duration of each push, s.
        size: Impulse of random pushes, N s.
        interval: Mean time between random pushes, s; 0: there are none.
        seed: Seed of random pushes.
    """

    times: NDArray[np.float64]
    impulses: NDArray[np.float64]
    duration: float
    size: float
    interval: float
    seed: Seed


NONE = Pushes(np.zeros(0), np.zeros(0), 1.0, 0.0, 0.0, (0, 0))
"""No pushes."""


def following(pushes: Pushes, number: int, after: float) -> tuple[float, float]:
    """Time at which a push begins (s), and its impulse (N s); the time is infinite after the last one.

    Args:
        pushes: The pushes of the walk.
        number: Index of the push, from 0 on.
        after: End of the push before it, s.
    """
    if pushes.interval > 0.0:
        size = pushes.size if uniform(pushes.seed, number, _SIGN) < 0.5 else -pushes.size
        return after - pushes.interval * math.log(uniform(pushes.seed, number, _TIME)), size
    if number < len(pushes.times):
        return float(pushes.times[number]), float(pushes.impulses[number])
    return math.inf, 0.0
