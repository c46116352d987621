"""The ground's profile in plain numbers, for code that runs at every physics step, interpreted or compiled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from mjbiped.numerics.blocks import numbers

EDGE = 5e-5
"""Depth under the upper edge of a step up to which a foot stands on it, m."""

BESIDE = 1e-3
"""Distance inside a step up to which a deeper foot is beside its face, on the lower ground, m."""

OVER = 1e-6
"""Distance beyond the upper edge up to which a foot still stands on it, m: it moves a little in the impact."""


class Profile(NamedTuple):
    """A terrain's segments; see `mjbiped.Terrain`.

    Attributes:
        x: Starts of the segments, ascending, m.
        z: Heights at the starts, m.
        gradient: Gradients dz/dx of the segments.
        segments: Number of segments.
    """

    x: Sequence[float]
    z: Sequence[float]
    gradient: Sequence[float]
    segments: int


def height_of(ground: Any, segment: int, x: float) -> float:
    """Height of a segment's line at x, m; the ground is a `Profile`, or has its fields."""
    starts, heights = numbers(ground.x, ground.segments), numbers(ground.z, ground.segments)
    return float(heights[segment] + numbers(ground.gradient, ground.segments)[segment] * (x - starts[segment]))


def segment_under(profile: Any, x: float) -> int:
    """Index of the segment at x, m; the first reaches backwards and the last forwards, NaN gives the last."""
    starts = numbers(profile.x, profile.segments)
    low, high = 1, profile.segments
    while low < high:
        middle = (low + high) // 2
        if x < starts[middle]:
            high = middle
        else:
            low = middle + 1
    return low - 1


def segment_near(profile: Any, x: float, index: int) -> int:
    """Index of the segment at x, m, searched from a segment nearby."""
    starts = numbers(profile.x, profile.segments)
    while index + 1 < profile.segments and starts[index + 1] <= x:
        index += 1
    while index > 0 and starts[index] > x:
        index -= 1
    return index


def height_over(profile: object, x: float) -> float:
    """Height of the ground at x, m, like `Terrain.height_at`; NaN gives NaN."""
    return height_of(profile, segment_under(profile, x), x)


def segment_stood_on(
    ground: Any, x: float, z: float, edge: float = EDGE, beside: float = BESIDE, over: float = OVER
) -> int:
    """Index of the segment that a foot at x, z stands on, by one rule for all feet near a break.

    A foot is a point and stands on the segment under x. Only at a step its height decides as well: by a solver's
    residual, a foot that slides down a face, or stands on the very edge, may lie on the other side.

    Args:
        ground: A `Profile`, or an object with its fields.
        x: Position of the foot, m.
        z: Height of the foot, m.
        edge: See `EDGE`, m.
        beside: See `BESIDE`, m.
        over: See `OVER`, m.
    """
    here = segment_under(ground, x)
    height = z - height_of(ground, here, x)
    if -edge <= height <= edge:
        return here
    for there in (here - 1, here + 1):
        if 0 <= there < ground.segments:
            face = numbers(ground.x, ground.segments)[max(here, there)]
            away = abs(x - face)
            if away <= beside:
                drop = height_of(ground, here, face) - height_of(ground, there, face)
                if height < -edge and drop > edge:
                    return there
                if drop < 0.0 and away <= over and height + drop >= -edge:
                    return there
    return here


def segment_met(profile: object, x: float, z: float) -> int:
    """Index of the segment that a foot at x, z would land on, or that it slides down to along a vertical face."""
    return segment_stood_on(profile, x, z, EDGE, BESIDE, 0.0)


def height_over_ground(profile: object, x: float, z: float) -> float:
    """Height of a foot at x, z over the segment that it would land on, m; NaN gives NaN."""
    return z - height_of(profile, segment_met(profile, x, z), x)
