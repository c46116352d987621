"""Pictures of a walk under way, for environments that render."""

from __future__ import annotations

import atexit
import math
import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.ground_window import MARGIN, GroundWindows
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.plan import Plan
from mjbiped.errors import RenderError
from mjbiped.rendering.gl import ensure_gl
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

_SIGHT = 4.0  # ground about the robot, m
_REACH = 100.0  # how far ground of a single segment is built, m
_CAMERA = "track"  # of the robots' files in models/


class Camera:
    """Draws a robot from a camera that moves with it; each robot and ground has a scene of its own."""

    def __init__(self, width: int, height: int) -> None:
        """Note the size of pictures, pixels; nothing is built yet."""
        self._size = height, width
        self._shown: tuple[Robot, Terrain] | None = None
        self._renderer: Any = None

    def picture(self, plan: Plan, simulation: Simulation) -> NDArray[np.uint8]:
        """Draw the robot as it stands, RGB, shape (height, width, 3).

        Raises:
            RenderError: No OpenGL platform works.
        """
        x = float(simulation.data.qpos[0])
        if self._shown is None or self._shown[0] is not plan.robot or self._shown[1] is not plan.terrain:
            self._shown, self._inside = (plan.robot, plan.terrain), (math.inf, -math.inf)
            margin, any_step = max(_SIGHT, MARGIN * plan.robot.leg_length), 1e-4  # nothing is stepped
            ground = Ground(plan.terrain, reach=_REACH)
            self._windows = GroundWindows(plan.robot, ground, any_step, margin, scenery=True)
        if not self._inside[0] < x < self._inside[1]:
            self._build(x)
        self._data.qpos[:] = simulation.data.qpos
        mujoco.mj_forward(self._model, self._data)
        self._renderer.update_scene(self._data, _CAMERA)
        pixels: NDArray[np.uint8] = self._renderer.render()
        return pixels

    def _build(self, x: float) -> None:
        """Build the scene about a place (m), and a renderer for it."""
        scene = self._windows.about(x)
        self._model, self._data = scene.model, mujoco.MjData(scene.model)
        self._inside = scene.inside
        height, width = self._size
        self._model.vis.global_.offwidth, self._model.vis.global_.offheight = width, height
        platform = ensure_gl()
        first = self._renderer is None
        self.close()
        try:
            self._renderer = mujoco.Renderer(self._model, height, width, max_geom=self._model.ngeom + 100)
        except Exception as error:  # ImportError, RuntimeError, mujoco.FatalError, PyOpenGL's own
            raise RenderError(f"OpenGL platform {platform} cannot draw {width} x {height} pixels: {error}") from error
        if first:  # at exit it must go before the OpenGL platform, which its first renderer has registered by now
            atexit.register(_close, weakref.ref(self))

    def close(self) -> None:
        """Release the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def _close(left: weakref.ref[Camera]) -> None:
    """Close a camera that a program has left open when it ends."""
    camera = left()
    if camera is not None:
        camera.close()
