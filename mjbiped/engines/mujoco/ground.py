"""The ground of a scene: a terrain, cut into the pieces that MuJoCo's ground is built of.

* An endless terrain of a single slope becomes a **plane**;
* a stretch between two steps becomes a **box** per segment where it is level, and **heightfields** where it is not: a
  tilted box has leaning ends, and a step beside it would stand before or behind its place;
* a step gets a frictionless **riser**, a plate behind its face by the foot's radius: the end of the leg meets it there;
* about a riser's face the lower ground is a box of its own, the **sill**, which goes on behind the face: a foot that
  comes down along a riser would be held between the riser and the end of a piece of ground, as in a vice.

Where the pieces begin and end, and every number in them, depends on the terrain alone: any row of neighbours can be
built without the others, and a foot meets bitwise the same ground on it (see `mjbiped.engines.mujoco.scene`).

Which of these a foot can meet is a matter of where it is: a piece only over its own segments, a riser only beside it
(`mjbiped.engines.mujoco.collisions`). So no foot meets a corner, whose normal would be none of the ground's.

All ground lies lower by `FOOT_RADIUS` along its normal, so that a leg's end touches the profile exactly when the
contact's distance is zero.

For robots in space the same pieces are wider, and tilted across where the ground is; their feet collide with all pieces
at all times, so there are neither risers nor sills. A surface becomes `mjbiped.engines.mujoco.heightfields`.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mjbiped.engines.mujoco.heightfields import add_geom, add_grid, add_surface
from mjbiped.engines.mujoco.options import AUTO, BOXES, FIELD, GROUND_KINDS
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
"""Of the ground of planar robots across the walking direction, m."""

_LONGEST_RUN = 16  # segments of one heightfield on a terrain of more than a few
_THICKNESS = 0.12  # of boxes, m; contacts are never deeper than some 0.1 mm
_THICK = 1.0  # the same where ground of several lateral slopes stands apart, m
_RISER_THICKNESS = 4e-3  # m; a foot gets no deeper into it than its displacement in a step
SILL = 4e-3
"""Of lower ground to either side of a riser's face, m, in half of which a foot meets this box in the piece's place."""
_AHEAD = 20.0  # of the hip in a new window, in leg lengths, while these are few segments
_TURN = 1.0  # behind the margin, in leg lengths: who turns back and forth does not build at each turn
_LEAST = 3.0  # ahead of the margin, in leg lengths, of however many segments
_BACKWARD = 3.0  # ground behind the start, m: more than a fallen robot reaches

PLANE = "plane"
SURFACE = "surface"
Point = tuple[float, float]
"""Place x and height z, m."""


class Piece(NamedTuple):
    """Segments that are built as one geom.

    Attributes:
        name: Of the geom: the number of the stretch between two steps, and the piece's in there.
        segments: Indices in the terrain.
        kind: What is built of them: a plane, a heightfield, a box of one segment, or heightfields of a surface.
    """

    name: str
    segments: range
    kind: str


class Ground:
    """A terrain as pieces: a box, or the segments that share a heightfield.

    Attributes:
        terrain: The profile.
        starts: Where each segment's ground begins, x in m: the first one reaches back.
        stops: Where it ends; the last one reaches to the end of the ground.
        pieces: All pieces.
        half_width: Of the ground across, m.
    """

    def __init__(
        self, terrain: Terrain, *, reach: float, kind: str = AUTO, cut: int = 0, half_width: float | None = None
    ) -> None:
        """Cut a terrain.

        A heightfield's columns are equidistant, so neighbouring segments share one only while their widths are equal
        (rough ground, surveyed trails); the profile itself is never resampled.

        Args:
            terrain: The profile.
            reach: How far ahead of x = 0 the last segment must reach, m; a terrain that ends earlier keeps its end.
            kind: "auto" (see the module), or "heightfield" or "boxes" for all stretches alike.
            cut: A segment with which a piece begins in any case.
            half_width: Of the ground of a robot in space across, m; None: the robot is planar.

        Raises:
            InputError: The kind is unknown.
        """
        known_name("ground", kind, GROUND_KINDS)
        self.terrain = terrain
        self.in_space = half_width is not None
        self.half_width = half_width or HALF_WIDTH
        self.starts = [terrain.x[0] - _BACKWARD, *terrain.x[1:]]
        self.stops = [*terrain.x[1:], min(terrain.end, max(reach, terrain.x[-1] + 1.0))]
        self.pieces: list[Piece] = []
        widths = np.subtract(self.stops, self.starts)
        longest = math.inf if len(widths) <= FEW_SEGMENTS else _LONGEST_RUN
        unlike = np.append(True, np.abs(np.diff(widths)) > 1e-9 * np.maximum(widths[1:], widths[:-1]))
        unlike[1:] |= np.diff(terrain.lateral or np.zeros(len(widths))) != 0.0
        for stretch, segments in enumerate(terrain.stretches()):
            made = FIELD if kind == FIELD or (kind == AUTO and any(terrain.angle[each] for each in segments)) else BOXES
            begins = [segments.start]
            for index in segments[1:]:
                if made == BOXES or unlike[index] or index == cut or index - begins[-1] == longest:
                    begins.append(index)
            for number, (first, stop) in enumerate(pairwise([*begins, segments.stop])):
                self.pieces.append(Piece(f"ground_{stretch}_{number}", range(first, stop), made))
        if terrain.surface is not None:
            self.pieces = [Piece("ground_0", range(1), SURFACE)]
        elif len(terrain.x) == 1 and kind == AUTO and math.isinf(terrain.end):
            self.pieces = [Piece("ground_0", range(1), PLANE)]

    def between(self, start: float, stop: float) -> list[Piece]:
        """The pieces that have a part between two places (m); at least one."""
        first, last = (self._piece_at(self.terrain.segment_at(x)) for x in (start, stop))
        return self.pieces[first : last + 1]

    def window(self, x: float, margin: float, length: float) -> list[Piece]:
        """The pieces to be built for a hip at x (m); all where their segments are few.

        Args:
            x: Place of the hip, m.
            margin: Ground about the hip that is never missing, m.
            length: Of the robot's legs, m.
        """
        starts = self.terrain.x
        if len(starts) <= FEW_SEGMENTS:
            return self.pieces
        few = starts[min(self.terrain.segment_at(x) + FEW_SEGMENTS, len(starts) - 1)]
        ahead = max(margin + _LEAST * length, min(margin + _AHEAD * length, few - x))
        return self.between(x - margin - _TURN * length, x + ahead)

    def _piece_at(self, segment: int) -> int:
        """Index of the piece of a segment."""
        return bisect_right(self.pieces, segment, key=lambda piece: piece.segments.start) - 1

    def profile(self, pieces: list[Piece]) -> list[Point]:
        """First and last point of each segment of these pieces."""
        return [point for piece in pieces for index in piece.segments for point in self._corners(index)]

    def add_to(self, spec: mujoco.MjSpec, pieces: list[Piece]) -> None:
        """Build ground.

        Args:
            spec: The scene, with default classes "terrain" and "riser".
            pieces: Neighbours.
        """
        for name, segments, kind in pieces:
            corners = [self._corners(index) for index in segments]
            if kind == SURFACE:
                add_surface(spec, name, self.terrain, (self.starts[0], self.stops[0]), self.half_width, FOOT_RADIUS)
            elif kind == PLANE:
                self._add_plane(spec, name)
            elif kind == FIELD:
                self._add_heightfield(spec, name, [corners[0][0], *(stop for _, stop in corners)], segments[0])
            else:
                self._add_box(spec, name, *corners[0], segments[0])
        for index in range(pieces[0].segments.start or 1, pieces[-1].segments.stop):
            if abs(self.terrain.rises[index]) > EDGE and not self.in_space:
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
        self._add_box(spec, f"sill_{index}", begin, end, low)

    def _tilt_of(self, segment: int) -> tuple[float, float]:
        """A segment's slope, and the angle about its line by which it then falls to the left, rad."""
        slope = self.terrain.angle[segment]
        return slope, math.atan(self.terrain.falls[segment] * math.cos(slope)) if self.terrain.lateral else 0.0

    def _add_plane(self, spec: mujoco.MjSpec, name: str) -> None:
        tilt, plane = self._tilt_of(0), mujoco.mjtGeom.mjGEOM_PLANE
        place = _under((self.terrain.x[0], self.terrain.z[0]), FOOT_RADIUS, *tilt)
        add_geom(spec, "terrain", name, type=plane, size=[0.0, self.half_width, 0.05], pos=place, quat=_turned(*tilt))

    def _add_box(self, spec: mujoco.MjSpec, name: str, start: Point, stop: Point, segment: int) -> None:
        """A part of a segment as a box whose upper face, raised by the foot's radius, is the ground."""
        thickness, tilt = _THICK if self.in_space else _THICKNESS, self._tilt_of(segment)
        middle = (start[0] + stop[0]) / 2, (start[1] + stop[1]) / 2
        size = [math.dist(start, stop) / 2, self.half_width, thickness / 2]
        place = _under(middle, FOOT_RADIUS + thickness / 2, *tilt)
        add_geom(spec, "terrain", name, size=size, pos=place, quat=_turned(*tilt))

    def _add_heightfield(self, spec: mujoco.MjSpec, name: str, nodes: list[Point], segment: int) -> None:
        """A heightfield of two rows, with a column at each of these equidistant points of the profile.

        Args:
            spec: The scene.
            name: Of the geom.
            nodes: The points.
            segment: One of the segments, which have one lateral slope.
        """
        fall = self.terrain.falls[segment] if self.terrain.lateral else 0.0
        slopes = [math.atan2(a[1] - b[1], b[0] - a[0]) for a, b in pairwise(nodes)]
        # lowered along the normal: by r / cos(slope) in z, at a node by the mean of the two segments that meet there
        lowering = [FOOT_RADIUS / math.cos(slope) * math.hypot(1.0, fall * math.cos(slope)) for slope in slopes]
        padded = [lowering[0], *lowering, lowering[-1]]
        heights = np.array([z - (padded[k] + padded[k + 1]) / 2 for k, (_, z) in enumerate(nodes)])
        grid = heights + fall * self.half_width * np.array([[1.0], [-1.0]])
        middle, reach = (nodes[0][0] + nodes[-1][0]) / 2, (nodes[-1][0] - nodes[0][0]) / 2
        add_grid(spec, name, grid, (middle, 0.0), (reach, self.half_width))

    def _corners(self, index: int) -> tuple[Point, Point]:
        """A segment's first and last point; the first segment reaches back, the last one to the end."""
        x, z, fall = self.terrain.x[index], self.terrain.z[index], math.tan(self.terrain.angle[index])
        start, stop = self.starts[index], self.stops[index]
        return (start, z - fall * (start - x)), (stop, z - fall * (stop - x))


