"""Marks in a scene: torques, ground force, slope estimate, reference posture, soles and paths of the feet.

They need only an `mujoco.MjvScene` and the values of an instant, so that videos and the viewer's `user_scn` show the
same marks.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from mjbiped.engines.mujoco.scenery import CUT
from mjbiped.records.loads import pressure_place
from mjbiped.records.signals import SIGNALS, torques_of
from mjbiped.rendering.scene import Moment, Points
from mjbiped.robots.robot import Robot
from mjbiped.utils import palette
from mjbiped.utils.mujoco import mujoco

FORCE_COLOUR, GHOST_COLOUR = palette.BLACK, "#595966"
"""Colours that colour-blind readers tell apart from each other, from those of the signals, and from the legs'."""

MOST_GEOMS = 600
"""Greatest number of geoms that `draw_marks` adds."""

LEGS = (palette.BLUE, palette.ORANGE)  # as in models/compass.xml
FRONT = -CUT - 0.03  # where torques and forces are drawn, y in leg lengths
_BEHIND = 0.12  # where the reference stands, y in leg lengths
_HALO = 0.005  # width of a torque's white edge on either side, in leg lengths
_WHITE = "#FFFFFF"

# in leg lengths, where they are lengths
_ARC_RADIUS = {"ankle": 0.15, "hip": 0.13, "knee": 0.11, "abduction": 0.16, "ankle_roll": 0.19}
_ARC_WIDTH = 0.012  # of the greatest torque
_THINNEST = 0.6  # arc, over that of the greatest torque
_ARC_SWEEP = math.radians(300.0)  # of the greatest torque
_ARC_PIECES = 24  # of the greatest torque's
_LEAST_SHARE = 4e-4  # of the greatest torque; less is not drawn
_HEAD = 0.05  # of an arc's arrow, at the greatest torque
FORCE_LENGTH = 0.27  # of one weight
MOST_WEIGHTS = 2.5
FORCE_WIDTH = 0.009
FORCE_HEAD = 0.05
ESTIMATE_REACH = 0.6
ESTIMATE_WIDTH = 0.0055
GHOST_WIDTH = 0.026
GHOST_OPACITY = 0.33
SPOT = (0.085, 0.05, 0.001)  # a shadow's half length, half width and half height
SPOT_FADES = 0.12  # height of a foot at which its shadow is gone
SPOT_OPACITY = 0.45
TRACE_PIXELS = 2.5
BAR, CAPSULE, LINE = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_LINE
_NOWHERE, _UPRIGHT = np.zeros(3), np.eye(3).ravel()  # of a geom that is put in its place later
_DECOR, _UNKNOWN = int(mujoco.mjtCatBit.mjCAT_DECOR), int(mujoco.mjtObj.mjOBJ_UNKNOWN)
_rgb = lru_cache(palette.rgb)  # a frame has a hundred bars in a few colours
_SOLE_WIDTH = 0.012
_PRESSED = 0.016


class Sign(NamedTuple):
    """A line of the legend.

    Attributes:
        colour: Colour of the mark, such as "#D55E00".
        name: Name of what it shows.
        mark: Kind of mark, in a word.
        value: Value with its unit; may be empty.
    """

    colour: str
    name: str
    mark: str
    value: str


def signs(moment: Moment, robot: Robot, elements: Collection[str]) -> Iterator[Sign]:
    """Lines of the legend at an instant: what the marks mean that are visible."""
    if "torque" in elements:
        for signal, torque in zip(torques_of(type(robot)), moment.torque, strict=True):
            yield Sign(signal.colour, f"{signal.name} torque", "arc", f"{signed(torque)} N m")
    if "force" in elements:
        yield Sign(FORCE_COLOUR, "ground force", "arrow", f"{math.hypot(*moment.force):.0f} N")
    if "estimate" in elements and math.isfinite(moment.slope_estimate):
        value = f"{signed(math.degrees(moment.slope_estimate))}°"
        yield Sign(SIGNALS["slope_estimate"].colour, "slope estimate", "line", value)
    if "ghost" in elements and moment.reference is not None:
        yield Sign(GHOST_COLOUR, "reference", "posture", "")


def signed(number: float) -> str:
    """Format a number with its sign and one digit; zero never has a minus sign."""
    return f"{round(number, 1) + 0.0:+.1f}".replace("-", "−")


class Scales(NamedTuple):
    """Values that are drawn at full size.

    Attributes:
        torque: Torque, N m, whose arc spans 300 degrees.
        force: Force, N, whose arrow is 0.27 leg lengths long, such as the robot's weight.
    """

    torque: float
    force: float


