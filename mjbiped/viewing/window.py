"""Window of the viewer: MuJoCo's (`mujoco.viewer.launch_passive`), in which a walk is drawn with its marks."""

from __future__ import annotations

import math
import sys
import textwrap
import threading
import time
import warnings
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

from mjbiped.errors import RenderError, shortened
from mjbiped.rendering import Look
from mjbiped.rendering.marks import signs
from mjbiped.rendering.scene import Moment
from mjbiped.rendering.space import draw_marks
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco
from mjbiped.utils.palette import IN_WORDS
from mjbiped.viewing import KEYS, MOUSE, Player

FRAME = 1.0 / 60.0
"""Real time between two frames, s."""

_FOV = 17.0  # degrees, as the scene's camera that follows the robot
_DISTANCE, _AHEAD, _BELOW = 6.5, 0.3, 0.55  # of the camera, and where it looks, from the hip; in leg lengths
_CALM = 0.35  # walk time over which the camera follows, s: half a step
_FORCE = 0.3  # length of MuJoCo's arrow for a force of the robot's weight, in leg lengths
_FORCE_WIDTH = 0.02  # of it, in leg lengths
_PATIENCE = 5.0  # for the window to close, s

Columns = tuple[str, str]
"""Names and values, or keys and their actions, a line each, in ASCII, which MuJoCo's font has."""

_SLOWER = 0.9  # share of the requested speed below which the reached speed is shown
_CAPTION = 36  # characters of a terrain's name
_WIDTH = 60  # characters of a line of news


def view(player: Player, look: Look, *, seconds: float | None = None) -> None:
    """Open a window, and show a walk until the window is closed.

    Args:
        player: Player of the walk.
        look: Marks and MuJoCo's visual flags at the start.
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
    """Check that a window can be opened with OpenGL: MuJoCo's viewer would end the process.

    Raises:
        RenderError: There is no screen, or OpenGL cannot draw on it.
    """
    if sys.platform == "darwin":  # where only mjpython may ask, see `_opened`
        return
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # GLFW's errors are warnings
        try:
            import glfw

            glfw.init()
            glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
            glfw.create_window(64, 64, "mjbiped", None, None)
            glfw.terminate()
        except Exception as error:  # ImportError where the library is missing, GLFWError
            reason = " ".join(str(error).split())
            raise RenderError(
                f"there is no screen, or no window can be opened on it: {reason}; `mjbiped render` draws a record "
                "without one"
            ) from error


@contextmanager
def _opened(viewer: Any, player: Player) -> Iterator[Any]:
    """Open the window for the duration of a block.

    Raises:
        RenderError: It needs mjpython, on macOS.
    """
    source, before = player.source, set(threading.enumerate())
    try:
        window = viewer.launch_passive(
            source.model, source.data, key_callback=player.press, show_left_ui=False, show_right_ui=False
        )
    except RuntimeError as error:
        raise RenderError(f"{error}: mjpython -m mjbiped view ...") from error
    drawing = set(threading.enumerate()) - before
    try:
        yield window
    finally:
        window.close()
        for thread in drawing:  # else Python may end while it still draws, and crash
            thread.join(_PATIENCE)


def _prepare(player: Player) -> None:
    """Set the visual settings of a model."""
    source, length = player.source, player.source.robot.leg_length
    source.model.vis.global_.fovy = _FOV
    # MuJoCo divides by the mean mass of bodies
    source.model.vis.map.force = _FORCE * length / source.robot.weight * source.model.stat.meanmass
    source.model.vis.scale.forcewidth = _FORCE_WIDTH * length / source.model.stat.meansize


def _load(window: Any, player: Player) -> None:
    """Give the window another model of the same robot, and keep the body that the mouse has selected.

    The handle has no function for this, but its `Simulate` has: MuJoCo's own viewers use it to reload a file.
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
    """Moves the camera smoothly along with the hip, and keeps the changes that the mouse makes to it."""

    def __init__(self, camera: mujoco.MjvCamera, moment: Moment, length: float) -> None:
        self._camera, self._time, self._place = camera, moment.time, moment.qpos[:2]
        x, z = self._place
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.azimuth, camera.elevation, camera.distance = 90.0, -5.0, _DISTANCE * length
        camera.lookat[:] = x + _AHEAD * length, 0.0, z - _BELOW * length

    def follow(self, moment: Moment) -> None:
        """Move towards the hip."""
        elapsed, self._time = moment.time - self._time, moment.time
        # after a new start or a long jump, at once
        share = -math.expm1(-elapsed / _CALM) if 0.0 <= elapsed < 1.0 else 1.0
        way = [share * (to - from_) for to, from_ in zip(moment.qpos[:2], self._place, strict=True)]
        if all(map(math.isfinite, way)):
            self._place = (self._place[0] + way[0], self._place[1] + way[1])
            self._camera.lookat[0] += way[0]
            self._camera.lookat[2] += way[1]


def _write(window: Any, player: Player, moment: Moment, look: Look) -> None:
    """Write keys, state and news into the corners of the window."""
    grid, parts = mujoco.mjtGridPos, [(mujoco.mjtGridPos.mjGRID_TOP, (news(player), ""))]
    if player.helps:
        parts.append((grid.mjGRID_BOTTOMRIGHT, keys()))
    if "caption" in look.elements:
        parts.append((grid.mjGRID_TOPRIGHT, state(player, moment, look.elements)))
    window.set_texts([(mujoco.mjtFontScale.mjFONTSCALE_100, at, *texts) for at, texts in parts if texts[0]])


def state(player: Player, moment: Moment, elements: Collection[str]) -> Columns:
    """Return time, speed, ground, and the meanings of the marks."""
    reached = f" (reached {player.reached:.2g} x)" if player.reached < _SLOWER * player.speed else ""
    speed = f"{player.speed:.3g} x{' (paused)' if player.paused else reached}"
    lines = [
        ("ground", ground(player.source.terrain)),
        ("time", f"{moment.time:.2f} s, step {moment.step}"),
        ("speed", speed),
        ("slope", f"{math.degrees(moment.slope):+.1f} deg"),
    ]
    lines += [
        (f"{sign.name} ({IN_WORDS[sign.colour]} {sign.mark})", plain(sign.value))
        for sign in signs(moment, player.source.robot, elements)
        if sign.value
    ]
    names, values = zip(*lines, strict=True)
    return "\n".join(names), "\n".join(values)


def keys() -> Columns:
    """Return the keys and their actions."""
    rows = [*((key.name, key.does) for key in KEYS.values()), *MOUSE.items()]
    return "\n".join(name for name, _ in rows), "\n".join(does for _, does in rows)


def news(player: Player) -> str:
    """Return how the walk ended, and the result of the last key."""
    source = player.source
    lines = [f"{source.ended} - Backspace begins again"] if source.ended else []
    return "\n".join([*lines, *textwrap.wrap(source.news, _WIDTH)])


def ground(terrain: Terrain) -> str:
    """Return the terrain's name, shortened."""
    seed = dict(terrain.parameters).get("seed")
    return plain(shortened(terrain.caption, _CAPTION) if seed is None else f"{terrain.name}, seed {seed}")


def plain(text: str) -> str:
    """Rewrite a text in ASCII."""
    for sign, instead in (("−", "-"), ("–", "-"), ("°", " deg"), ("×", "x"), ("±", "+-"), (" ", " ")):
        text = text.replace(sign, instead)
    return text.encode("ascii", "replace").decode()
