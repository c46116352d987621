"""Frames of a walk: the scene built from the record, marks in the scene, words over it, and the chart."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mjbiped.errors import InputError, RenderError, shown
from mjbiped.records.record import Walk
from mjbiped.rendering import Look
from mjbiped.rendering.gl import ensure_gl
from mjbiped.rendering.marks import MOST_GEOMS, Pen, Scales, draw_marks, signed, signs
from mjbiped.rendering.overlay import Chart, Overlay, Pixels, View
from mjbiped.rendering.scene import Moment, Moments, PosedScene, smooth_offsets
from mjbiped.utils.mujoco import environment, mujoco

_CHART_SHARE = 0.27  # of a frame's height
_LOWEST_WITH_CHART = 240  # pixels; a lower frame has no room for it
HORIZON, ZENITH = (0.90, 0.93, 0.955), (0.74, 0.83, 0.915)  # colours of the sky
_FAR, _BANDS = 40.0, 12  # distance of the sky from the camera, in leg lengths, and bands above the picture's middle
_ONE_AT_A_TIME = threading.Lock()

_SMOOTHED, _FEW = 4, 640 * 480
"""Samples a pixel of a picture that is drawn once, or has few pixels. They take a software renderer three times as long
as one sample, and a frame of a large video is drawn with one."""

_FACES = (16, 8, 1)
"""Faces around and along round bodies, and of flat ones. MuJoCo's defaults are four times as many, and as slow."""


class Film(NamedTuple):
    """Contents, times and size of the frames of a record.

    Attributes:
        width: Width of a frame, pixels.
        height: Height of a frame, pixels.
        camera: Name of the camera.
        look: Elements and flags that are shown.
        start: Time of the record at the first frame, s.
        stop: Time of the record at the end, s.
        slow_motion: Seconds of video per second of the walk.
        frames: Number of frames of a video; 0 of a picture.
    """

    width: int
    height: int
    camera: str
    look: Look
    start: float
    stop: float
    slow_motion: float = 1.0
    frames: int = 0

    @property
    def fine(self) -> bool:
        """Whether edges are smoothed and legs cast shadows: in pictures and in videos of few pixels."""
        return self.frames == 0 or self.width * self.height <= _FEW


