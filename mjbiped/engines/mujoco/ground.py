"""The ground of a scene: a terrain, cut into the pieces that MuJoCo's ground is built of.

* An endless terrain of a single slope becomes a **plane**;
* a stretch between two steps becomes a **box** per segment where it is level, and **heightfields** where it is not: a
  tilted box has leaning ends, and a step beside it would stand before or behind its place;
* a step gets a frictionless **riser**, a plate behind its face by the foot's radius: the end of the leg meets it there;
* about a riser's face the lower ground is a box of its own, the **sill**, which goes on behind the face: a foot that
  comes down along a riser would be held between the riser and the end of a piece of ground, as in a vice;
* every slope change and step edge gets a stripe that only the eye meets.

Where the pieces begin and end, and every number in them, depends on the terrain alone: any row of neighbours can be
built without the others, and a foot meets bitwise the same ground on it (see `mjbiped.engines.mujoco.ground_window`).

Which of these a foot can meet is a matter of where it is: a piece only over its own segments, a riser only beside it
(`mjbiped.engines.mujoco.contacts.refuses`). So no foot meets a corner, whose normal would be none of the ground's.

All ground lies lower by `FOOT_RADIUS` along its normal, so that a leg's end touches the profile exactly when the
contact's distance is zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from mjbiped.engines.mujoco.options import GROUND_KINDS
from mjbiped.terrain.profile import EDGE
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name
from mjbiped.utils.mujoco import mujoco

FOOT_RADIUS = 5e-5
"""Radius of the colliding foot sphere, m. In plain steps it rolls: the step length's error is 0.011 % here, 0.23 % at
1e-3, 2.3 % at 1e-2. It must be more than what a foot sinks into a riser in one contact step, or it would miss the
ground before it."""

FEW_SEGMENTS = 40
"""A terrain of no more segments is always built whole, with heightfields as long as its equal segments go on."""

HALF_WIDTH = 0.6
"""Of the ground across the walking direction, m."""

_LONGEST_RUN = 16  # segments of one heightfield on a terrain of more than a few
_THICKNESS = 0.12  # of boxes and heightfield bases, m; contacts are never deeper than some 0.1 mm
_RISER_THICKNESS = 4e-3  # m; a foot gets no deeper into it than its displacement in a step
SILL = 4e-3
"""Of lower ground to either side of a riser's face, m, in half of which a foot meets this box in the piece's place."""
_BACKWARD = 3.0  # ground behind the start, m: more than a fallen robot reaches

Point = tuple[float, float]
"""Place x and height z, m."""


class Ground:
    """A terrain as pieces: a box, or the segments that share a heightfield.

    Attributes:
        terrain: The profile.
        end: Where the last segment ends, x in m.
    """

    def __init__(self, terrain: Terrain, *, reach: float, kind: str = "auto", cut: int = 0) -> None:
        """Cut a terrain.

        A heightfield's columns are equidistant, so neighbouring segments share one only while their widths are equal
        (rough ground, surveyed trails); the profile itself is never resampled.

        Args:
            terrain: The profile.
            reach: How far ahead of x = 0 the last segment must reach, m; a terrain that ends earlier keeps its end.
            kind: "auto" (see the module), or "heightfield" or "boxes" for all stretches alike.
            cut: A segment with which a piece begins in any case.

        Raises:
            InputError: The kind is unknown.
        """
        known_name("ground", kind, GROUND_KINDS)
        self.terrain = terrain
        self.end = min(terrain.end, max(reach, terrain.x[-1] + 1.0))
        self._plane = len(terrain.x) == 1 and kind == "auto" and math.isinf(terrain.end)
        self._starts = np.array(terrain.x)
        self._starts[0] -= _BACKWARD
        self._stops = np.append(terrain.x[1:], self.end)
        widths = self._stops - self._starts
        stepped = np.array(terrain.rises) != 0.0
        self._stretch = np.cumsum(stepped)  # between two steps
        uneven = np.bincount(self._stretch, np.array(terrain.angle) != 0.0) > 0.0
        self._field = uneven[self._stretch] if kind == "auto" else np.full(len(widths), kind == "heightfield")
        unlike = np.abs(np.diff(widths)) > 1e-9 * np.maximum(widths[1:], widths[:-1])
        begins = np.append(True, unlike | stepped[1:] | ~self._field[1:])
        begins[cut] = True
        if len(widths) > FEW_SEGMENTS:
            index = np.arange(len(widths))
            begins |= (index - np.maximum.accumulate(np.where(begins, index, 0))) % _LONGEST_RUN == 0
        self._pieces = np.append(np.flatnonzero(begins), len(widths))

    @property
    def segments(self) -> range:
        """All of them."""
        return range(len(self.terrain.x))

    def between(self, start: float, stop: float) -> range:
        """The segments of all pieces that have a part between two places (m); at least one piece."""
        first, last = np.searchsorted(self._starts, (start, stop), side="right") - 1
        low = int(np.searchsorted(self._pieces, max(first, 0), side="right")) - 1
        high = int(np.searchsorted(self._pieces, max(last, 0), side="right"))
        return range(int(self._pieces[low]), int(self._pieces[high]))

    def start_of(self, segment: int) -> float:
        """Where a segment's ground begins, x in m."""
        return float(self._starts[segment])

    def stop_of(self, segment: int) -> float:
        """Where it ends, x in m."""
        return float(self._stops[segment])

    def profile(self, segments: range) -> list[Point]:
        """First and last point of each of these segments."""
        return [point for index in segments for point in self._corners(index)]

    def pieces(self, segments: range) -> dict[str, range]:
        """The segments of each geom of the ground, by its name; the plane is of all."""
        return {"ground_0": self.segments} if self._plane else dict(self._named_pieces(segments))

    def add_to(self, spec: mujoco.MjSpec, segments: range) -> None:
        """Build ground.

        Args:
            spec: The scene, with default classes "terrain", "riser" and "edge".
            segments: Those of whole pieces, as `between` gives them.
        """
        if self._plane:
            _add_plane(spec, self.terrain)
            return
        for name, piece in self._named_pieces(segments):
            corners = [self._corners(index) for index in piece]
            if self._field[piece[0]]:
                _add_heightfield(spec, name, [corners[0][0], *(stop for _, stop in corners)])
            else:
                _add_box(spec, name, *corners[0], self.terrain.angle[piece[0]])
        for index in segments:
            if index:
                rise = self.terrain.rises[index]
                _add_edge(spec, f"edge_{index}", self.terrain.x[index], self.terrain.z[index], rise)
                if abs(rise) > EDGE:
                    _add_riser(spec, f"riser_{index}", self.terrain, index)
                    self._add_sill(spec, index)

    def _add_sill(self, spec: mujoco.MjSpec, index: int) -> None:
        """The lower ground about the face of the step at a segment's start."""
        up = self.terrain.rises[index] > 0.0
        low = index - 1 if up else index
        slope, (start, stop) = self.terrain.angle[low], self._corners(low)
        x, z = stop if up else start
        back = min(SILL, stop[0] - start[0])
        ends = (x - back, x + SILL) if up else (x - SILL, x + back)
        begin, end = ((place, z - math.tan(slope) * (place - x)) for place in ends)
        _add_box(spec, f"sill_{index}", begin, end, slope)

    def _corners(self, index: int) -> tuple[Point, Point]:
        """A segment's first and last point; the first segment reaches back, the last one to the end."""
        x, z, fall = self.terrain.x[index], self.terrain.z[index], math.tan(self.terrain.angle[index])
        start, stop = self.start_of(index), self.stop_of(index)
        return (start, z - fall * (start - x)), (stop, z - fall * (stop - x))

    def _named_pieces(self, segments: range) -> Iterator[tuple[str, range]]:
        """The pieces of these segments; each is called by its stretch, and by its number in there."""
        low, high = (int(place) for place in np.searchsorted(self._pieces, (segments.start, segments.stop)))
        for number in range(low, high):
            first, stop = int(self._pieces[number]), int(self._pieces[number + 1])
            stretch = int(self._stretch[first])
            before = int(np.searchsorted(self._pieces, np.searchsorted(self._stretch, stretch)))
            yield f"ground_{stretch}_{number - before}", range(first, stop)


