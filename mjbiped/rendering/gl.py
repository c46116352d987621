"""Choice of an OpenGL platform that works, by dm_control's rule: the one that MUJOCO_GL names, or the first that opens.

MuJoCo itself tries only the platform that MUJOCO_GL names, or GLFW (a window system) if the variable is unset.
"""

from __future__ import annotations

import importlib
import os
import sys
from functools import lru_cache
from typing import Any

from mjbiped.errors import RenderError
from mjbiped.utils.mujoco import DISABLING, UNCHOSEN, chosen_platform, environment

_PLATFORMS = {"linux": ("egl", "glfw", "osmesa"), "darwin": ("cgl", "glfw"), "win32": ("glfw",)}
_ALIASES = {"glx": "glfw", "wgl": "glfw"}


def gl_available() -> str | None:
    """Return the OpenGL platform that is used.

    Returns:
        "egl", "osmesa", "glfw" or "cgl"; None if no platform works, see `ensure_gl`.
    """
    try:
        return ensure_gl()
    except RenderError:
        return None


def ensure_gl() -> str:
    """Make MuJoCo's renderer use an OpenGL platform that works on this machine.

    MUJOCO_GL names the platform. If it is unset, the first that works is used; on Linux EGL, a window system, OSMesa.

    Returns:
        Name of the platform.

    Raises:
        RenderError: No platform works; the message says why, and which Debian packages help.
    """
    with environment(MUJOCO_GL="disable"):  # a platform that does not open would raise an error here, without a cure
        from mujoco.rendering.classic import gl_context

    screen = sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    platform, gl_context.GLContext = _opened(chosen_platform(), screen)
    return platform


@lru_cache
def _opened(chosen: str, screen: bool) -> tuple[str, Any]:
    """Return the first platform, of those that MUJOCO_GL's value allows, with which a context can be made.

    Raises:
        RenderError: There is none.
    """
    known, unharmed = _PLATFORMS.get(sys.platform, ("glfw",)), "Walks, records and figures need no OpenGL."
    if chosen in DISABLING:
        raise RenderError(f"MUJOCO_GL={chosen} switches drawing off; unset it, or set it to {known[0]}. {unharmed}")
    candidates = known if chosen in UNCHOSEN else (_ALIASES.get(chosen, chosen),)
    if candidates[0] not in known:
        raise RenderError(f"MUJOCO_GL={chosen} is no OpenGL platform; valid are {', '.join(known)}. {unharmed}")
    reasons = []
    for platform in candidates:
        if platform == "glfw" and not screen:
            reasons.append("glfw (there is no display)")
            continue
        try:
            with environment():
                context = importlib.import_module(f"mujoco.{platform}").GLContext
                context(16, 16).free()
        except Exception as error:  # of any kind: a library is missing, or another platform's was loaded before
            said = str(error).strip().rstrip(".")
            reasons.append(f"{platform} ({'its library is missing' if 'NoneType' in said else said})")
        else:
            return platform, context
    cure = " On Debian or Ubuntu install libegl1 and libgl1-mesa-dri for EGL, or libosmesa6 for OSMesa."
    named = "no OpenGL platform works here" if candidates is known else f"MUJOCO_GL={chosen} does not work here"
    raise RenderError(f"{named}: {'; '.join(reasons)}.{cure if sys.platform == 'linux' else ''} {unharmed}")
