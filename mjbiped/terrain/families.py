"""Families of random ground whose statistics are named: treads with random steps, and waves of a band of lengths."""

from __future__ import annotations

import math

import numpy as np

from mjbiped.terrain.segments import Segment

START = 2.0
"""Level and smooth ground that every one begins with, m: the first steps are the same everywhere."""

_WAVES = 64  # of band-limited ground; their sum is nearly normal


def tread_rows(
    seed: int, length: float, tread: float, deviation: float, slope_deg: tuple[float, float]
) -> list[Segment]:
    """Segments of treads, each of which has a slope of its own and begins with a step.

    Args:
        seed: Of the generator.
        length: Of the ground along itself, m.
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
    """Segments through the sum of waves whose wave numbers are uniformly distributed in a band.

    Args:
        seed: Of the generator.
        length: Of the ground along x, m.
        deviation: Standard deviation of the heights, m.
        shortest: Shortest wave, m.
        longest: Longest wave, m.
        spacing: Of the points that the ground is straight between, m.
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
