"""What MuJoCo draws a scene with: an OpenGL context without a window, and smooth edges at little cost."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from mjbiped.errors import RenderError
from mjbiped.rendering.gl import ensure_gl, one_thread
from mjbiped.rendering.overlay import Pixels

_SHIFTS = (-0.25, 0.25)
"""Of the two drawings of a frame, whose mean it is, along both axes, pixels. OpenGL's own smoothing by four samples a
pixel takes a software renderer three times as long."""

_FACES = (16, 8, 1)
"""Of round bodies around and along them, and of flat ones. MuJoCo's own are four times as many, and take as long."""


class Canvas:
    """A picture that scenes of one model are drawn into; to be closed."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        """Open the context.

        Args:
            model: Whose scenes are drawn; the size of its offscreen buffer is set.
            width: Pixels.
            height: Pixels.

        Raises:
            RenderError: No OpenGL platform works, or not with so many pixels.
        """
        platform = ensure_gl()
        from mujoco.rendering.classic import gl_context  # after `ensure_gl`, which chooses what is in it

        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        quality = model.vis.quality
        quality.offsamples, (quality.numslices, quality.numstacks, quality.numquads) = 0, _FACES
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._context: Any = None
        self._opengl: Any = None
        try:
            with one_thread():
                self._opengl = gl_context.GLContext(width, height)
                self._opengl.make_current()
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        except Exception as error:  # ImportError, RuntimeError, mujoco.FatalError, PyOpenGL's own
            self.close()
            raise RenderError(f"OpenGL platform {platform} cannot draw {width} x {height} pixels: {error}") from error
        self._buffers = [np.empty((height, width, 3), dtype=np.uint8) for _ in _SHIFTS]

    def draw(self, scene: mujoco.MjvScene, out: Pixels) -> None:
        """Draw a scene.

        Args:
            scene: Of the canvas's model.
            out: RGB, shape (height, width, 3), to be filled.
        """
        self._opengl.make_current()
        before = 0.0
        for shift, buffer in zip(_SHIFTS, self._buffers, strict=True):
            for camera in scene.camera:  # of both eyes, between which MuJoCo takes the middle
                pixel = (camera.frustum_top - camera.frustum_bottom) / self._rectangle.height
                camera.frustum_center += (shift - before) * pixel
                camera.frustum_bottom += (shift - before) * pixel
                camera.frustum_top += (shift - before) * pixel
            before = shift
            mujoco.mjr_render(self._rectangle, scene, self._context)
            mujoco.mjr_readPixels(buffer, None, self._rectangle, self._context)
        one, other = self._buffers
        # the mean, rounded down, of whole numbers that are not to grow: common digits and half of the others
        differing = np.bitwise_xor(one, other)
        np.right_shift(differing, 1, out=differing)
        np.bitwise_and(one, other, out=one)
        np.add(one[::-1], differing[::-1], out=out)  # OpenGL's rows begin at the lower edge

    def close(self) -> None:
        """Free what the drawing has taken."""
        if self._context is not None:
            self._context.free()
        if self._opengl is not None:
            self._opengl.free()
        self._context = self._opengl = None
