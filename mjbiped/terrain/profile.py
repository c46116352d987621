"""The ground's profile in plain numbers, and its straight segments as users give them.

Functions of a profile run at every physics step, interpreted or compiled.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple, TypeAlias

from mjbiped.errors import InputError, shown
from mjbiped.numerics.blocks import Block, numbers
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, entries

EDGE = 5e-5
"""Depth under the upper edge of a step up to which a foot stands on it, m."""

BESIDE = 1e-3
"""Distance inside a step up to which a deeper foot is beside its face, on the lower ground, m."""

OVER = 1e-6
"""Distance beyond the upper edge up to which a foot still stands on it, m: it moves a little in the impact."""

Segment: TypeAlias = tuple[float, float, float] | tuple[float, float, float, float]
"""Length along the ground (m), slope (degrees, positive downhill) and step up at the start (m); where it is not zero,
the slope across (degrees, positive down to the left)."""

GROUND_FRICTION = 0.8
"""Coefficient of Coulomb friction of all walking ground."""

STEEPEST_SLOPE = math.atan(GROUND_FRICTION)
"""Smallest slope angle that the robot cannot stand on, rad."""

HIGHEST_STEP = domains.STEP.high
"""Greatest height of a vertical step up or down, m: half a leg of Table I."""

MOST_SEGMENTS = domains.SEGMENTS.high
"""Greatest number of segments of one terrain."""


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


Ground: TypeAlias = Profile | Block
"""A profile, or what has its fields, as the constants of an engine."""


def height_of(ground: Ground, segment: int, x: float) -> float:
    """Height of a segment's line at x, m; the ground is a `Profile`, or has its fields."""
    starts, heights = numbers(ground.x, ground.segments), numbers(ground.z, ground.segments)
    return float(heights[segment] + numbers(ground.gradient, ground.segments)[segment] * (x - starts[segment]))


def segment_under(profile: Ground, x: float) -> int:
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


def segment_near(profile: Ground, x: float, index: int) -> int:
    """Index of the segment at x, m, searched from a segment nearby."""
    starts = numbers(profile.x, profile.segments)
    while index + 1 < profile.segments and starts[index + 1] <= x:
        index += 1
    while index > 0 and starts[index] > x:
        index -= 1
    return index


def height_over(profile: Ground, x: float) -> float:
    """Height of the ground at x, m, like `Terrain.height_at`; NaN gives NaN."""
    return height_of(profile, segment_under(profile, x), x)


def segment_stood_on(
    ground: Ground, x: float, z: float, edge: float = EDGE, beside: float = BESIDE, over: float = OVER
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


def segment_met(profile: Ground, x: float, z: float) -> int:
    """Index of the segment that a foot at x, z would land on, or that it slides down to along a vertical face."""
    return segment_stood_on(profile, x, z, EDGE, BESIDE, 0.0)


def height_over_ground(profile: Ground, x: float, z: float) -> float:
    """Height of a foot at x, z over the segment that it would land on, m; NaN gives NaN."""
    return z - height_of(profile, segment_met(profile, x, z), x)


def check_slope(where: str, angle: float) -> None:
    """Refuse a slope (rad) that cannot be stood on."""
    if not abs(angle) < STEEPEST_SLOPE:
        raise InputError(
            f"{where}: a slope of {math.degrees(angle):.4g} degrees is steeper than the robot can stand on at friction "
            f"{GROUND_FRICTION:g}; expected less than {math.degrees(STEEPEST_SLOPE):.1f} degrees up or down"
        )


class _Standable(Domain):
    """Slopes that the robot can stand on, degrees."""

    def check(self, name: str, value: object) -> float:
        """Check a slope, and return it as a plain float."""
        slope = super().check(name, value)
        check_slope(name.partition(",")[0], math.radians(slope))  # without the end of an interval
        return slope


STANDABLE = _Standable(domains.SLOPE_DEG.low, domains.SLOPE_DEG.high, domains.SLOPE_DEG.unit)
"""Slopes that the robot can stand on, degrees."""


def checked_segments(segments: Iterable[object]) -> list[Segment]:
    """Check segments, and return them as plain floats; see `Segment`."""
    rows: list[Segment] = []
    given = entries(segments)
    if given is None:
        raise InputError(f"segments must be a list of (length_m, slope_deg, step_up_m), got {shown(segments)}")
    for k, segment in enumerate(given, start=1):
        values = entries(segment) or ()
        if len(values) not in (2, 3, 4):
            raise InputError(f"segment {k} is {shown(segment)}; expected (length_m, slope_deg, step_up_m, lateral_deg)")
        length = domains.STRETCH.check(f"segment {k}: length", values[0])
        slope = STANDABLE.check(f"segment {k}: slope", values[1])
        step = domains.STEP.check(f"segment {k}: step", (*values, 0.0)[2])
        lateral = STANDABLE.check(f"segment {k}: lateral slope", (*values, 0.0, 0.0)[3])
        rows.append((length, slope, step, lateral) if lateral else (length, slope, step))
    if not rows:
        raise InputError("there are no segments; give at least one (length_m, slope_deg, step_up_m)")
    return rows


def chained(rows: Sequence[Segment]) -> tuple[list[float], list[float], list[float]]:
    """Place checked segments one after another from x = 0.

    Returns:
        The fields `x` (m), `z` (m) and `angle` (rad) of a terrain.
    """
    x, z, angles = [0.0], [rows[0][2]], [math.radians(rows[0][1])]
    for (length, *_), (_, slope, step, *_) in pairwise(rows):
        dx = length * math.cos(angles[-1])
        x.append(x[-1] + dx)
        # the same expression as in heights_before, so that no step is exactly no step
        z.append(z[-1] - math.tan(angles[-1]) * (x[-1] - x[-2]) + step)
        angles.append(math.radians(slope))
    return x, z, angles
