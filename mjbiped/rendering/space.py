"""Pictures of robots in space: their moments, marks in planes that stand with the robot, and ground that fades away."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from contextlib import AbstractContextManager
from itertools import pairwise
from typing import Any

import numpy as np

from mjbiped.engines.mujoco.surface import tile_edge
from mjbiped.records.record import Walk
from mjbiped.records.signals import SIGNALS, torques_of
from mjbiped.rendering import marks
from mjbiped.rendering.marks import Pen, Scales
from mjbiped.rendering.overlay import Overlay, Pixels, View
from mjbiped.rendering.scene import Moment, Moments, Points, PosedScene, latest_sample
from mjbiped.rendering.stage import HORIZON, ZENITH, Film, Stage, caption
from mjbiped.robots.footing import Footing
from mjbiped.robots.in_space import InSpace, pull_of
from mjbiped.robots.robot import Robot
from mjbiped.utils import palette
from mjbiped.utils.mujoco import mujoco

_CLEAR, _FADED = 7.0, 18.0  # distances from the camera between which the ground fades, in leg lengths
_AMBIENT, _FROM_CAMERA = 0.36, 0.12  # light that has no direction, and light from the camera: the sun shows bumps
_BESIDE = 0.07  # distance of a torque's plane from its joint, in leg lengths
_ACROSS = 0.45  # length of the estimate's line across, over that along
_LIFT = 0.006  # height of the estimate's lines over the plane, in leg lengths: as half their width
_GHOST = 0.5  # width of the reference, which stands in the robot, over that of a planar one
_SOLE = 0.006  # half thickness of a sole, in leg lengths
_SOLE_WIDTH = 0.06  # of a sole that is told none, in leg lengths


def open_stage(walk: Walk, film: Film) -> AbstractContextManager[Stage]:
    """Build the scene of a walk, planar or in space, and a canvas for it; see `Stage.open`."""
    return (SpaceStage if isinstance(walk.robot, InSpace) else Stage).open(walk, film)


def moments_of(walk: Walk, *, ghost: bool = True) -> Moments:
    """Instants of a record, planar or in space."""
    return (SpaceMoments if isinstance(walk.robot, InSpace) else Moments)(walk, ghost=ghost)


def scene_of(walk: Walk) -> PosedScene:
    """Scene of a walk, planar or in space."""
    return (SpaceScene if isinstance(walk.robot, InSpace) else PosedScene)(walk)


def draw_marks(scene: object, moment: Moment, robot: Robot, scales: Scales, elements: Collection[str]) -> None:
    """Add the elements of an instant to a scene; see `mjbiped.rendering.marks.draw_marks`."""
    if moment.footing is None:
        marks.draw_marks(scene, moment, robot, scales, elements)
    else:
        _draw_in_space(_Pen(scene, robot.leg_length), moment, robot, scales, elements)


class SpaceMoments(Moments):
    """Instants of a record of a robot in space."""

    _robot: InSpace

    def at(self, time: float) -> Moment:
        """Return the instant at a time (s) of the record; see `Moments.at`."""
        seen, samples = super().at(time), self._walk.samples
        latest = latest_sample(samples["time"], time)
        return seen._replace(
            footing=self._footing(np.array(seen.qpos), seen.stance),
            lateral_estimate=float(samples["lateral_estimate"][latest]),
        )

    def _points(self, qpos: Points) -> Points:
        return self._robot.points(qpos)

    def _footing(self, qpos: Points, stance: int) -> Footing:
        x, y, _ = self._robot.points(qpos)[stance, -1].tolist()
        return self._robot.footing(qpos, stance, self._walk.terrain.normal_at(x, y))

    def _force(self, latest: int, stance: int, slope: float, *, locked: bool) -> tuple[float, ...]:
        samples = self._walk.samples
        footing = self._footing(samples["qpos"][latest], stance)
        q, dq, torque = (samples[name][latest] for name in ("q", "dq", "torque"))
        ahead, aside, normal = self._robot.force_on_foot(q, dq, torque, footing.pull, locked=locked)
        return tuple((ahead * footing.forward + aside * footing.aside + normal * footing.normal).tolist())

    def _beside(self, qpos: Points, stance: int, slope: float, tracked: Sequence[float] | None) -> Any:
        terrain, feet = self._walk.terrain, self._robot.points(qpos)[:, -1].tolist()
        ground = tuple((terrain.height_at(x, y), terrain.normal_at(x, y)) for x, y, _ in feet)
        reference = None
        if tracked is not None and np.isfinite(tracked).all():
            posture = self._footing(qpos, stance).posture(self._robot, np.array(tracked))
            reference = tuple(posture.tolist())
        return feet, ground, reference


class SpaceScene(PosedScene):
    """Scene of a walk of a robot in space."""

    def go_to(self, x: float) -> bool:
        """Build the ground about a hip at x (m), which fades into the sky; see `PosedScene.go_to`."""
        made = super().go_to(x)
        if made:
            vis, unit = self.model.vis, self._length / self.model.stat.extent
            vis.headlight.ambient[:], vis.headlight.diffuse[:] = _AMBIENT, _FROM_CAMERA
            vis.map.shadowclip, vis.quality.shadowsize = 8.0, 4096
            vis.map.fogstart, vis.map.fogend, vis.rgba.fog[:] = _CLEAR * unit, _FADED * unit, (*HORIZON, 1.0)
        return made

    def _rates(self, moment: Moment, dq: Points) -> Sequence[float]:
        robot, footing = self._robot, moment.footing
        assert isinstance(robot, InSpace)
        assert footing is not None
        q = self._samples["q"][latest_sample(self._samples["time"], moment.time)]
        rates: list[float] = footing.rates(robot, q, dq).tolist()
        return rates


class SpaceStage(Stage):
    """Scene and canvas for a walk of a robot in space."""

    def _prepare(self, walk: Walk, film: Film) -> None:
        self._moments, self._posed = moments_of(walk, ghost="ghost" in film.look.elements), scene_of(walk)

    def _go_to(self, x: float) -> None:
        super()._go_to(x)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = not self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX]

    def _draw_marks(self, moment: Moment) -> None:
        draw_marks(self._scene, moment, self._robot, self._scales, self._look.elements)

    def _paint_sky(self, picture: Pixels, view: View) -> None:
        """Let the colour of what has faded away, such as the sky, deepen from the horizon upwards."""
        if not self._scene.flags[mujoco.mjtRndFlag.mjRND_FOG]:
            return
        horizon = np.round(255 * np.array(HORIZON)).astype(np.uint8)
        height = picture.shape[0]
        tilt = math.atan2(float(-view.axes[2][2]), float(np.hypot(*view.axes[2][:2])))
        level = height if view.orthographic else 0.5 * height * (1.0 + math.tan(tilt) / view.half)
        share = np.clip((level - np.arange(height)) / height, 0.0, 1.0)[:, None]
        colours = np.round(255 * (np.array(HORIZON) + share * np.subtract(ZENITH, HORIZON))).astype(np.uint8)
        rows, columns = np.nonzero((picture == horizon).all(axis=2))
        picture[rows, columns] = colours[rows]

    def _write(self, over: Overlay, moment: Moment, view: View, outcome: str) -> None:
        """Write words and signs over the picture."""
        if "caption" in self._look.elements:
            right, low = over.caption(self._caption(moment))
            over.legend(marks.signs(moment, self._robot, self._look.elements), (right, low), outcome)

    def _caption(self, moment: Moment) -> list[str]:
        """Lines of the caption: slopes along the heading and to the left, and the size of the tiles."""
        first, along, *pace = caption(moment, self._film.slow_motion)
        footing = moment.footing
        assert footing is not None
        across = f"to the left {marks.signed(math.degrees(footing.lateral))}°"
        if not math.isnan(moment.lateral_estimate):
            across += f"   estimate {marks.signed(math.degrees(moment.lateral_estimate))}°"
        tiles = [f"tiles {100.0 * tile_edge(self._robot.leg_length):g} cm"] if "scale" in self._look.elements else []
        return [first, along, across, *tiles, *pace]


class _Pen(Pen):
    """Draws in planes that stand anywhere in space.

    Attributes:
        plane: Origin of the plane (m), then its directions to the right, upward and away from who looks at it.
    """

    plane: tuple[Points, Points, Points, Points]

    def at(self, place: complex, y: float) -> Points:
        """The place of a point of the plane, whose marks lie before each other; see `Pen.at`."""
        origin, right, up, away = self.plane
        return np.asarray(origin + place.real * right + place.imag * up + (y - marks.FRONT) * self.length * away)

    def lie(self, kind: int, place: Points, size: Iterable[float], ahead: Points, normal: Points, rgba: Any) -> None:
        """Add a body that lies on ground with a normal, its length ahead."""
        frame = np.stack([ahead, np.cross(normal, ahead), normal], axis=1)
        self.add(kind, np.array([*size]), place, frame.ravel(), rgba)


def _draw_in_space(pen: _Pen, moment: Moment, robot: Robot, scales: Scales, elements: Collection[str]) -> None:
    """Draw the elements of an instant."""
    footing, length = moment.footing, robot.leg_length
    assert isinstance(robot, InSpace)
    assert footing is not None
    legs = robot.points(moment.qpos)
    for side, ((height, upright), way) in enumerate(zip(moment.ground, moment.traces, strict=True)):
        foot: Points = legs[side, -1]
        normal = np.asarray(upright)
        clear = 1.0 - abs(foot[2] - height) / (marks.SPOT_FADES * length)
        ahead = np.cross(footing.aside * -footing.to_left, normal) * -1.0
        ahead /= np.linalg.norm(ahead)
        if "shadows" in elements and clear > 0.0:
            spot, ink = np.array([foot[0], foot[1], height]), (0.0, 0.0, 0.0, marks.SPOT_OPACITY * clear)
            pen.lie(mujoco.mjtGeom.mjGEOM_ELLIPSOID, spot, np.multiply(marks.SPOT, length), ahead, normal, ink)
        if robot.sole is not None or robot.sole_width is not None:  # being massless, it may be held as it is
            behind, before = robot.sole or (0.5 * _SOLE_WIDTH * length,) * 2
            size = 0.5 * (behind + before), 0.5 * (robot.sole_width or _SOLE_WIDTH * length), _SOLE * length
            middle = foot + 0.5 * (before - behind) * ahead + _SOLE * length * normal
            pen.lie(marks.BAR, middle, size, ahead, normal, (*palette.rgb(marks.LEGS[side]), 1.0))
        if "traces" in elements:  # fainter where they are older
            for number, (start, stop) in enumerate(pairwise(way), start=1):
                if not np.array_equal(start, stop):
                    faint = 0.15 + 0.75 * number / len(way)
                    pen.join(marks.LINE, start, stop, marks.TRACE_PIXELS, marks.LEGS[side], faint)
    if "ghost" in elements and moment.reference is not None:
        for upper, lower in (pair for leg in robot.points(moment.reference) for pair in pairwise(leg)):
            wide = _GHOST * marks.GHOST_WIDTH * length
            pen.join(marks.CAPSULE, upper, lower, wide, marks.GHOST_COLOUR, marks.GHOST_OPACITY)
    if "estimate" in elements and math.isfinite(moment.slope_estimate):
        _draw_estimate(pen, moment, footing)
    if "force" in elements:
        _draw_force(pen, footing.place, np.array(moment.force), scales.force)
    if "torque" in elements:
        _draw_torques(pen, moment, robot, footing, scales)


def _draw_estimate(pen: _Pen, moment: Moment, footing: Footing) -> None:
    """Draw a cross through the stance foot, in the plane that the controller takes the ground for."""
    lateral = 0.0 if math.isnan(moment.lateral_estimate) else moment.lateral_estimate
    pull = pull_of(moment.slope_estimate, lateral)
    reach, colour = marks.ESTIMATE_REACH * pen.length, SIGNALS["slope_estimate"].colour
    middle = footing.place + _LIFT * pen.length * footing.normal
    lines = [(footing.forward, pull[0], reach)]
    if not math.isnan(moment.lateral_estimate):
        lines.append((footing.aside * footing.to_left, pull[2], _ACROSS * reach))
    for along, fall, far in lines:
        flat = np.array([along[0], along[1], 0.0])
        line = math.sqrt(1.0 - fall * fall) * flat / np.linalg.norm(flat) - fall * np.array([0.0, 0.0, 1.0])
        ends = middle - far * line, middle + far * line
        pen.join(marks.BAR, *ends, marks.ESTIMATE_WIDTH * pen.length, colour)


def _draw_force(pen: _Pen, foot: Points, force: Points, scale: float) -> None:
    """Draw an arrow that pushes the foot from below, or what is seen of it."""
    size = float(np.linalg.norm(force))
    if not 0.0 < size < math.inf or len(force) < 3:
        return
    along = force / size * pen.length
    tail = foot + min(size / scale, marks.MOST_WEIGHTS) * marks.FORCE_LENGTH * along
    barb = np.cross(along, [0.0, 1.0, 0.0])
    pen.join(marks.BAR, foot, tail, marks.FORCE_WIDTH * pen.length, marks.FORCE_COLOUR)
    for side in (0.55, -0.55):
        end = tail - marks.FORCE_HEAD * (along + side * barb)
        pen.join(marks.BAR, end, tail, marks.FORCE_WIDTH * pen.length, marks.FORCE_COLOUR)


def _draw_torques(pen: _Pen, moment: Moment, robot: InSpace, footing: Footing, scales: Scales) -> None:
    """Draw the arcs of all torques: those of pitch in planes beside the robot, that of the roll in one before it."""
    legs = robot.points(moment.qpos)
    left = legs[0, 0] - legs[1, 0]
    left /= np.linalg.norm(left)
    ahead = np.cross(left, [0.0, 0.0, 1.0])
    ahead /= np.linalg.norm(ahead)
    over, beside = np.cross(ahead, left), -_BESIDE * pen.length
    lean, foot = robot.lean(moment.qpos, moment.stance), legs[moment.stance, -1]
    hip, knee = legs[:, 0].mean(axis=0), legs[1 - moment.stance, 1]
    side = (beside - 0.5 * robot.hip_width) * left
    to_stance = -footing.to_left * left  # a positive torque rolls the robot to its stance side
    planes = {
        "ankle": ((foot + beside * left, ahead, over, left), lean),
        "hip": ((hip + side, ahead, over, left), 0.0),
        "knee": ((knee + beside * left, ahead, over, left), 0.0),
        "abduction": ((hip - beside * ahead, to_stance, over, -ahead), 0.0),
        "ankle_roll": ((foot - beside * ahead, to_stance, over, -ahead), 0.0),
    }
    for joint, signal, torque in zip(robot.joints, torques_of(type(robot)), moment.torque, strict=True):
        pen.plane, middle = planes[joint]
        share = torque / scales.torque if scales.torque else 0.0
        marks.draw_torque(pen, (0j, middle), share, joint, signal.colour)
