"""Marks in a scene: torques, ground force, slope estimate, reference posture, soles and paths of the feet.

They need only an `mujoco.MjvScene` and the values of an instant, so that videos and the viewer's `user_scn` show the
same marks.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from mjbiped.engines.mujoco.scenery import CUT
from mjbiped.records.loads import pressure_place
from mjbiped.records.signals import SIGNALS, torques_of
from mjbiped.rendering.moments import Moment, Pair, Points
from mjbiped.robots.robot import Robot
from mjbiped.utils import palette
from mjbiped.utils.mujoco import mujoco

FORCE_COLOUR, GHOST_COLOUR = palette.BLACK, "#595966"
"""Colours that colour-blind readers tell apart from each other, from those of the signals, and from the legs'."""

MOST_GEOMS = 600
"""Greatest number of geoms that `draw_marks` adds."""

_LEGS = (palette.BLUE, palette.ORANGE)  # as in models/compass.xml
_FRONT = -CUT - 0.03  # where torques and forces are drawn, y in leg lengths
_BEHIND = 0.12  # where the reference stands, y in leg lengths
_HALO = 0.005  # width of a torque's white edge on either side, in leg lengths
_WHITE = "#FFFFFF"

# in leg lengths, where they are lengths
_ARC_RADIUS = {"ankle": 0.15, "hip": 0.13, "knee": 0.11}
_ARC_WIDTH = 0.012  # of the greatest torque
_THINNEST = 0.6  # arc, over that of the greatest torque
_ARC_SWEEP = math.radians(300.0)  # of the greatest torque
_ARC_PIECES = 24  # of the greatest torque's
_LEAST_SHARE = 4e-4  # of the greatest torque; less is not drawn
_HEAD = 0.05  # of an arc's arrow, at the greatest torque
_FORCE_LENGTH = 0.27  # of one weight
_MOST_WEIGHTS = 2.5
_FORCE_WIDTH = 0.009
_FORCE_HEAD = 0.05
_ESTIMATE_REACH = 0.6
_ESTIMATE_WIDTH = 0.0055
_GHOST_WIDTH = 0.026
_GHOST_OPACITY = 0.33
_SPOT = (0.085, 0.05, 0.001)  # a shadow's half length, half width and half height
_SPOT_FADES = 0.12  # height of a foot at which its shadow is gone
_SPOT_OPACITY = 0.45
_TRACE_PIXELS = 2.5
_BAR = mujoco.mjtGeom.mjGEOM_BOX
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
        elements: Names in `mjbiped.rendering.look.ELEMENTS`; those that are not in a scene are ignored.
    """
    length = robot.leg_length
    pen = _Pen(scene, length)
    hip = (moment.qpos[0], moment.qpos[1])
    angle = robot.lean(moment.qpos, moment.stance)
    across = [limb.across for limb in robot.bodies.limbs]
    colours = _LEGS if len(across) == len(_LEGS) else _LEGS[:1] * len(across)  # spokes of a wheel are of one colour
    legs: list[list[Pair]] = robot.limbs(moment.qpos).tolist()
    foot = legs[moment.stance][-1]
    if "shadows" in elements:
        for side, (height, slope) in enumerate(moment.ground):
            _draw_shadow(pen, legs[side][-1], height, slope, across[side], length)
    if robot.sole is not None and robot.bodies.foot is None:
        for side, (_, slope) in enumerate(moment.ground):
            _draw_sole(pen, legs[side][-1], slope, robot.sole, across[side], colours[side])
    if "traces" in elements:
        for side, way in enumerate(moment.traces):
            _draw_trace(pen, way, across[side], colours[side])
    if "ghost" in elements and moment.reference is not None:
        _draw_ghost(pen, moment.reference, robot)
    if "estimate" in elements and math.isfinite(moment.slope_estimate):
        along = (math.cos(moment.slope_estimate), -math.sin(moment.slope_estimate))
        reach = _ESTIMATE_REACH * length
        back, ahead = ((foot[0] + way * along[0], foot[1] + way * along[1]) for way in (-reach, reach))
        pen.bar(back, ahead, -CUT - 0.01, _ESTIMATE_WIDTH * length, SIGNALS["slope_estimate"].colour)
    if "force" in elements:
        at = foot if robot.sole is None else pressed(robot, moment, foot)
        _draw_force(pen, at, moment.force, scales.force, length)
        if robot.sole is not None:
            pen.blob(at, _FRONT, [_PRESSED * length] * 3, 0.0, _WHITE)  # it moves on dark soles
    if "torque" in elements:
        places = ((foot, angle), (hip, 0.0), (legs[(moment.stance + 1) % len(legs)][1], 0.0))
        signals = torques_of(type(robot))
        for joint, signal, torque, (place, middle) in zip(robot.joints, signals, moment.torque, places, strict=False):
            share = torque / scales.torque if scales.torque else 0.0
            _draw_torque(pen, place, middle, share, joint, signal.colour, length)


def arc_sweep(share: float) -> float:
    """Angle of the arc of a torque, given as a share of the greatest, rad; clockwise where positive, as the torque.

    Angle and width are proportional to the root, and the area to the torque.
    """
    return math.copysign(_ARC_SWEEP * math.sqrt(min(1.0, abs(share))), share)


def _draw_torque(pen: _Pen, centre: Pair, middle: float, share: float, joint: str, colour: str, length: float) -> None:
    """Draw an arc with an arrowhead about a joint, its middle at an angle from the vertical (rad)."""
    if not abs(share) >= _LEAST_SHARE:  # NaN is not
        return
    sweep, strength = arc_sweep(share), math.sqrt(min(1.0, abs(share)))
    radius, width = _ARC_RADIUS[joint] * length, _ARC_WIDTH * length * max(_THINNEST, strength)

    def place(angle: float, out: float = radius) -> Pair:
        return centre[0] + out * math.sin(angle), centre[1] + out * math.cos(angle)

    pieces = max(2, math.ceil(_ARC_PIECES * abs(sweep) / _ARC_SWEEP))
    angles = [middle + sweep * (piece / pieces - 0.5) for piece in range(pieces + 1)]
    overlap = math.copysign(0.3 * width / radius, sweep)  # of neighbouring pieces, which have square ends
    bars = [(place(start - overlap), place(stop + overlap)) for start, stop in pairwise(angles)]
    # two barbs, a little bent inward as the arc is
    head = _HEAD * length * max(_THINNEST, strength)
    back = angles[-1] - math.copysign(head / radius, sweep)
    bars += [(place(angles[-1]), place(back, out)) for out in (radius + 0.6 * head, radius - 0.6 * head)]
    for bar in bars:
        pen.bar(*bar, _FRONT + _HALO, width + _HALO * length, _WHITE)
    for bar in bars:
        pen.bar(*bar, _FRONT - width, width, colour)


def pressed(robot: Robot, moment: Moment, foot: Pair) -> Pair:
    """The centre of pressure in the sole, x and z in m, by the point below the ankle; it stays within the sole."""
    behind, ahead = robot.sole or (0.0, 0.0)
    place = pressure_place(robot, moment.torque[0], moment.force, moment.slope)
    place = min(max(place, -behind), ahead) if math.isfinite(place) else 0.0
    return foot[0] + place * math.cos(moment.slope), foot[1] - place * math.sin(moment.slope)


def _draw_force(pen: _Pen, foot: Pair, force: Pair, scale: float, length: float) -> None:
    """Draw an arrow that pushes the foot from below."""
    weights = math.hypot(*force) / scale
    if not 0.0 < weights < math.inf:
        return
    factor = min(weights, _MOST_WEIGHTS) / weights * _FORCE_LENGTH * length / scale
    tail = (foot[0] - factor * force[0], foot[1] - factor * force[1])
    pen.bar(tail, foot, _FRONT, _FORCE_WIDTH * length, FORCE_COLOUR)
    head = _FORCE_HEAD * length / math.hypot(*force)
    for turned in (-0.55, 0.55):
        barb = (foot[0] - head * (force[0] + turned * force[1]), foot[1] - head * (force[1] - turned * force[0]))
        pen.bar(foot, barb, _FRONT, _FORCE_WIDTH * length, FORCE_COLOUR)


def _draw_ghost(pen: _Pen, posture: Sequence[float], robot: Robot) -> None:
    """Draw a translucent posture, both legs from hip to foot."""
    capsule, width = mujoco.mjtGeom.mjGEOM_CAPSULE, _GHOST_WIDTH * robot.leg_length
    for points in robot.limbs(posture).tolist():
        for upper, lower in pairwise(points):
            pen.connect(capsule, upper, lower, _BEHIND, width, GHOST_COLOUR, _GHOST_OPACITY)


def _draw_shadow(pen: _Pen, foot: Pair, height: float, slope: float, y: float, length: float) -> None:
    """Draw a dark spot on the ground under a foot."""
    clear = 1.0 - abs(foot[1] - height) / (_SPOT_FADES * length)
    if not clear > 0.0:
        return
    pen.blob((foot[0], height), y, np.multiply(_SPOT, length), slope, palette.BLACK, _SPOT_OPACITY * clear)


def _draw_sole(pen: _Pen, foot: Pair, slope: float, sole: Pair, y: float, colour: str) -> None:
    """Draw the sole of a foot, parallel to the ground under it; being massless, it may be held so."""
    cosine, sine, (behind, ahead) = math.cos(slope), math.sin(slope), sole
    heel = foot[0] - behind * cosine, foot[1] + behind * sine
    toe = foot[0] + ahead * cosine, foot[1] - ahead * sine
    pen.connect(mujoco.mjtGeom.mjGEOM_CAPSULE, heel, toe, y, _SOLE_WIDTH * pen.length, colour)


def _draw_trace(pen: _Pen, way: Points, y: float, colour: str) -> None:
    """Draw the path of a foot, fainter where it is older."""
    points = way.tolist()
    for number, (start, stop) in enumerate(pairwise(points)):
        opacity = 0.15 + 0.75 * (number + 1) / len(points)
        pen.connect(mujoco.mjtGeom.mjGEOM_LINE, start, stop, y, _TRACE_PIXELS, colour, opacity)


class _Pen:
    """Adds geoms to a scene, in planes of y in leg lengths."""

    def __init__(self, scene: mujoco.MjvScene, length: float) -> None:
        self._add, self.length = partial(add_geom, scene, scene.geoms), length

    def connect(
        self, kind: int, start: Pair, stop: Pair, y: float, width: float, colour: str, opacity: float = 1.0
    ) -> None:
        """Connect two points x, z (m) of the plane at y by a capsule or bar of half width `width` (m), or by a line.

        A line is `width` pixels wide. Nothing connects a point with itself, or with none.
        """
        if not 0.0 < math.dist(start, stop) < math.inf:
            return
        geom = self._add(kind, _NOWHERE, _NOWHERE, _UPRIGHT, (*_rgb(colour), opacity))
        if geom is not None:
            ends = (np.array((x, y * self.length, z)) for x, z in (start, stop))
            mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE if kind == _BAR else kind, width, *ends)
            geom.type = kind  # MuJoCo's connectors are round: a bar has the place and size of a capsule

    def bar(self, start: Pair, stop: Pair, y: float, width: float, colour: str) -> None:
        """Connect two points by a square bar."""
        self.connect(_BAR, start, stop, y, width, colour)

    def blob(self, place: Pair, y: float, size: object, slope: float, colour: str, opacity: float = 1.0) -> None:
        """Add an ellipsoid of three half axes (m) at a point x, z (m) of the plane at y, tilted by a slope (rad)."""
        cosine, sine, centre = math.cos(slope), math.sin(slope), (place[0], y * self.length, place[1])
        frame, rgba = np.array((cosine, 0.0, sine, 0.0, 1.0, 0.0, -sine, 0.0, cosine)), (*_rgb(colour), opacity)
        self._add(mujoco.mjtGeom.mjGEOM_ELLIPSOID, np.array(size), np.array(centre), frame, rgba)


def add_geom(
    scene: mujoco.MjvScene,
    geoms: Sequence[object],
    kind: object,
    size: Any,
    place: object,
    frame: Any,
    rgba: tuple[float, ...],
) -> Any:
    """Add a geom without shadows to a scene; return None if the scene is full.

    Args:
        scene: A `mujoco.MjvScene`.
        geoms: `scene.geoms`, which makes new objects each time it is read.
        kind: Kind of geom, of `mujoco.mjtGeom`.
        size: Size, three numbers, m.
        place: Centre, m.
        frame: Axes, nine numbers.
        rgba: Colour and opacity, each from 0 to 1.

    Returns:
        The geom; emission, specular and shininess are zero.
    """
    if scene.ngeom >= scene.maxgeom:
        return None
    geom = geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, size, place, frame, np.array(rgba, dtype=np.float32))
    # mjv_initGeom leaves these as they are in memory, and pixels depend on them
    geom.category, geom.objtype, geom.objid, geom.segid = _DECOR, _UNKNOWN, -1, -1
    geom.emission, geom.specular, geom.shininess = 0.0, 0.0, 0.0
    scene.ngeom += 1
    return geom
