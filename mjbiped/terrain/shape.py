"""What a terrain tells of its ground: heights, slopes, steps and outlines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import pairwise
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shown
from mjbiped.terrain.profile import Profile, height_of, segment_under
from mjbiped.terrain.surface import Numbers, Surface

STEP_RESOLUTION = 1e-9
"""Greatest height difference at a break that is rounding, not a step, m; `domains.PLACE` bounds the rounding."""


class Shape:
    """The ground of a `mjbiped.Terrain`, whose fields these are."""

    x: tuple[float, ...]
    z: tuple[float, ...]
    angle: tuple[float, ...]
    end: float
    lateral: tuple[float, ...]
    surface: Surface | None

    @cached_property
    def profile(self) -> Profile:
        """Starts, heights and gradients of the segments, for code that runs at every physics step."""
        return Profile(self.x, self.z, self.gradients, len(self.x))

    @cached_property
    def gradients(self) -> tuple[float, ...]:
        """dz/dx of the segments, shape (n,)."""
        return tuple(-math.tan(angle) for angle in self.angle)

    @cached_property
    def falls(self) -> tuple[float, ...]:
        """-dz/dy of the segments, shape (n,); empty where all ground is level across."""
        return tuple(map(math.tan, self.lateral))

    @property
    def is_profile(self) -> bool:
        """Whether the ground is a profile, level across: planar robots walk on no other."""
        return not self.lateral and self.surface is None

    @cached_property
    def heights_before(self) -> tuple[float, ...]:
        """Heights just before the segments' starts, before the steps, m, shape (n,); the first is z[0]."""
        dx = (there - here for here, there in pairwise(self.x))
        before = (z + g * length for z, g, length in zip(self.z, self.gradients, dx, strict=False))
        return (self.z[0], *before)

    @cached_property
    def rises(self) -> tuple[float, ...]:
        """Steps up at the segments' starts, m, shape (n,); exactly 0.0 where there is none, and for the first."""
        jumps = (after - before for after, before in zip(self.z, self.heights_before, strict=True))
        return tuple(jump if abs(jump) > STEP_RESOLUTION else 0.0 for jump in jumps)

    def segment_at(self, x: float) -> int:
        """Return the index of the segment under x (m)."""
        return segment_under(self.profile, x)

    def height_at(self, x: float, y: float = 0.0) -> float:
        """Return the height (m) at x, y (m): `height` for one plain float; NaN gives NaN."""
        return float(self.across(x, y))

    def across(self, x: float, y: Numbers) -> Numbers:
        """Return the heights (m) at x and one or more y (m)."""
        index = self.segment_at(x)
        height: Numbers = height_of(self.profile, index, x)
        height = height - self.falls[index] * y if self.lateral else height
        return height if self.surface is None else height + self.surface.height_at(x, y)

    def normal_at(self, x: float, y: float) -> NDArray[np.float64]:
        """Return the ground's upward normal at x, y (m), a unit vector, shape (3,).

        On a surface this is the normal of the triangle under the place, on which a point foot stands in both engines.
        On bumps of 10 mm it differs by 0.6 degrees rms, 2.3 at most, from that of a smooth surface through the grid's
        points (a bicubic spline), and half as much on bumps of 5 mm. The law is told this normal and never that of a
        contact of MuJoCo's, which near the grid's lines is another (`mjbiped.engines.mujoco.heightfields`).
        """
        forward, left = self._gradient_at(x, y)
        normal = np.array([-forward, -left, 1.0])
        return np.asarray(normal / np.linalg.norm(normal))

    def _gradient_at(self, x: float, y: float) -> tuple[float, float]:
        """dz/dx and dz/dy at a place (m)."""
        index = self.segment_at(x)
        forward, left = self.gradients[index], -self.falls[index] if self.lateral else 0.0
        if self.surface is None:
            return forward, left
        more, across = self.surface.gradient_at(x, y)
        return forward + more, left + across

    def slope_at(self, x: float) -> float:
        """Return the slope (rad) at x (m): `slope` for one plain float, without NumPy; NaN gives NaN."""
        if self.surface is not None and x == x:
            return math.atan(-self._gradient_at(x, 0.0)[0])
        return self.angle[self.segment_at(x)] if x == x else x

    @overload
    def height(self, x: float) -> float: ...
    @overload
    def height(self, x: NDArray[np.number] | Sequence[float]) -> NDArray[np.float64]: ...
    def height(self, x: float | NDArray[np.number] | Sequence[float]) -> float | NDArray[np.float64]:
        """Return the height of the ground.

        Args:
            x: Places, m, any shape; NaN gives NaN.

        Returns:
            Heights, m, in x's shape; a float for a scalar. On a step, the height after it.

        Raises:
            InputError: x is not numeric.
        """
        return _asked(self.height_at, x)

    @overload
    def slope(self, x: float) -> float: ...
    @overload
    def slope(self, x: NDArray[np.number] | Sequence[float]) -> NDArray[np.float64]: ...
    def slope(self, x: float | NDArray[np.number] | Sequence[float]) -> float | NDArray[np.float64]:
        """Return the slope of the ground.

        Args:
            x: Places, m, any shape; NaN gives NaN.

        Returns:
            Slopes, rad, positive downwards in the walking direction, in x's shape; a float for a scalar. At a break,
            the slope after it.

        Raises:
            InputError: x is not numeric.
        """
        return _asked(self.slope_at, x)

    @property
    def samples(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Places and heights (m) that straight lines join, for a profile with an end; a step has two at one place."""
        x, z = self.outline(self.x[0], self.end)
        joined = np.append((np.diff(x) == 0.0) & (np.abs(np.diff(z)) <= STEP_RESOLUTION), False)  # no step
        return x[~joined], z[~joined]

    def outline(self, start: float, stop: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Ground at y = 0 between two places, with both ends of every segment and step: x and z in m."""
        if self.surface is not None:
            places = np.array([start, *self.surface.crossings(start, stop), stop])
            return places, np.array([self.height_at(place) for place in places.tolist()])
        x, z = [start], [self.height_at(start)]
        for place, before, after in zip(self.x[1:], self.heights_before[1:], self.z[1:], strict=True):
            if start < place < stop:
                x += [place, place]
                z += [before, after]
        return np.array([*x, stop]), np.array([*z, self.height_at(stop)])

    def stretches(self) -> Iterator[range]:
        """Iterate over runs of segments without a step in between, each as a range of indices."""
        starts = [0, *(i for i, rise in enumerate(self.rises) if rise), len(self.x)]
        return (range(first, stop) for first, stop in pairwise(starts))


def _asked(ask: Callable[[float], float], x: object) -> float | NDArray[np.float64]:
    """Ask at one place or at each of an array."""
    places: NDArray[Any] = np.array(None)
    with suppress(ValueError, TypeError):  # rows of unequal length
        places = np.asarray(x)
    if places.dtype.kind not in "iuf":
        raise InputError(f"x = {shown(x)}: must be numbers in m")
    if not places.ndim:
        return ask(float(places))
    return np.array([ask(float(place)) for place in places.flat], dtype=np.float64).reshape(places.shape)
