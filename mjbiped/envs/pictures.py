"""Pictures of a walk under way, for environments that render."""

from __future__ import annotations

import atexit
import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.errors import RenderError
from mjbiped.rendering.gl import ensure_gl
from mjbiped.utils.mujoco import mujoco

_CAMERA = "track"  # of the robots' files in models/


class Camera:
    """Draws a robot from a camera that moves with it."""

    def __init__(self, width: int, height: int) -> None:
        """Note the size of pictures, pixels; nothing is built yet."""
        self._size = height, width
        self._model: mujoco.MjModel | None = None
        self._renderer: Any = None

    def picture(self, simulation: Simulation) -> NDArray[np.uint8]:
        """Draw the robot of a simulation with scenery as it stands, RGB, shape (height, width, 3).

        Raises:
            RenderError: No OpenGL platform works.
        """
        if simulation.model is not self._model:
            self._open(simulation.model)
        self._data.qpos[:] = simulation.data.qpos
        mujoco.mj_forward(simulation.model, self._data)
        self._renderer.update_scene(self._data, _CAMERA)
        pixels: NDArray[np.uint8] = self._renderer.render()
        return pixels

    def _open(self, model: mujoco.MjModel) -> None:
        """Make a renderer of a model, and data of its own."""
        platform, first = ensure_gl(), self._renderer is None
        self.close()
        self._model, self._data = model, mujoco.MjData(model)
        model.vis.global_.offheight, model.vis.global_.offwidth = self._size
        try:
            self._renderer = mujoco.Renderer(model, *self._size, max_geom=model.ngeom + 100)
        except Exception as error:  # ImportError, RuntimeError, mujoco.FatalError, PyOpenGL's own
            size = f"{self._size[1]} x {self._size[0]}"
            raise RenderError(f"OpenGL platform {platform} cannot draw {size} pixels: {error}") from error
        if first:  # at exit it must go before the OpenGL platform, which its first renderer has registered by now
            atexit.register(_close, weakref.ref(self))

    def close(self) -> None:
        """Release the renderer."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = self._model = None

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what makes another camera, with a renderer of its own."""
        return Camera, self._size[::-1]


def _close(left: weakref.ref[Camera]) -> None:
    """Close a camera that a program has left open when it ends."""
    camera = left()
    if camera is not None:
        camera.close()
