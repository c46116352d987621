"""Frames of a walk: the scene built from the record, marks in the scene, words over it, and the chart."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import NamedTuple

import numpy as np
from PIL import Image

from mjbiped.errors import InputError, RenderError, shown
from mjbiped.records.record import Walk
from mjbiped.records.signals import torques_of
from mjbiped.rendering import marks
from mjbiped.rendering.camera import View, smooth_offsets
from mjbiped.rendering.chart import Chart
from mjbiped.rendering.gl import ensure_gl, one_thread
from mjbiped.rendering.look import Look, show_section
from mjbiped.rendering.marks import MOST_GEOMS, Scales, add_geom, draw_marks
from mjbiped.rendering.moments import Moment, Moments
from mjbiped.rendering.overlay import Overlay, Pixels, Sign
from mjbiped.rendering.posed import PosedScene
from mjbiped.utils.mujoco import mujoco
from mjbiped.utils.palette import rgb

_CHART_SHARE = 0.27  # of a frame's height
_LOWEST_WITH_CHART = 240  # pixels; a lower frame has no room for it
_SKY = (0.70, 0.715, 0.73)  # becomes almost white in the scene's light
_FAR, _WIDE = 40.0, 60.0  # distance of the plain background from the camera and half its size, in leg lengths
_ONE_AT_A_TIME = threading.Lock()

_SHIFTS = (-0.25, 0.25)
"""Offsets along both axes of the two drawings whose mean is a frame, pixels. OpenGL's own smoothing with four samples a
pixel takes a software renderer as long as three drawings. In a single drawing edges are jagged, and thin level lines of
the ground come and go."""

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
        fps: Frames per second of the video.
        frames: Number of frames.
    """

    width: int
    height: int
    camera: str
    look: Look
    start: float
    stop: float
    slow_motion: float = 1.0
    fps: int = 30
    frames: int = 0

    def time(self, number: int) -> float:
        """Time of the record that a frame shows, s."""
        return self.start + number / (self.slow_motion * self.fps)


class Canvas:
    """Draws scenes of one model with MuJoCo's renderer, with smooth edges at little cost.

    Attributes:
        scene: The scene, an `mujoco.MjvScene`.
    """

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        """Open an OpenGL context without a window.

        Args:
            model: Model of the scenes; the size of its offscreen buffer is set.
            width: Width, pixels.
            height: Height, pixels.

        Raises:
            RenderError: No OpenGL platform works, or not with so many pixels.
        """
        platform = ensure_gl()
        from mujoco.rendering.classic import gl_context  # after `ensure_gl`, which chooses its platform

        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        quality = model.vis.quality
        quality.offsamples, (quality.numslices, quality.numstacks, quality.numquads) = 0, _FACES
        self.scene = mujoco.MjvScene(model, maxgeom=model.ngeom + MOST_GEOMS + 200)
        try:
            with one_thread():
                self._platform = gl_context.GLContext(width, height)
                self._platform.make_current()
                self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150)
                mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        except Exception as error:  # ImportError, RuntimeError, mujoco.FatalError, PyOpenGL's own
            raise RenderError(f"OpenGL platform {platform} cannot draw {width} x {height} pixels: {error}") from error
        self._size = width, height
        self._drawings = np.empty((2, height, width, 3), dtype=np.uint8)
        self._differing = np.empty((height, width, 3), dtype=np.uint8)

    def close(self) -> None:
        """Close the OpenGL context."""
        self._context.free()
        self._platform.free()

    def draw(self) -> Image.Image:
        """Draw the scene as an RGB image."""
        before, (width, height) = 0.0, self._size
        rectangle = mujoco.MjrRect(0, 0, width, height)
        self._platform.make_current()
        for shift, drawing in zip(_SHIFTS, self._drawings, strict=True):
            for camera in self.scene.camera:  # MuJoCo takes the mean of both eyes
                pixel = (camera.frustum_top - camera.frustum_bottom) / height
                camera.frustum_center += (shift - before) * pixel
                camera.frustum_bottom += (shift - before) * pixel
                camera.frustum_top += (shift - before) * pixel
            before = shift
            mujoco.mjr_render(rectangle, self.scene, self._context)
            mujoco.mjr_readPixels(drawing, None, rectangle, self._context)
        (one, other), differing = self._drawings, self._differing
        # the mean, rounded down, without overflow
        np.bitwise_xor(one, other, out=differing)
        np.right_shift(differing, 1, out=differing)
        np.bitwise_and(one, other, out=one)
        np.add(one, differing, out=one)
        return Image.frombytes("RGB", self._size, one, "raw", "RGB", 0, -1)  # OpenGL's first row is the lowest