def draw_marks(scene: object, moment: Moment, robot: Robot, scales: Scales, elements: Collection[str]) -> None:
    """Add the elements of an instant to a scene; those beyond its capacity are left out.

    Args:
        scene: An `mujoco.MjvScene`.
        moment: The instant.
        robot: The robot, which sets the size of the marks.
        scales: Scales of torques and forces.
        elements: Names in `mjbiped.rendering.ELEMENTS`; those that are not in a scene are ignored.
    """
    length, limbs, pen = robot.leg_length, robot.bodies.limbs, Pen(scene, robot.leg_length)
    legs = _in_plane(robot.limbs(moment.qpos))
    foot, sole = legs[moment.stance][-1], None if robot.bodies.foot is not None else robot.sole
    for side, (_, limb, (height, slope), way) in enumerate(zip(legs, limbs, moment.ground, moment.traces, strict=True)):
        end, y = legs[side][-1], limb.across
        colour = LEGS[side if len(limbs) == len(LEGS) else 0]  # spokes of a wheel are of one colour
        clear = 1.0 - abs(end.imag - height) / (SPOT_FADES * length)
        if "shadows" in elements and clear > 0.0:
            spot, size = complex(end.real, height), np.multiply(SPOT, length)
            pen.blob(spot, y, size, slope, palette.BLACK, SPOT_OPACITY * clear)
        if sole is not None:  # parallel to the ground; being massless, it may be held so
            heel, toe = (end + cmath.rect(ahead, -slope) for ahead in (-sole[0], sole[1]))
            pen.connect(CAPSULE, heel, toe, y, _SOLE_WIDTH * length, colour)
        if "traces" in elements:  # fainter where they are older
            for number, (start, stop) in enumerate(pairwise(_in_plane(way)), start=1):
                pen.connect(LINE, start, stop, y, TRACE_PIXELS, colour, 0.15 + 0.75 * number / len(way))
    if "ghost" in elements and moment.reference is not None:
        for upper, lower in (pair for leg in _in_plane(robot.limbs(moment.reference)) for pair in pairwise(leg)):
            pen.connect(CAPSULE, upper, lower, _BEHIND, GHOST_WIDTH * length, GHOST_COLOUR, GHOST_OPACITY)
    if "estimate" in elements and math.isfinite(moment.slope_estimate):
        reach, colour = cmath.rect(ESTIMATE_REACH * length, -moment.slope_estimate), SIGNALS["slope_estimate"].colour
        pen.connect(BAR, foot - reach, foot + reach, -CUT - 0.01, ESTIMATE_WIDTH * length, colour)
    if "force" in elements:
        at = foot
        if robot.sole is not None:  # the centre of pressure, which stays within the sole
            forward, upward = moment.force
            place = pressure_place(robot, moment.torque[0], (forward, upward), moment.slope)
            place = min(max(place, -robot.sole[0]), robot.sole[1]) if math.isfinite(place) else 0.0
            at += cmath.rect(place, -moment.slope)
        _draw_force(pen, at, complex(*moment.force), scales.force)
        if robot.sole is not None:
            pen.blob(at, FRONT, [_PRESSED * length] * 3, 0.0, _WHITE)  # it moves on dark soles
    if "torque" in elements:
        lean, knee = robot.lean(moment.qpos, moment.stance), legs[(moment.stance + 1) % len(legs)][1]
        places, signals = ((foot, lean), (legs[0][0], 0.0), (knee, 0.0)), torques_of(type(robot))
        for joint, signal, torque, about in zip(robot.joints, signals, moment.torque, places, strict=False):
            share = torque / scales.torque if scales.torque else 0.0
            draw_torque(pen, about, share, joint, signal.colour)


def _in_plane(points: Points) -> Any:
    """Points x, z (m) as complex numbers, in nested lists."""
    return (points[..., 0] + 1j * points[..., 1]).tolist()


def arc_sweep(share: float) -> float:
    """Angle of the arc of a torque, given as a share of the greatest, rad; clockwise where positive, as the torque.

    Angle and width are proportional to the root, and the area to the torque.
    """
    return math.copysign(_ARC_SWEEP * math.sqrt(min(1.0, abs(share))), share)


