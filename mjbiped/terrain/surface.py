"""Surfaces z(x, y) on a grid, and bumps made of waves in all directions.

A cell's two triangles are those of MuJoCo's heightfields: they meet in the diagonal that leads forward and to the left,
from the corner of least x and least y (measured with rays and with contacts of a sphere).
"""

from __future__ import annotations

import base64
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shown
from mjbiped.utils import domains
from mjbiped.utils.domains import checked

MOST_HEIGHTS = 2_000_000
"""Greatest number of heights of one grid."""

SPACING = 0.05
"""Of the grid of bumps, m."""

HALF_WIDTH = 3.025
"""Of the grid of bumps, m. Feet 0.1 m apart that walk straight ahead tread midway between its lines along x, where
MuJoCo's contacts have the ground's normal."""

RESOLUTION = 2.0**-20
"""Of heights of bumps, m: rounding of their sums, which differs between computers, does not show."""

BEHIND, LEVEL, GROWN = 2.0, 0.3, 0.5
"""Bumps' grid behind the start, level ground ahead of it, and the distance in which they then grow, m."""

_WAVES = 60  # of bumps; their sum is nearly normal

Deviation = Annotated[float, domains.Domain(0.0, 0.1, "m")]
Stretch = Annotated[float, domains.STRETCH]
Seed = Annotated[int, domains.SEED]
Length = Annotated[float, domains.Domain(2.0, 1e5, "m")]
Array = NDArray[np.float64]
Numbers = float | Array


class Cell(NamedTuple):
    """Where places are on a grid.

    Attributes:
        row: Of the cell, along y.
        column: Of the cell, along x.
        u: Part of the cell along x, 0 to 1.
        v: Part of the cell along y, 0 to 1.
    """

    row: NDArray[np.int64]
    column: NDArray[np.int64]
    u: Array
    v: Array


@dataclass(frozen=True, eq=False, repr=False)
class Surface:
    """Heights on a grid, linear on two triangles per cell; beyond the grid the height of its edge goes on.

    Attributes:
        x0: The first column, m.
        y0: The first row, m.
        spacing: Distance between neighbours, m.
        heights: Heights, m, shape (rows, columns): rows along y, which is to the left, and columns along x.
        waves: Parameters of `bumps` if that made it; records hold these in the heights' place.

    Raises:
        InputError: A value outside its domain, fewer than two rows or columns, or more than `MOST_HEIGHTS` heights.
    """

    x0: float
    y0: float
    spacing: float
    heights: Array
    waves: Mapping[str, Any] | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        """Check the fields."""
        for name, domain in (("x0", domains.PLACE), ("y0", domains.PLACE), ("spacing", domains.STRETCH)):
            object.__setattr__(self, name, domain.check(name, getattr(self, name)))
        heights = domains.PLACE.array("heights", self.heights, (None, None)) + 0.0  # no negative zero
        if min(heights.shape) < 2 or heights.size > MOST_HEIGHTS:
            rows, columns = heights.shape
            raise InputError(
                f"a grid of {rows} x {columns} heights: must have two rows and two columns at least, and "
                f"{MOST_HEIGHTS} heights at most; choose a shorter stretch or a wider spacing"
            )
        heights.flags.writeable = False
        object.__setattr__(self, "heights", heights)

    def __eq__(self, other: object) -> bool:
        """Whether two surfaces are equal bit by bit."""
        return isinstance(other, Surface) and self._key == other._key

    def __hash__(self) -> int:
        """Hash of all that is compared."""
        return hash(self._key)

    def __repr__(self) -> str:
        """One line without the heights."""
        rows, columns = self.heights.shape
        return f"<Surface of {rows} x {columns} heights every {self.spacing:g} m>"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what a record holds, which is little where `bumps` made it."""
        return Surface.from_dict, (self.to_dict(),)

    @cached_property
    def _key(self) -> tuple[float, float, float, tuple[int, ...], bytes]:
        return self.x0, self.y0, self.spacing, self.heights.shape, self.heights.tobytes()

    @property
    def ends(self) -> tuple[float, float]:
        """The last column's x and the last row's y, m."""
        rows, columns = self.heights.shape
        return self.x0 + (columns - 1) * self.spacing, self.y0 + (rows - 1) * self.spacing

    def _cell(self, x: Numbers, y: Numbers) -> Cell:
        """The cells under places (m), or nearest to them."""
        rows, columns = self.heights.shape
        u = np.minimum(np.maximum((x - self.x0) / self.spacing, 0.0), columns - 1.0)
        v = np.minimum(np.maximum((y - self.y0) / self.spacing, 0.0), rows - 1.0)
        # NaN stays in the cell's parts, and is in the first cell
        row, column = (
            np.minimum(np.fmax(v, 0.0).astype(int), rows - 2),
            np.minimum(np.fmax(u, 0.0).astype(int), columns - 2),
        )
        return Cell(row, column, u - column, v - row)

    def _corners(self, cell: Cell) -> tuple[Array, Array, Array, Array]:
        """Heights of the corners of cells, m: at the least x and y, ahead, to the left, and ahead to the left."""
        row, column, heights = cell.row, cell.column, self.heights
        return heights[row, column], heights[row, column + 1], heights[row + 1, column], heights[row + 1, column + 1]

    def height_at(self, x: Numbers, y: Numbers) -> Array:
        """Heights at places (m), m, in the shape to which x and y are broadcast; NaN gives NaN."""
        cell = self._cell(x, y)
        (a, b, c, d), u, v = self._corners(cell), cell.u, cell.v
        return np.where(u >= v, a + (b - a) * u + (d - b) * v, a + (d - c) * u + (c - a) * v)

    def gradient_at(self, x: float, y: float) -> tuple[float, float]:
        """dz/dx and dz/dy of the triangle under a place (m); of its neighbour ahead or to the left on an edge."""
        cell = self._cell(x, y)
        a, b, c, d, u, v = (float(each) for each in (*self._corners(cell), cell.u, cell.v))
        ahead, left = (b - a, d - b) if u >= v else (d - c, c - a)
        last_x, last_y = self.ends
        inside_x, inside_y = self.x0 <= x < last_x, self.y0 <= y < last_y
        if not inside_y:
            ahead, left = (b - a if v < 0.5 else d - c), 0.0
        if not inside_x:
            ahead, left = 0.0, (c - a if u < 0.5 else d - b) if inside_y else 0.0
        return ahead / self.spacing, left / self.spacing

    def steepest(self, forward: float, left: float) -> tuple[float, float, float]:
        """The greatest steepness of all triangles, on a plane.

        Args:
            forward: dz/dx of the plane.
            left: dz/dy of the plane.

        Returns:
            The triangle's angle, rad, and a corner of its cell, x and y in m.
        """
        wide = np.pad(self.heights, 1, mode="edge")
        along, across = np.diff(wide, axis=1) / self.spacing + forward, np.diff(wide, axis=0) / self.spacing + left
        steepness = np.maximum(np.hypot(along[:-1], across[:, 1:]), np.hypot(along[1:], across[:, :-1]))
        row, column = np.unravel_index(np.argmax(steepness), steepness.shape)
        place = self.x0 + (int(column) - 1) * self.spacing, self.y0 + (int(row) - 1) * self.spacing
        return math.atan(float(steepness[row, column])), *place

    def crossings(self, start: float, stop: float, y: float = 0.0) -> Array:
        """Places x (m) between two others where the line of one y crosses from triangle to triangle, shape (n,)."""
        columns = self.x0 + self.spacing * np.arange(self.heights.shape[1])
        found = np.unique(np.concatenate([columns, columns[:-1] + self._cell(0.0, y).v * self.spacing]))
        return found[(start < found) & (found < stop)]

    # ---- the record ----------------------------------------------------------------------------------------------

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold; `from_dict` undoes it exactly."""
        if self.waves is not None:
            return {"waves": dict(self.waves)}
        packed = base64.b64encode(zlib.compress(self.heights.astype("<f8").tobytes())).decode()
        return {
            "x0": self.x0, "y0": self.y0, "spacing": self.spacing, "shape": [*self.heights.shape], "heights": packed,
        }  # fmt: skip

    @classmethod
    def from_dict(cls, written: Mapping[str, Any]) -> Surface:
        """Make the surface that `to_dict` wrote.

        Raises:
            InputError: It holds anything else.
        """
        try:
            if "waves" in written:
                return bumps(**written["waves"])
            rows, columns = written["shape"]
            unpacking = zlib.decompressobj()
            unpacked = unpacking.decompress(base64.b64decode(written["heights"]), 8 * MOST_HEIGHTS)
            heights = np.frombuffer(unpacked, dtype="<f8").reshape(rows, columns)
            return cls(written["x0"], written["y0"], written["spacing"], heights)
        except (KeyError, TypeError, ValueError, zlib.error) as error:
            raise InputError(f"surface = {shown(written)}: is not what Surface.to_dict writes ({error})") from error


