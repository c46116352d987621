"""Draws a walk's frames: the scene built anew from the record, what explains it in the scene and over it, the chart."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import mujoco
import numpy as np

from mjbiped.errors import InputError, shown
from mjbiped.records.record import Walk
from mjbiped.records.signals import torques_of
from mjbiped.rendering import marks
from mjbiped.rendering.camera import View, smooth_offsets
from mjbiped.rendering.canvas import Canvas
from mjbiped.rendering.chart import Chart
from mjbiped.rendering.geoms import add_geom
from mjbiped.rendering.ground_labels import lay_ground_labels
from mjbiped.rendering.look import Look, show_section
from mjbiped.rendering.marks import MOST_GEOMS, Scales, draw_marks
from mjbiped.rendering.moments import Moment, Moments
from mjbiped.rendering.overlay import Pixels, Sign, lay_caption, lay_legend, lay_scale, letter_size
from mjbiped.rendering.posed import PosedScene
from mjbiped.utils.palette import rgb

_CHART_SHARE = 0.27  # of a frame's height
_LOWEST_WITH_CHART = 240  # pixels; a lower frame has no room for it
_SKY = (0.70, 0.715, 0.73)  # what becomes almost white in the scene's light
_FAR, _WIDE = 40.0, 60.0  # distance of the plain background from the camera and half its size, in leg lengths
_ONE_AT_A_TIME = threading.Lock()


class Stage:
    """A scene and a canvas, on which the postures of a walk are drawn; on a long terrain, one about each place."""

    def __init__(
        self,
        walk: Walk,
        size: tuple[int, int],
        camera: str,
        look: Look,
        part: tuple[float, float],
        slow_motion: float,
        open_now: ExitStack,
    ) -> None:
        """As `open`, which is to be called instead."""
        self._walk, self._robot, self._terrain = walk, walk.robot, walk.terrain
        self._name, self._look, self._slow_motion, self._open = camera, look, slow_motion, open_now
        width, height = size
        charted = "chart" in look.elements and height >= _LOWEST_WITH_CHART
        chart_height = round(height * _CHART_SHARE) if charted else 0
        self._chart = Chart(walk, *part, width, chart_height) if charted else None
        self._width, self._height, self._picture = width, height, height - chart_height
        self._moments = Moments(walk, ghost="ghost" in look.elements)
        self._scales = Scales(self._moments.greatest_torque(*part), self._robot.weight)
        self._smooth = np.ascontiguousarray(smooth_offsets(walk).T)
        self._posed = PosedScene(walk)
        self._go_to(self._moments.at(part[0]).qpos[0])

    @classmethod
    @contextmanager
    def open(
        cls,
        walk: Walk,
        width: int,
        height: int,
        camera: str,
        look: Look,
        *,
        part: tuple[float, float] | None = None,
        slow_motion: float = 1.0,
    ) -> Iterator[Stage]:
        """Build the scene and a canvas for it; one at a time per process.

        Args:
            walk: A record with samples.
            width: Of the frames, pixels.
            height: Of the frames, pixels.
            camera: Its name.
            look: What is shown.
            part: Of the record that is shown, first and last time, s; all unless given.
            slow_motion: For the caption.

        Raises:
            InputError: There is no such camera.
            RenderError: No OpenGL platform works.
        """
        time = walk.samples["time"]
        whole = (float(time[0]), float(time[-1]))
        with _ONE_AT_A_TIME, ExitStack() as stack:
            yield cls(walk, (width, height), camera, look, part or whole, slow_motion, stack)

    @property
    def tracks(self) -> bool:
        """Whether the posture that the controller tracked is drawn."""
        return self._moments.tracks

    def _go_to(self, x: float) -> None:
        """Build the scene about a place, m, in place of the one before, where that does not reach so far."""
        if not self._posed.go_to(x):
            return
        model = self._posed.model
        names = [model.camera(index).name for index in range(model.ncam)]
        if self._name not in names:
            raise InputError(f"unknown camera {shown(self._name)}; valid are {', '.join(names)}")
        self._open.close()
        canvas = Canvas(model, self._width, self._picture)
        self._open.callback(canvas.close)
        self._canvas = canvas
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + MOST_GEOMS + 200)
        self._option, self._eye = mujoco.MjvOption(), mujoco.MjvCamera()
        show_section(self._option)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = 0
        for flag, value in self._look.visual.items():
            self._option.flags[flag] = value
        for flag, value in self._look.rendering.items():
            self._scene.flags[flag] = value
        self._camera = names.index(self._name)
        self._eye.type, self._eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, self._camera

    def frame(self, time: float, *, with_outcome: bool = False) -> Pixels:
        """The walk at a time (s) of the record, RGB; with the walk's outcome in words where that is wanted."""
        moment = self._moments.at(time)
        self._go_to(moment.qpos[0])
        out = np.empty((self._height, self._width, 3), dtype=np.uint8)
        self._pose(moment)
        mujoco.mjv_updateScene(
            self._posed.model,
            self._posed.data,
            self._option,
            None,
            self._eye,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._scene,
        )
        view = View.of(self._scene, self._width, self._picture)
        if not self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX]:
            self._add_background(view)
        draw_marks(self._scene, moment, self._robot, self._scales, self._look.elements)
        picture = out[: self._picture]
        self._canvas.draw(self._scene, picture)
        self._write(picture, moment, view, self._walk.outcome if with_outcome else "")
        if self._chart is not None:
            self._chart.draw(out[self._picture :], time)
        return out

    def _pose(self, moment: Moment) -> None:
        """Give the model the posture, and the camera its smooth way."""
        self._posed.pose(moment, forces=bool(self._look.visual))
        for axis, offsets in zip((0, 2), self._smooth, strict=True):
            self._posed.data.cam_xpos[self._camera, axis] += np.interp(moment.time, self._walk.samples["time"], offsets)

    def _add_background(self, view: View) -> None:
        """A plain wall far behind: MuJoCo's sky takes a software renderer as long as all the rest."""
        scene, length = self._scene, self._robot.leg_length
        geom = add_geom(
            scene,
            scene.geoms,
            mujoco.mjtGeom.mjGEOM_BOX,
            np.array([_WIDE * length, _WIDE * length, length]),
            view.place + _FAR * length * view.axes[2],
            view.axes.T.ravel(),
            (*_SKY, 1.0),
        )
        geom.emission = 1.0

    def _write(self, picture: Pixels, moment: Moment, view: View, outcome: str) -> None:
        """Words and signs over the picture."""
        elements, low = self._look.elements, 0
        if "caption" in elements:
            right, low = lay_caption(picture, caption(moment, self._slow_motion), self._height)
            lay_legend(picture, self._signs(moment), self._height, (right, low), outcome)
        if "scale" in elements:
            start, stop = (view.pixel(float(view.place[0]) + x, 0.0, 0.0)[0] for x in (0.0, 1.0))
            lay_scale(picture, stop - start, low + 0.6 * letter_size(self._height), self._height)
        if "labels" in elements:
            lay_ground_labels(picture, self._terrain, view, self._robot.leg_length, self._height)

    def _signs(self, moment: Moment) -> Iterator[Sign]:
        """The legend's lines."""
        elements = self._look.elements
        if "torque" in elements:
            for signal, torque in zip(torques_of(type(self._robot)), moment.torque, strict=True):
                yield Sign(rgb(signal.colour), f"{signal.name} torque", f"{signed(torque)} N m")
        if "force" in elements:
            yield Sign(marks.FORCE_COLOUR, "ground force", f"{math.hypot(*moment.force):.0f} N")
        if "estimate" in elements and math.isfinite(moment.slope_estimate):
            yield Sign(marks.ESTIMATE_COLOUR, "slope estimate", f"{signed(math.degrees(moment.slope_estimate))}°")
        if "ghost" in elements and self.tracks:
            yield Sign(marks.GHOST_COLOUR, "reference", "")


def caption(moment: Moment, slow_motion: float) -> list[str]:
    """What a caption says of an instant."""
    estimate = moment.slope_estimate
    lines = [f"t = {moment.time:.2f} s   step {moment.step}", f"slope {signed(math.degrees(moment.slope))}°"]
    if not math.isnan(estimate):
        lines[1] += f"   estimate {signed(math.degrees(estimate))}°"
    if slow_motion > 1.0:
        lines.append(f"slow motion {slow_motion:g}×")
    elif slow_motion < 1.0:
        lines.append(f"time lapse {1.0 / slow_motion:.3g}×")
    return lines


def signed(number: float) -> str:
    """A number with its sign and one digit, but no zero below zero."""
    return f"{round(number, 1) + 0.0:+.1f}".replace("-", "−")
