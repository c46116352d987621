"""The viewer's window: MuJoCo's own (`mujoco.viewer.launch_passive`), in which a walk is drawn with its marks."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco

from mjbiped.errors import RenderError
from mjbiped.rendering.look import Look, show_section
from mjbiped.rendering.marks import draw_marks
from mjbiped.rendering.moments import Moment
from mjbiped.viewing import words
from mjbiped.viewing.player import Player

FRAME = 1.0 / 60.0
"""Real time between two frames, s."""

_INSTEAD = "`mjbiped render` draws a record without one"
_FOV = 17.0  # degrees, as the scene's camera that follows the robot
_DISTANCE, _AHEAD, _BELOW = 6.5, 0.3, 0.55  # of the camera, and where it looks, from the hip; in leg lengths
_CALM = 0.35  # walk time over which the camera follows, s: half a step
_FORCE = 0.3  # length of MuJoCo's arrow for a force of the robot's weight, in leg lengths
_FORCE_WIDTH = 0.02  # of it, in leg lengths
_PATIENCE = 5.0  # for the window to close, s


def view(player: Player, look: Look, *, seconds: float | None = None) -> None:
    """Open a window, and show a walk until the window is closed.

    Args:
        player: Of the walk.
        look: The marks and MuJoCo's visual flags to begin with.
        seconds: Real time after which the window closes by itself, s; never unless given.

    Raises:
        RenderError: There is no screen, or on macOS no mjpython.
        WalkStopped: The controller raised an exception.
    """
    require_screen()
    from mujoco import viewer  # after that: it asks for GLFW

    begun = last = time.perf_counter()
    _prepare(player)
    with _opened(viewer, player) as window:
        with window.lock():
            show_section(window.opt)
            look.set_flags(window.opt.flags, window.user_scn.flags, {})
            camera = _Camera(window.cam, player.source.moment(), player.source.robot.leg_length)
        shown = player.source.model
        while window.is_running():
            now = time.perf_counter()
            if seconds is not None and now - begun > seconds:
                break
            with window.lock():
                player.source.push(window.perturb)
            player.tick(now - last)
            last = now
            player.source.show()
            if player.source.model is not shown:
                shown = player.source.model
                _prepare(player)
                _load(window, player)
            moment = player.source.moment()
            with window.lock():
                camera.follow(moment)
                window.user_scn.ngeom = 0
                draw_marks(window.user_scn, moment, player.source.robot, player.source.scales, look.elements)
            _write(window, player, moment, look)
            window.sync()
            time.sleep(max(0.0, FRAME - (time.perf_counter() - now)))


def require_screen() -> None:
    """Refuse to open a window where none can be.

    Raises:
        RenderError: There is no screen, OpenGL cannot draw on it, or on macOS no mjpython.
    """
    if sys.platform == "darwin":
        from mujoco import viewer

        if viewer._MJPYTHON is None:
            raise RenderError("on macOS a window needs MuJoCo's own Python: mjpython -m mjbiped view ...")
        return
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise RenderError(f"there is no screen (DISPLAY and WAYLAND_DISPLAY are not set): {_INSTEAD}")
    reason = _refusal()
    if reason:
        raise RenderError(f"no window can be opened on this screen: {reason}; {_INSTEAD}")


def _refusal() -> str:
    """Why GLFW cannot open a window with OpenGL; empty if it can. MuJoCo's viewer would end the process over it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            import glfw

            if glfw.init():
                glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
                window = glfw.create_window(64, 64, "mjbiped", None, None)
                glfw.terminate()
                if window:
                    return ""
        except Exception as error:  # ImportError where the library is missing, GLFWError
            return " ".join(str(error).split())
    said = [" ".join(str(each.message).split()) for each in caught]
    return said[-1] if said else "GLFW does not say why"


@contextmanager
def _opened(viewer: Any, player: Player) -> Iterator[Any]:
    """The window; it is gone when this ends."""
    source, before = player.source, set(threading.enumerate())
    window = viewer.launch_passive(
        source.model, source.data, key_callback=player.press, show_left_ui=False, show_right_ui=False
    )
    drawing = set(threading.enumerate()) - before
    try:
        yield window
    finally:
        window.close()
        for thread in drawing:  # else Python may end while it still draws, and crash
            thread.join(_PATIENCE)


def _prepare(player: Player) -> None:
    """Set what a model says of its looks."""
    source, length = player.source, player.source.robot.leg_length
    source.model.vis.global_.fovy = _FOV
    # MuJoCo divides by the mean mass of bodies
    source.model.vis.map.force = _FORCE * length / source.robot.weight * source.model.stat.meanmass
    source.model.vis.scale.forcewidth = _FORCE_WIDTH * length / source.model.stat.meansize


def _load(window: Any, player: Player) -> None:
    """Give the window another model; what is chosen with the mouse stays so, for the robot is the same.

    The handle has no function for that. Its `Simulate` has, with which MuJoCo's own viewers reload a file.
    """
    simulate = window._get_sim()
    if simulate is None:
        return
    chosen = {name: getattr(window.perturb, name) for name in ("select", "active", "active2")}
    simulate.load(player.source.model, player.source.data, "")
    with window.lock():
        for name, value in chosen.items():
            setattr(window.perturb, name, value)


class _Camera:
    """Follows the hip without bobbing; what the mouse does to the camera stays, for it is only moved along."""

    def __init__(self, camera: Any, moment: Moment, length: float) -> None:
        self._camera, self._time, self._place = camera, moment.time, moment.qpos[:2]
        x, z = self._place
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.azimuth, camera.elevation, camera.distance = 90.0, -5.0, _DISTANCE * length
        camera.lookat[:] = x + _AHEAD * length, 0.0, z - _BELOW * length

    def follow(self, moment: Moment) -> None:
        """Move on to where the hip is."""
        elapsed, self._time = moment.time - self._time, moment.time
        # begun anew, or gone far: there at once
        share = -math.expm1(-elapsed / _CALM) if 0.0 <= elapsed < 1.0 else 1.0
        way = [share * (to - from_) for to, from_ in zip(moment.qpos[:2], self._place, strict=True)]
        if all(map(math.isfinite, way)):
            self._place = (self._place[0] + way[0], self._place[1] + way[1])
            self._camera.lookat[0] += way[0]
            self._camera.lookat[2] += way[1]


def _write(window: Any, player: Player, moment: Moment, look: Look) -> None:
    """Write what is to be read."""
    small, grid = mujoco.mjtFontScale.mjFONTSCALE_100, mujoco.mjtGridPos
    texts = [(small, grid.mjGRID_BOTTOMRIGHT, *words.keys())] if player.helps else []
    if "caption" in look.elements:
        texts.append((small, grid.mjGRID_TOPRIGHT, *words.state(player, moment, look.elements)))
    news = words.news(player)
    if news:
        texts.append((small, grid.mjGRID_TOP, news, ""))
    window.set_texts(texts)