def _tilt(slope: float) -> list[float]:
    """Quaternion that turns a level body down by `slope`, about +y."""
    return [math.cos(slope / 2), 0.0, math.sin(slope / 2), 0.0]


def _add_plane(spec: mujoco.MjSpec, terrain: Terrain) -> None:
    slope = terrain.angle[0]
    spec.worldbody.add_geom(
        spec.find_default("terrain"),
        name="ground_0",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, HALF_WIDTH, 0.05],
        pos=[terrain.x[0] - FOOT_RADIUS * math.sin(slope), 0.0, terrain.z[0] - FOOT_RADIUS * math.cos(slope)],
        quat=_tilt(slope),
    )


def _add_box(spec: mujoco.MjSpec, name: str, start: Point, stop: Point, slope: float) -> None:
    """One segment as a box whose upper face, raised by the foot's radius, is the profile."""
    depth = FOOT_RADIUS + _THICKNESS / 2
    spec.worldbody.add_geom(
        spec.find_default("terrain"),
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[math.dist(start, stop) / 2, HALF_WIDTH, _THICKNESS / 2],
        pos=[
            (start[0] + stop[0]) / 2 - depth * math.sin(slope),
            0.0,
            (start[1] + stop[1]) / 2 - depth * math.cos(slope),
        ],
        quat=_tilt(slope),
    )