class Stage:
    """Scene and canvas on which the postures of a walk are drawn; on a long terrain, one scene about each place."""

    def __init__(self, walk: Walk, film: Film, open_now: ExitStack) -> None:
        """Build the scene; call `open` instead."""
        self._walk, self._robot, self._terrain, self._film = walk, walk.robot, walk.terrain, film
        self._look, self._open = film.look, open_now
        charted = "chart" in film.look.elements and film.height >= _LOWEST_WITH_CHART
        chart_height = round(film.height * _CHART_SHARE) if charted else 0
        self._chart = Chart(walk, film.start, film.stop, film.width, chart_height) if charted else None
        self._picture = film.height - chart_height
        self._moments = Moments(walk, ghost="ghost" in film.look.elements)
        self._scales = Scales(self._moments.greatest_torque(film.start, film.stop), self._robot.weight)
        self._smooth = smooth_offsets(walk)
        self._posed = PosedScene(walk)
        self._go_to(self._moments.at(film.start).qpos[0])

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

    @property
    def tracks(self) -> bool:
        """Whether the posture that the controller tracked is drawn."""
        return self._moments.tracks

    def _go_to(self, x: float) -> None:
        """Build the scene about x (m) if the present one does not reach there."""
        if not self._posed.go_to(x):
            return
        model, name = self._posed.model, self._film.camera
        names = [model.camera(index).name for index in range(model.ncam)]
        if name not in names:
            raise InputError(f"unknown camera {shown(name)}; valid are {', '.join(names)}")
        self._open.close()
        self._canvas = Canvas(model, self._film.width, self._picture)
        self._open.callback(self._canvas.close)
        self._scene, self._option, self._eye = self._canvas.scene, mujoco.MjvOption(), mujoco.MjvCamera()
        show_section(self._option)
        hidden = {mujoco.mjtRndFlag.mjRND_SHADOW: False, mujoco.mjtRndFlag.mjRND_SKYBOX: False}
        self._look.set_flags(self._option.flags, self._scene.flags, hidden)
        self._camera = names.index(name)
        self._eye.type, self._eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, self._camera

    def frame(self, time: float, *, with_outcome: bool = False) -> Pixels:
        """Draw the walk at a time (s) of the record as RGB pixels, on request with the walk's outcome in words."""
        moment = self._moments.at(time)
        self._go_to(moment.qpos[0])
        model, data = self._posed.model, self._posed.data
        self._posed.pose(moment, forces=bool(self._look.visual))
        for axis, offsets in zip((0, 2), self._smooth.T, strict=True):  # the camera's smooth path
            data.cam_xpos[self._camera, axis] += np.interp(time, self._walk.samples["time"], offsets)
        every = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._option, None, self._eye, every, self._scene)
        view = View.of(self._scene, self._film.width, self._picture)
        if not self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX]:
            self._add_background(view)
        draw_marks(self._scene, moment, self._robot, self._scales, self._look.elements)
        out = np.empty((self._film.height, self._film.width, 3), dtype=np.uint8)
        image = self._canvas.draw()
        self._write(image, moment, view, self._walk.outcome if with_outcome else "")
        out[: self._picture] = np.asarray(image)
        if self._chart is not None:
            self._chart.draw(out[self._picture :], time)
        return out

    def _add_background(self, view: View) -> None:
        """Add a plain wall far behind: MuJoCo's sky takes a software renderer as long as all the rest."""
        length = self._robot.leg_length
        size, place = np.array([_WIDE, _WIDE, 1.0]) * length, view.place + _FAR * length * view.axes[2]
        box = mujoco.mjtGeom.mjGEOM_BOX
        geom = add_geom(self._scene, self._scene.geoms, box, size, place, view.axes.T.ravel(), (*_SKY, 1.0))
        geom.emission = 1.0

    def _write(self, image: Image.Image, moment: Moment, view: View, outcome: str) -> None:
        """Write words and signs over the picture."""
        elements, low = self._look.elements, 0
        over = Overlay(image, self._film.height)
        if "caption" in elements:
            right, low = over.caption(caption(moment, self._film.slow_motion))
            over.legend(self._signs(moment), (right, low), outcome)
        if "scale" in elements:
            start, stop = (view.pixel(float(view.place[0]) + x, 0.0, 0.0)[0] for x in (0.0, 1.0))
            over.scale(stop - start, low + 0.6 * over.letter)
        if "labels" in elements:
            over.ground_labels(self._terrain, view, self._robot.leg_length)

    def _signs(self, moment: Moment) -> Iterator[Sign]:
        """Lines of the legend."""
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


def signed(number: float) -> str:
    """Format a number with its sign and one digit; zero never has a minus sign."""
    return f"{round(number, 1) + 0.0:+.1f}".replace("-", "−")
