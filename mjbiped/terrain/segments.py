"""Straight segments of ground as users give them: validation, and their places along x."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TypeAlias

from mjbiped.errors import InputError, shown
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, entries

Segment: TypeAlias = tuple[float, float, float]
"""Length along the ground (m), slope (degrees, positive downhill) and step up at the start (m)."""

GROUND_FRICTION = 0.8
"""Coefficient of Coulomb friction of all walking ground."""

STEEPEST_SLOPE = math.atan(GROUND_FRICTION)
"""Smallest slope angle that the robot cannot stand on, rad."""

HIGHEST_STEP = domains.STEP.high
"""Greatest height of a vertical step up or down, m: half a leg of Table I."""

MOST_SEGMENTS = domains.SEGMENTS.high
"""Greatest number of segments of one terrain."""


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
    """Check segments, and return them as (length in m, slope in degrees, step in m) of plain floats."""
    rows = []
    given = entries(segments)
    if given is None:
        raise InputError(f"segments must be a list of (length_m, slope_deg, step_up_m), got {shown(segments)}")
    for k, segment in enumerate(given, start=1):
        values = entries(segment) or ()
        if len(values) not in (2, 3):
            raise InputError(f"segment {k} is {shown(segment)}; expected (length_m, slope_deg, step_up_m)")
        length = domains.STRETCH.check(f"segment {k}: length", values[0])
        slope = STANDABLE.check(f"segment {k}: slope", values[1])
        step = domains.STEP.check(f"segment {k}: step", (*values, 0.0)[2])
        rows.append((length, slope, step))
    if not rows:
        raise InputError("there are no segments; give at least one (length_m, slope_deg, step_up_m)")
    return rows


def chained(rows: Sequence[Segment]) -> tuple[list[float], list[float], list[float]]:
    """Place checked segments one after another from x = 0.

    Returns:
        The fields `x` (m), `z` (m) and `angle` (rad) of a terrain.
    """
    x, z, angles = [0.0], [rows[0][2]], [math.radians(rows[0][1])]
    for (length, _, _), (_, slope, step) in pairwise(rows):
        dx = length * math.cos(angles[-1])
        x.append(x[-1] + dx)
        # the same expression as in heights_before, so that no step is exactly no step
        z.append(z[-1] - math.tan(angles[-1]) * (x[-1] - x[-2]) + step)
        angles.append(math.radians(slope))
    return x, z, angles