def draw_torque(pen: Pen, place: tuple[complex, float], share: float, joint: str, colour: str) -> None:
    """Draw an arc with an arrowhead about a joint, its middle at an angle from the vertical (rad)."""
    if not abs(share) >= _LEAST_SHARE:  # NaN is not
        return
    (centre, middle), length, sweep = place, pen.length, arc_sweep(share)
    size = max(_THINNEST, math.sqrt(min(1.0, abs(share)))) * length
    radius, width, head = _ARC_RADIUS[joint] * length, _ARC_WIDTH * size, _HEAD * size

    def at(angle: float, out: float = radius) -> complex:
        return centre + cmath.rect(out, 0.5 * math.pi - angle)

    pieces = max(2, math.ceil(_ARC_PIECES * abs(sweep) / _ARC_SWEEP))
    angles = [middle + sweep * (piece / pieces - 0.5) for piece in range(pieces + 1)]
    overlap = math.copysign(0.3 * width / radius, sweep)  # of neighbouring pieces, which have square ends
    bars = [(at(start - overlap), at(stop + overlap)) for start, stop in pairwise(angles)]
    # two barbs, a little bent inward as the arc is
    back = angles[-1] - math.copysign(head / radius, sweep)
    bars += [(at(angles[-1]), at(back, out)) for out in (radius + 0.6 * head, radius - 0.6 * head)]
    for y, wide, shade in ((FRONT + _HALO, width + _HALO * length, _WHITE), (FRONT - width, width, colour)):
        for start, stop in bars:
            pen.connect(BAR, start, stop, y, wide, shade)


def _draw_force(pen: Pen, foot: complex, force: complex, scale: float) -> None:
    """Draw an arrow that pushes the foot from below."""
    weights = abs(force) / scale
    if 0.0 < weights < math.inf:
        along = force / abs(force) * pen.length
        tail = foot - min(weights, MOST_WEIGHTS) * FORCE_LENGTH * along
        for end in (tail, foot - FORCE_HEAD * along * (1.0 - 0.55j), foot - FORCE_HEAD * along * (1.0 + 0.55j)):
            pen.connect(BAR, end, foot, FRONT, FORCE_WIDTH * pen.length, FORCE_COLOUR)


class Pen:
    """Adds geoms without shadows to a scene, in planes of y in leg lengths.

    Attributes:
        length: Length of a leg, m.
    """

    def __init__(self, scene: mujoco.MjvScene, length: float) -> None:
        """Prepare to draw in a scene."""
        self._scene, self._geoms, self.length = scene, scene.geoms, length  # `geoms` makes objects each time

    def connect(
        self, kind: int, start: complex, stop: complex, y: float, width: float, colour: str, opacity: float = 1.0
    ) -> None:
        """Connect two points x + iz (m) by a capsule or a square bar of half width `width` (m), or by a line.

        A line is `width` pixels wide. Nothing connects a point with itself, or with none.
        """
        if 0.0 < abs(stop - start) < math.inf:
            self.join(kind, self.at(start, y), self.at(stop, y), width, colour, opacity)

    def at(self, place: complex, y: float) -> Points:
        """The place of a point x + iz, m, in a plane of y, in leg lengths."""
        return np.array((place.real, y * self.length, place.imag))

    def join(self, kind: int, start: Points, stop: Points, width: float, colour: str, opacity: float = 1.0) -> None:
        """Connect two places as `connect` does."""
        geom = self.add(kind, _NOWHERE, _NOWHERE, _UPRIGHT, (*_rgb(colour), opacity))
        if geom is not None:
            mujoco.mjv_connector(geom, CAPSULE if kind == BAR else kind, width, start, stop)
            geom.type = kind  # MuJoCo's connectors are round: a bar has the place and size of a capsule

    def blob(self, place: complex, y: float, size: object, slope: float, colour: str, opacity: float = 1.0) -> None:
        """Add an ellipsoid of three half axes (m) at a point x + iz (m), tilted by a slope (rad)."""
        cosine, sine, centre = math.cos(slope), math.sin(slope), (place.real, y * self.length, place.imag)
        frame, rgba = np.array((cosine, 0.0, sine, 0.0, 1.0, 0.0, -sine, 0.0, cosine)), (*_rgb(colour), opacity)
        self.add(mujoco.mjtGeom.mjGEOM_ELLIPSOID, np.array(size), np.array(centre), frame, rgba)

    def add(self, kind: int, size: Points, place: Points, frame: Points, rgba: Iterable[float]) -> Any:
        """Add a geom; return None if the scene is full.

        Args:
            kind: Kind of geom, of `mujoco.mjtGeom`.
            size: Size, three numbers, m.
            place: Centre, m.
            frame: Axes, nine numbers.
            rgba: Colour and opacity, each from 0 to 1.

        Returns:
            The geom; emission, specular and shininess are zero.
        """
        if self._scene.ngeom >= self._scene.maxgeom:
            return None
        geom = self._geoms[self._scene.ngeom]
        mujoco.mjv_initGeom(geom, kind, size, place, frame, np.array([*rgba], dtype=np.float32))
        # mjv_initGeom leaves these as they are in memory, and pixels depend on them
        geom.category, geom.objtype, geom.objid, geom.segid = _DECOR, _UNKNOWN, -1, -1
        geom.emission, geom.specular, geom.shininess = 0.0, 0.0, 0.0
        self._scene.ngeom += 1
        return geom
