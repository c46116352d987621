"""Ground that a seed draws: constructors that `mjbiped.Terrain` inherits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType
from typing import Annotated, Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError
from mjbiped.terrain.profile import MOST_SEGMENTS, STANDABLE, Segment, chained
from mjbiped.terrain.surface import Deviation, Length, Seed, Stretch, bumps
from mjbiped.utils import domains
from mjbiped.utils.domains import Interval, checked

START = 2.0
"""Length of the level and smooth ground at the start, m: the first steps are the same everywhere."""

GROWN = 3.0
"""Distance, in longest waves, in which heights grow to 95 % of their final size: 1 - exp(-3)."""

Slope: TypeAlias = Annotated[float, STANDABLE]
Slopes: TypeAlias = Annotated[tuple[float, float], Interval(STANDABLE)]
Changes: TypeAlias = Annotated[int, domains.Count(1, MOST_SEGMENTS - 1)]

_WAVES = 64  # of band-limited ground; their sum is nearly normal

_LEVEL: Segment = (START, 0.0, 0.0)


class Drawn:
    """Constructors of random ground."""

    @classmethod
    @checked
    def random(
        cls,
        seed: Seed = 0,
        length: Annotated[float, domains.Domain(1.0, 1e5, "m")] = 25.0,
        segment_length: Annotated[tuple[float, float], Interval(domains.STRETCH)] = (0.8, 2.0),
        slope_deg: Slopes = (-3.0, 3.0),
        rise: Annotated[tuple[float, float], Interval(domains.STEP)] = (-0.02, 0.005),
        step_probability: Annotated[float, domains.PROBABILITY] = 0.5,
        roughness: Annotated[float, domains.Domain(0.0, 0.5, "m")] = 0.0,
        spacing: Stretch = 0.25,
    ) -> Self:
        """Make random ground; the same arguments give the same terrain bit by bit (NumPy's PCG64).

        The first metre is level and smooth, so that the start is defined; then come segments of uniformly drawn length,
        slope and step until `length` is reached; the last one goes on. `roughness` is added to this afterwards, and a
        seed draws the same segments with and without it.

        Args:
            seed: Seed of the generator, >= 0.
            length: Length of the ground along itself, m, >= 1.
            segment_length: Range of the segments' lengths, m, > 0.
            slope_deg: Range of the slopes, degrees.
            rise: Range of the steps, m, positive up.
            step_probability: Probability of a step at a segment's start, 0 to 1.
            roughness: Standard deviation of normally distributed heights of mean zero, m, >= 0, added about every
                `spacing` and at the breaks, linear in between, after the first metre and before the last segment's end.
            spacing: Distance between these heights, m, > 0; every segment is cut into equal cells nearest to it.

        Raises:
            InputError: A value outside its domain, or a slope too steep to be stood on: less roughness or a wider
                spacing keeps slopes gentle.
        """
        given = locals().copy()
        finest = min(segment_length[0], spacing) if roughness else segment_length[0]
        longest = length + segment_length[1]
        if longest / finest > MOST_SEGMENTS:
            raise InputError(
                f"{longest:g} m in pieces of {finest:g} m can be more than {MOST_SEGMENTS} segments; choose a shorter "
                "length, longer segments or a wider spacing"
            )
        draw = _generator(seed)
        rows: list[Segment] = [(1.0, 0.0, 0.0)]
        done = 1.0
        while done < length:
            piece, slope, step = (float(draw.uniform(*ends)) for ends in (segment_length, slope_deg, rise))
            rows.append((piece, slope, step if draw.random() < step_probability else 0.0))
            done += piece
        if roughness:
            rows = _roughened(rows, spacing, lambda: float(draw.normal(0.0, roughness)))
        return cls._of_segments(rows, "random", given)

    @classmethod
    @checked
    def treads(
        cls,
        seed: Seed = 0,
        length: Length = 400.0,
        tread: Stretch = 1.0,
        deviation: Deviation = 0.03,
        slope_deg: Slopes = (0.0, 0.0),
    ) -> Self:
        """Make treads of one depth with random steps between them; the same arguments give the same terrain bit by bit.

        The first 2 m are level. The steps are normally distributed, as in studies of metastable walking (Byl and
        Tedrake, 2009), so that the ground's height wanders; `deviation = 0` leaves slopes that meet.

        Args:
            seed: Seed of the generator (NumPy's PCG64), >= 0.
            length: Length of the ground along itself, m, >= 2; the last tread goes on.
            tread: Depth of a tread, m, > 0.
            deviation: Standard deviation of the steps, m, from 0 to 0.1.
            slope_deg: Range of the uniformly distributed slopes of the treads, degrees.

        Raises:
            InputError: A value outside its domain.
        """
        given = locals().copy()
        count, draw = _pieces(length, tread, "tread"), _generator(seed)
        drawn = ((draw.uniform(*slope_deg), deviation * draw.standard_normal()) for _ in range(count))
        rows = [_LEVEL, *((tread, float(slope), float(step)) for slope, step in drawn)]
        return cls._of_segments(rows, "treads", given)

    @classmethod
    @checked
    def waves(
        cls,
        seed: Seed = 0,
        length: Length = 400.0,
        deviation: Deviation = 0.01,
        shortest: Stretch = 0.5,
        longest: Stretch = 5.0,
        spacing: Stretch = 0.05,
    ) -> Self:
        """Make rough ground from a band of wave lengths; the same arguments give the same terrain bit by bit.

        The first 2 m are level. Then come 64 waves, whose wave numbers are uniformly distributed from 1 / `longest` to
        1 / `shortest`, whose phases are random and whose sum has heights of the standard deviation `deviation`; over
        the first `longest` they grow from nothing.

        Args:
            seed: Seed of the generator (NumPy's PCG64), >= 0.
            length: Length of the ground along x, m, >= 2; its last slope goes on.
            deviation: Standard deviation of the heights, m, from 0 to 0.1.
            shortest: Shortest wave, m, > 0.
            longest: Longest wave, m, longer than the shortest.
            spacing: Distance between the points that straight segments join, m; at most a quarter of the shortest wave.

        Raises:
            InputError: A value outside its domain, or a slope too steep to be stood on: take a smaller deviation or
                longer waves.
        """
        given = locals().copy()
        if not 4.0 * spacing <= shortest < longest:
            raise InputError(
                f"shortest = {shortest:g} m: must be at least {4.0 * spacing:g} m, four times spacing, and less than "
                f"longest = {longest:g} m"
            )
        count, draw = _pieces(length, spacing, "spacing"), _generator(seed)
        numbers = 2.0 * math.pi * draw.uniform(1.0 / longest, 1.0 / shortest, _WAVES)
        phases = draw.uniform(0.0, 2.0 * math.pi, _WAVES)
        x = np.arange(count + 1) * spacing
        heights = math.sqrt(2.0 / _WAVES) * deviation * np.sin(numbers * x[:, None] + phases).sum(axis=1)
        rises = np.diff(heights * (1.0 - np.exp(-x / longest)))  # the ground leaves the start without a step
        return cls._of_segments([_LEVEL, *(_straight(spacing, rise) for rise in rises.tolist())], "waves", given)

    @classmethod
    @checked
    def bumps(
        cls,
        seed: Seed = 0,
        rms: Deviation = 0.01,
        shortest: Stretch = 0.5,
        longest: Stretch = 3.0,
        slope_deg: Slope = 0.0,
        lateral_deg: Slope = 0.0,
        length: Length = 40.0,
    ) -> Self:
        """Make a plane with bumps, for robots in space; the same arguments give the same terrain bit by bit.

        The first 0.3 m are plane; over the next 0.5 m the bumps grow. They are 60 waves in all directions, whose
        lengths are random, with a uniform distribution of the logarithm, on a grid of 5 cm that reaches 3 m to either
        side. Beyond it the height of its edge goes on.

        Args:
            seed: Seed of the generator (NumPy's PCG64), >= 0.
            rms: Standard deviation of the heights, m, from 0 to 0.1.
            shortest: Shortest wave, m, at least 0.2.
            longest: Longest wave, m, longer than the shortest.
            slope_deg: Slope of the plane, degrees, positive downhill.
            lateral_deg: Its slope across, degrees, positive down to the left.
            length: Length of the bumps along x, m, >= 2.

        Raises:
            InputError: A value outside its domain, or a slope too steep to be stood on: take smaller bumps or longer
                waves.
        """
        given = locals().copy()
        plane = cls._of_segments([(1.0, slope_deg, 0.0)], "bumps", given)
        surface = bumps(seed, rms, shortest, longest, length)
        return replace(plane, surface=surface)  # type: ignore[type-var]  # Terrain's a dataclass

    @classmethod
    def _of_segments(cls, rows: Sequence[Segment], name: str, given: Mapping[str, Any] = MappingProxyType({})) -> Self:
        """Make a terrain of checked segments, laid one after another from x = 0.

        Args:
            rows: The segments.
            name: Name of the terrain.
            given: Parameters that it was made with, such as the local variables of a constructor at its beginning; a
                `lateral_deg` is the slope across of segments that have none of their own, and left out where it is 0.
        """
        x, z, angle = chained(rows)
        aside = given.get("lateral_deg") or 0.0
        lateral = tuple(math.radians(row[3] if len(row) == 4 else aside) for row in rows)
        pairs = tuple((key, value) for key, value in given.items() if key != "cls" and (key != "lateral_deg" or value))
        return cls(x=x, z=z, angle=angle, name=name, parameters=pairs, lateral=lateral)  # type: ignore[call-arg]


def _generator(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def _straight(dx: float, dz: float, step: float = 0.0) -> Segment:
    """Return the segment that leads `dx` forward and `dz` up, m, after a step."""
    return math.hypot(dx, dz), math.degrees(math.atan2(-dz, dx)), step


def _pieces(length: float, piece: float, name: str) -> int:
    """Count the pieces after the level start, and refuse more segments than a terrain may have."""
    if (length - START) / piece > MOST_SEGMENTS - 2:
        raise InputError(
            f"{length:g} m in pieces of {piece:g} m are more than {MOST_SEGMENTS} segments; choose a shorter "
            f"length or a longer {name}"
        )
    return max(1, math.ceil((length - START) / piece))


def _roughened(rows: Sequence[Segment], spacing: float, height: Callable[[], float]) -> list[Segment]:
    """Cut all segments but the first into cells of about `spacing` and add a random height where two cells meet."""
    rough = [rows[0]]
    added = 0.0
    for k, (length, slope, step, *_) in enumerate(rows[1:], start=1):
        cells = max(1, round(length / spacing))
        angle = math.radians(slope)
        dx = length * math.cos(angle) / cells
        for cell in range(cells):
            last = k == len(rows) - 1 and cell == cells - 1
            before, added = added, 0.0 if last else height()
            dz = (added - before) - math.tan(angle) * dx
            rough.append(_straight(dx, dz, step if cell == 0 else 0.0))
    return [*rough, (1.0, rows[-1][1], 0.0)]


def recorded_rows(seed: int, length: float, x: NDArray[np.float64], z: NDArray[np.float64]) -> list[Segment]:
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
    places = x - x[0]
    heights = z - np.polyval(np.polyfit(places, z, 1), places)
    once = float(places[-1])
    places, heights = np.append(places, 2.0 * once - places[-2::-1]), np.append(heights, heights[-2::-1])
    first = float(_generator(seed).uniform(0.0, 2.0 * once))
    last = first + max(length - START, 0.0)
    rounds = [2.0 * once * k for k in range(math.ceil(last / (2.0 * once)))]
    places = np.concatenate([places[:-1] + passed for passed in rounds])  # the last sample is the next round's first
    heights = np.tile(heights[:-1], len(rounds))
    inside = (places > first) & (places < last)
    ends = np.interp((first, last), (*places, 2.0 * once * len(rounds)), (*heights, heights[0]))
    points = zip((first, *places[inside], last), (ends[0], *heights[inside], ends[1]), strict=True)
    return [_LEVEL, *_joined([(float(place), float(height)) for place, height in points])]


def _joined(points: Sequence[tuple[float, float]]) -> Iterator[Segment]:
    """Iterate over the segments between points; two points above one another are a step."""
    step = 0.0
    for (x, z), (next_x, next_z) in pairwise(points):
        dx, dz = next_x - x, next_z - z
        if dx == 0.0:
            step = dz
            continue
        yield _straight(dx, dz, step)
        step = 0.0
