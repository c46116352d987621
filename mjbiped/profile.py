"""The ground's profile in plain numbers, for code that runs at every physics step, in plain Python or compiled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = Sequence[float] | NDArray[np.float64]


class Profile(NamedTuple):
    """A terrain's segments; see `mjbiped.Terrain`.

    Attributes:
        x: Where they start, m, ascending.
        z: Heights there, m.
        gradient: dz/dx.
    """

    x: Floats
    z: Floats
    gradient: Floats


def height_of(ground: Any, segment: int, x: float) -> float:
    """Height of a segment's line at x, m; the ground is a `Profile`, or holds at least its sequences."""
    return float(ground.z[segment] + ground.gradient[segment] * (x - ground.x[segment]))


def segment_under(profile: Profile, x: float) -> int:
    """Index of the segment at x, m; the first reaches backwards and the last forwards, NaN gives the last."""
    low, high = 1, len(profile.x)
    while low < high:
        middle = (low + high) // 2
        if x < profile.x[middle]:
            high = middle
        else:
            low = middle + 1
    return low - 1


def height_over(profile: Profile, x: float) -> float:
    """Height of the ground at x, m: `Terrain.height_at` where no object can be asked; NaN gives NaN."""
    return height_of(profile, segment_under(profile, x), x)