@checked
def bumps(seed: Seed, rms: Deviation, shortest: Stretch, longest: Stretch, length: Length) -> Surface:
    """Make bumps of 60 waves in all directions; the same arguments give the same surface bit by bit.

    Args:
        seed: Seed of the generator (NumPy's PCG64), >= 0.
        rms: Standard deviation of the heights, m.
        shortest: Shortest wave, m.
        longest: Longest wave, m.
        length: Length of the grid ahead of the start, m.

    Raises:
        InputError: A value outside its domain.
    """
    if not 4.0 * SPACING <= shortest < longest:
        raise InputError(
            f"shortest = {shortest:g} m: must be at least {4.0 * SPACING:g} m, four times the grid's spacing, and less "
            f"than longest = {longest:g} m"
        )
    if length > (farthest := MOST_HEIGHTS * SPACING**2 / (2.0 * HALF_WIDTH + SPACING) - BEHIND - 1.0):
        raise InputError(f"length = {length:g} m: bumps of more than {farthest:.0f} m have too many heights")
    return _bumps(seed, rms, shortest, longest, length)


@lru_cache(maxsize=16)
def _bumps(seed: int, rms: float, shortest: float, longest: float, length: float) -> Surface:
    draw = np.random.Generator(np.random.PCG64(seed))
    numbers = 2.0 * math.pi / np.exp(draw.uniform(math.log(shortest), math.log(longest), _WAVES))
    directions, phases = draw.uniform(0.0, 2.0 * math.pi, _WAVES), draw.uniform(0.0, 2.0 * math.pi, _WAVES)
    x = np.arange(math.ceil((BEHIND + length) / SPACING) + 1) * SPACING - BEHIND
    y = np.arange(round(2.0 * HALF_WIDTH / SPACING) + 1) * SPACING - HALF_WIDTH
    heights = np.zeros((len(y), len(x)))
    for number, direction, phase in zip(numbers, directions, phases, strict=True):
        heights += np.cos(number * (math.cos(direction) * x + math.sin(direction) * y[:, None]) + phase)
    heights *= rms * math.sqrt(2.0 / _WAVES) * np.clip((x - LEVEL) / GROWN, 0.0, 1.0)
    surface = Surface(-BEHIND, -HALF_WIDTH, SPACING, np.round(heights / RESOLUTION) * RESOLUTION)
    given = {"seed": seed, "rms": rms, "shortest": shortest, "longest": longest, "length": length}
    object.__setattr__(surface, "waves", given)
    return surface