def _turned(slope: float, roll: float) -> list[float]:
    """Quaternion that turns a level body down by `slope`, about +y, and then down to the left by `roll`."""
    about_y = [math.cos(slope / 2), 0.0, math.sin(slope / 2), 0.0]
    if roll == 0.0:
        return about_y
    cosine, sine = math.cos(roll / 2), math.sin(roll / 2)
    w, _, y, _ = about_y
    return [w * cosine, -w * sine, y * cosine, y * sine]


def _under(point: Point, depth: float, slope: float, roll: float) -> list[float]:
    """The place at a depth (m) under a point of the profile, along the normal of a body turned by `_turned`."""
    x, z = point
    lean, aside = depth * math.cos(roll), depth * math.sin(roll)
    return [x - lean * math.sin(slope), 0.0 - aside, z - lean * math.cos(slope)]  # no negative zero


def _add_riser(spec: mujoco.MjSpec, name: str, terrain: Terrain, index: int) -> None:
    """A frictionless plate behind the face of the step at a segment's start, up to the upper ground's height."""
    x, top, rise = terrain.x[index], terrain.z[index], terrain.rises[index]
    upper, lower = max(top, top - rise), min(top, top - rise) - _THICKNESS / 2
    inward = 1.0 if rise > 0.0 else -1.0
    place = [x + inward * (FOOT_RADIUS + _RISER_THICKNESS / 2), 0.0, (upper + lower) / 2]
    add_geom(spec, "riser", name, size=[_RISER_THICKNESS / 2, HALF_WIDTH, (upper - lower) / 2], pos=place)