class Stage:
    """Scene and canvas on which the postures of a walk are drawn; on a long terrain, one scene about each place."""

    def __init__(self, walk: Walk, film: Film, open_now: ExitStack) -> None:
        """Build the scene; call `open` instead."""
        self._walk, self._robot, self._film, self._look, self._open = walk, walk.robot, film, film.look, open_now
        charted = "chart" in film.look.elements and film.height >= _LOWEST_WITH_CHART
        chart_height = round(film.height * _CHART_SHARE) if charted else 0
        self._chart = Chart(walk, film.start, film.stop, film.width, chart_height) if charted else None
        self._frame = np.empty((film.height, film.width, 3), dtype=np.uint8)
        self._picture = self._frame[: film.height - chart_height]
        self._upside_down = np.empty_like(self._picture)
        self._prepare(walk, film)
        self._scales = Scales(self._moments.greatest_torque(film.start, film.stop), self._robot.weight)
        self._smooth = smooth_offsets(walk)
        self._go_to(self._moments.at(film.start).qpos[0])

    def _prepare(self, walk: Walk, film: Film) -> None:
        """Make the moments and the scene."""
        self._moments, self._posed = Moments(walk, ghost="ghost" in film.look.elements), PosedScene(walk)

    @classmethod
    @contextmanager
    def open(cls, walk: Walk, film: Film) -> Iterator[Stage]:
        """Build the scene and a canvas for it; one at a time per process.

        Args:
            walk: A record with samples.
            film: What is drawn of it.

        Raises:
            InputError: There is no such camera.
            RenderError: No OpenGL platform works.
        """
        with _ONE_AT_A_TIME, ExitStack() as stack:
            yield cls(walk, film, stack)

    def _go_to(self, x: float) -> None:
        """Build the scene about x (m) if the present one does not reach there, and a canvas for it.

        Raises:
            InputError: There is no such camera.
            RenderError: No OpenGL platform works, or not with so many pixels.
        """
        if not self._posed.go_to(x):
            return
        model, name = self._posed.model, self._film.camera
        names = [model.camera(index).name for index in range(model.ncam)]
        if name not in names:
            raise InputError(f"unknown camera {shown(name)}; valid are {', '.join(names)}")
        self._option, self._eye = mujoco.MjvOption(), mujoco.MjvCamera()
        self._eye.type, self._eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, names.index(name)
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + MOST_GEOMS + 200)
        usual = {mujoco.mjtRndFlag.mjRND_SHADOW: self._film.fine, mujoco.mjtRndFlag.mjRND_SKYBOX: False}
        self._look.set_flags(self._option.flags, self._scene.flags, usual)
        (height, width, _), quality = self._picture.shape, model.vis.quality
        model.vis.global_.offheight, model.vis.global_.offwidth = height, width
        quality.offsamples = _SMOOTHED if self._film.fine else 0
        quality.numslices, quality.numstacks, quality.numquads = _FACES
        self._open.close()
        platform = ensure_gl()
        from mujoco.rendering.classic import gl_context  # whose platform has been chosen now

        try:
            with environment(LP_NUM_THREADS=os.environ.get("LP_NUM_THREADS", "0")):
                self._canvas = gl_context.GLContext(width, height)
                self._open.callback(self._canvas.free)
                self._canvas.make_current()
                self._drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150)
                self._open.callback(self._drawing.free)
                mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
        except Exception as error:  # ImportError, RuntimeError, mujoco.FatalError, PyOpenGL's own
            raise RenderError(f"OpenGL platform {platform} cannot draw {width} x {height} pixels: {error}") from error

    def frame(self, time: float, *, with_outcome: bool = False) -> Pixels:
        """Draw the walk at a time (s) of the record, on request with the walk's outcome in words.

        Returns:
            RGB pixels, which the next frame overwrites.
        """
        moment, picture = self._moments.at(time), self._picture
        self._go_to(moment.qpos[0])
        model, data = self._posed.model, self._posed.data
        self._posed.pose(moment, forces=bool(self._look.visual))
        axes = (0, 2) if self._smooth.shape[1] == 2 else (0, 1, 2)
        for axis, offsets in zip(axes, self._smooth.T, strict=True):  # the camera's smooth path
            data.cam_xpos[self._eye.fixedcamid, axis] += np.interp(time, self._walk.samples["time"], offsets)
        every, (height, width, _) = mujoco.mjtCatBit.mjCAT_ALL, picture.shape
        mujoco.mjv_updateScene(model, data, self._option, None, self._eye, every, self._scene)
        view = View.of(model, data, self._eye.fixedcamid, (width, height))
        if not self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX]:
            self._add_background(view)
        self._draw_marks(moment)
        self._canvas.make_current()
        place = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(place, self._scene, self._drawing)
        mujoco.mjr_readPixels(self._upside_down, None, place, self._drawing)
        picture[...] = self._upside_down[::-1]
        self._paint_sky(picture, view)
        self._write(Overlay(picture, self._film.height), moment, view, self._walk.outcome if with_outcome else "")
        if self._chart is not None:
            self._chart.draw(self._frame[height:], time)
        return self._frame

    def _draw_marks(self, moment: Moment) -> None:
        """Add the elements of an instant."""
        draw_marks(self._scene, moment, self._robot, self._scales, self._look.elements)

    def _paint_sky(self, picture: Pixels, view: View) -> None:
        """Paint what the scene does not hold: nothing, as the background is in it."""

    def _add_background(self, view: View) -> None:
        """Add a plain sky far behind, in bands: MuJoCo's takes a software renderer as long as all the rest."""
        far, pen = _FAR * self._robot.leg_length, Pen(self._scene, self._robot.leg_length)
        high = view.half * (1.0 if view.orthographic else far)
        wide, change = high * view.size[0] / view.size[1], np.subtract(ZENITH, HORIZON)
        edges = np.linspace(0.0, high, _BANDS + 1)[1:].tolist()
        for band, (low, top) in enumerate(pairwise((-high, *edges))):
            place = view.place - far * view.axes[2] + 0.5 * (low + top) * view.axes[1]
            size, colour = np.array([wide, 0.5 * (top - low), 1e-3]), HORIZON + band / _BANDS * change
            pen.add(mujoco.mjtGeom.mjGEOM_BOX, size, place, view.axes.T.ravel(), (*colour, 1.0))

    def _write(self, over: Overlay, moment: Moment, view: View, outcome: str) -> None:
        """Write words and signs over the picture."""
        elements, low = self._look.elements, 0
        if "caption" in elements:
            right, low = over.caption(caption(moment, self._film.slow_motion))
            over.legend(signs(moment, self._robot, elements), (right, low), outcome)
        if "scale" in elements:
            start, stop = (view.pixel(float(view.place[0]) + x, 0.0, 0.0)[0] for x in (0.0, 1.0))
            over.scale(stop - start, low + 0.6 * over.letter)
        if "labels" in elements:
            over.ground_labels(self._walk.terrain, view, self._robot.leg_length)


def caption(moment: Moment, slow_motion: float) -> list[str]:
    """Lines of the caption at an instant."""
    estimate = moment.slope_estimate
    lines = [f"t = {moment.time:.2f} s   step {moment.step}", f"slope {signed(math.degrees(moment.slope))}°"]
    if not math.isnan(estimate):
        lines[1] += f"   estimate {signed(math.degrees(estimate))}°"
    if slow_motion > 1.0:
        lines.append(f"slow motion {slow_motion:g}×")
    elif slow_motion < 1.0:
        lines.append(f"time lapse {1.0 / slow_motion:.3g}×")
    return lines
