"""Choice of an OpenGL platform that works; MuJoCo itself chooses one blindly while it is being imported.

MuJoCo takes the platform that MUJOCO_GL names, or GLFW (a window system) if it is unset. `ensure_gl` looks for one that
works when something is to be drawn. It tries each candidate in a process of its own, for a driver may crash, and
PyOpenGL cannot change its platform once loaded.
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from contextlib import AbstractContextManager
from functools import lru_cache

from mjbiped.errors import RenderError
from mjbiped.utils.mujoco import DISABLING, UNCHOSEN, chosen_platform, environment

_PLATFORMS = {"linux": ("egl", "glfw", "osmesa"), "darwin": ("cgl", "glfw"), "win32": ("glfw",)}
_ALIASES = {"glx": "glfw", "wgl": "glfw"}
_PROBE_LIMIT = 60.0  # s; a software renderer answers within one

_PROBE = """
import os, sys, warnings
warnings.simplefilter("ignore")
from mujoco.rendering.classic.renderer import Renderer  # not from mujoco, which swallows ImportErrors
import mujoco
model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
with Renderer(model, 16, 16) as renderer:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer.update_scene(data)
    renderer.render()
sys.stdout.write("drawn")
sys.stdout.flush()
os._exit(0)
"""


def one_thread() -> AbstractContextManager[None]:
    """Make a software OpenGL that is opened in the block draw in the calling thread.

    Its own threads make a frame of 1280 × 720 no faster, and use a quarter more of the processor. Mesa's variable
    LP_NUM_THREADS is left as it is if it is set.
    """
    return environment(LP_NUM_THREADS=os.environ.get("LP_NUM_THREADS", "0"))


def gl_available() -> str | None:
    """Return the OpenGL platform that would be used, without loading any OpenGL into this process.

    Returns:
        "egl", "osmesa", "glfw" or "cgl"; None if no platform works, see `ensure_gl`.
    """
    try:
        return _working_platform()
    except RenderError:
        return None


def ensure_gl() -> str:
    """Make MuJoCo's renderer use an OpenGL platform that works on this machine.

    It is the one that MUJOCO_GL names; if it names none, on Linux EGL, a window system, or OSMesa.

    Returns:
        Name of the platform.

    Raises:
        RenderError: No platform works; the message says why, and which Debian packages help.
    """
    platform = _working_platform()
    from mujoco.rendering.classic import gl_context

    wanted = f"mujoco.{platform}"
    if getattr(getattr(gl_context, "GLContext", None), "__module__", None) != wanted:
        try:
            with environment():
                gl_context.GLContext = importlib.import_module(wanted).GLContext
        except Exception as error:  # another OpenGL is loaded in this process
            raise RenderError(
                f"OpenGL platform {platform} works on this machine, but not beside what this process has loaded "
                f"({error}); set MUJOCO_GL={platform} before Python starts"
            ) from error
    return platform


def _working_platform() -> str:
    """Return the first working platform that MUJOCO_GL and the system allow.

    Raises:
        RenderError: No platform works.
    """
    chosen, known = chosen_platform(), _PLATFORMS.get(sys.platform, ("glfw",))
    unharmed = "Walks, records and figures need no OpenGL."
    if chosen in DISABLING:
        raise RenderError(f"MUJOCO_GL={chosen} switches drawing off; unset it, or set it to {known[0]}. {unharmed}")
    candidates = known if chosen in UNCHOSEN else (_ALIASES.get(chosen, chosen),)
    if candidates[0] not in known:
        raise RenderError(f"MUJOCO_GL={chosen} is no OpenGL platform; valid are {', '.join(known)}. {unharmed}")
    reasons = []
    for platform in candidates:
        reason = _obstacle(platform, tuple(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")))
        if not reason:
            return platform
        reasons.append(f"{platform} ({reason})")
    cure = " On Debian or Ubuntu install libegl1 and libgl1-mesa-dri for EGL, or libosmesa6 for OSMesa."
    named = "no OpenGL platform works here" if candidates is known else f"MUJOCO_GL={chosen} does not work here"
    raise RenderError(f"{named}: {'; '.join(reasons)}.{cure if sys.platform == 'linux' else ''} {unharmed}")


@lru_cache
def _obstacle(platform: str, screens: tuple[str | None, ...]) -> str:
    """Return in one line why a platform cannot draw on the given screens, or nothing if it can."""
    if platform == "glfw" and sys.platform == "linux" and not any(screens):
        return "there is no display"
    try:
        probe = subprocess.run(
            [sys.executable, "-c", _PROBE],
            env={**os.environ, "MUJOCO_GL": platform},
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_PROBE_LIMIT,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    if probe.stdout.endswith("drawn"):
        return ""
    for line in reversed(probe.stderr.splitlines()):  # of the traceback, the exception
        kind, _, text = line.partition(": ")
        if text and kind.rpartition(".")[2].endswith(("Error", "Exception")) and not kind[0].isspace():
            return "its library is missing" if "'NoneType' object has no attribute" in text else text.rstrip(".")
    return f"its driver failed with code {probe.returncode}"