def _add_heightfield(spec: mujoco.MjSpec, name: str, nodes: list[Point]) -> None:
    """A heightfield of two rows, with a column at each of these equidistant points of the profile."""
    slopes = [math.atan2(a[1] - b[1], b[0] - a[0]) for a, b in pairwise(nodes)]
    # lowered along the normal: by r / cos(slope) in z, at a node by the mean of the two segments that meet there
    lowering = [FOOT_RADIUS / math.cos(slope) for slope in slopes]
    padded = [lowering[0], *lowering, lowering[-1]]
    heights = np.array([z - (padded[k] + padded[k + 1]) / 2 for k, (_, z) in enumerate(nodes)])
    lowest = float(heights.min())
    rise = float(heights.max()) - lowest
    elevation = rise if rise > 0.0 else 1e-3  # MuJoCo stretches the data to 0..1, and refuses a zero scale
    relative = (heights - lowest) / elevation
    spec.add_hfield(
        name=name,
        size=[(nodes[-1][0] - nodes[0][0]) / 2, HALF_WIDTH, elevation, _THICKNESS],
        nrow=2,
        ncol=len(nodes),
        userdata=np.concatenate([relative, relative]),
    )
    spec.worldbody.add_geom(
        spec.find_default("terrain"),
        name=name,
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname=name,
        pos=[(nodes[0][0] + nodes[-1][0]) / 2, 0.0, lowest],
    )


def _add_riser(spec: mujoco.MjSpec, name: str, terrain: Terrain, index: int) -> None:
    """A frictionless plate behind the face of the step at a segment's start, up to the upper ground's height."""
    x, top, rise = terrain.x[index], terrain.z[index], terrain.rises[index]
    upper, lower = max(top, top - rise), min(top, top - rise) - _THICKNESS / 2
    inward = 1.0 if rise > 0.0 else -1.0
    spec.worldbody.add_geom(
        spec.find_default("riser"),
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[_RISER_THICKNESS / 2, HALF_WIDTH, (upper - lower) / 2],
        pos=[x + inward * (FOOT_RADIUS + _RISER_THICKNESS / 2), 0.0, (upper + lower) / 2],
    )


def _add_edge(spec: mujoco.MjSpec, name: str, x: float, z: float, rise: float) -> None:
    """A stripe across the ground where the slope changes (dark) or a step stands (red); for the eye only."""
    spec.worldbody.add_geom(
        spec.find_default("edge"),
        name=name,
        size=[0.006, HALF_WIDTH + 0.002, 0.0015],
        pos=[x, 0.0, max(z, z - rise)],
        material="step_edge" if rise != 0.0 else "slope_edge",
    )
