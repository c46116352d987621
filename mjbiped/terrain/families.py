"""Families of random ground: treads with random steps, waves of a band of lengths, stretches of a record."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from mjbiped.terrain.segments import Segment

START = 2.0
"""Length of the level and smooth ground at the start, m: the first steps are the same everywhere."""

GROWN = 3.0
"""Distance, in longest waves, in which heights grow to 95 % of their final size: 1 - exp(-3)."""

_WAVES = 64  # of band-limited ground; their sum is nearly normal


def tread_rows(
    seed: int, length: float, tread: float, deviation: float, slope_deg: tuple[float, float]
) -> list[Segment]:
    """Draw segments of treads, each with a slope of its own and a step at its start.

    Args:
        seed: Seed of the generator.
        length: Length of the ground along itself, m.
        tread: Depth of a tread, m.
        deviation: Standard deviation of the normally distributed steps, m.
        slope_deg: Range of the uniformly distributed slopes, degrees.
    """
    draw = np.random.Generator(np.random.PCG64(seed))
    count = max(1, math.ceil((length - START) / tread))
    drawn = ((draw.uniform(*slope_deg), deviation * draw.standard_normal()) for _ in range(count))
    return [(START, 0.0, 0.0), *((tread, float(slope), float(step)) for slope, step in drawn)]


def wave_rows(
    seed: int, length: float, deviation: float, shortest: float, longest: float, spacing: float
) -> list[Segment]:
    """Draw segments along a sum of waves whose wave numbers are uniformly distributed in a band.

    Args:
        seed: Seed of the generator.
        length: Length of the ground along x, m.
        deviation: Standard deviation of the heights, m.
        shortest: Shortest wave, m.
        longest: Longest wave, m.
        spacing: Distance between the points that straight segments join, m.
    """
    draw = np.random.Generator(np.random.PCG64(seed))
    numbers = 2.0 * math.pi * draw.uniform(1.0 / longest, 1.0 / shortest, _WAVES)
    phases = draw.uniform(0.0, 2.0 * math.pi, _WAVES)
    x = np.arange(max(1, math.ceil((length - START) / spacing)) + 1) * spacing
    heights = math.sqrt(2.0 / _WAVES) * deviation * np.sin(numbers * x[:, None] + phases).sum(axis=1)
    rises = np.diff(heights * (1.0 - np.exp(-x / longest)))  # the ground leaves the start without a step
    return [
        (START, 0.0, 0.0),
        *((math.hypot(spacing, rise), math.degrees(math.atan2(-rise, spacing)), 0.0) for rise in rises.tolist()),
    ]


def recorded_rows(seed: int, length: float, x: Sequence[float], z: Sequence[float]) -> list[Segment]:
    """Draw a stretch of a recorded profile: it begins anywhere and goes in either direction.

    The straight line that fits the samples best is taken away. The record is thought to go on mirrored at both ends,
    to and fro; a stretch begins at a place that is uniformly distributed over once there and back, so its direction is
    random as well.

    Args:
        seed: Seed of the generator.
        length: Length of the ground along x, m.
        x: Places of the samples, ascending, m; a place that occurs twice is a vertical step, but not at the ends.
        z: Heights of the samples, m.
    """
    places, heights = np.array(x) - x[0], np.array(z)
    heights -= np.polyval(np.polyfit(places, heights, 1), places)
    once = float(places[-1])
    places, heights = np.append(places, 2.0 * once - places[-2::-1]), np.append(heights, heights[-2::-1])
    first = float(np.random.Generator(np.random.PCG64(seed)).uniform(0.0, 2.0 * once))
    last = first + max(length - START, 0.0)
    rounds = [2.0 * once * k for k in range(math.ceil(last / (2.0 * once)))]
    places = np.concatenate([places[:-1] + passed for passed in rounds])  # the last sample is the next round's first
    heights = np.tile(heights[:-1], len(rounds))
    inside = (places > first) & (places < last)
    ends = np.interp((first, last), (*places, 2.0 * once * len(rounds)), (*heights, heights[0]))
    points = zip((first, *places[inside], last), (ends[0], *heights[inside], ends[1]), strict=True)
    return [(START, 0.0, 0.0), *_pieces([(float(place), float(height)) for place, height in points])]


def _pieces(points: Sequence[tuple[float, float]]) -> Iterator[Segment]:
    """Segments between points; two points above one another are a step."""
    step = 0.0
    for (x, z), (next_x, next_z) in pairwise(points):
        dx, dz = next_x - x, next_z - z
        if dx == 0.0:
            step = dz
            continue
        yield math.hypot(dx, dz), math.degrees(math.atan2(-dz, dx)), step
        step = 0.0
