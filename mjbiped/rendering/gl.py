"""The OpenGL platform: MuJoCo chooses one while it is being imported; this module chooses one that works.

MuJoCo reads MUJOCO_GL once, when it is imported, takes GLFW (a window system) where it is unset, and fails to be
imported at all where it names a platform whose library is missing. A walk needs no OpenGL, so:

* importing this module imports MuJoCo, without its OpenGL where that stands in the way;
* `ensure_gl` looks for a platform when something is to be drawn. Each candidate is tried in a process of its own, for
  a driver may crash, and PyOpenGL cannot change its platform once loaded.
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import lru_cache

from mjbiped.errors import RenderError

_DISABLING = ("disable", "disabled", "off", "false", "0")  # MuJoCo's own words
_UNCHOSEN = ("", "enable", "enabled", "on", "true", "1")
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


@contextmanager
def _environment(**changes: str) -> Iterator[None]:
    """Environment variables for a while; PYOPENGL_PLATFORM, which MuJoCo sets, is put back as well."""
    kept = {name: os.environ.get(name) for name in (*changes, "PYOPENGL_PLATFORM")}
    os.environ.update(changes)
    try:
        yield
    finally:
        for name, value in kept.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def one_thread() -> AbstractContextManager[None]:
    """Have a software OpenGL that is begun within draw in the thread that asks.

    Its own threads make a frame of 1280 × 720 no sooner, and take a quarter more of the processor. Mesa's own variable,
    LP_NUM_THREADS, is left as it is where it is set.
    """
    return _environment(LP_NUM_THREADS=os.environ.get("LP_NUM_THREADS", "0"))


def _import_mujoco() -> None:
    """Import MuJoCo, without OpenGL where its import fails over the platform that MUJOCO_GL names.

    Raises:
        ImportError: MuJoCo cannot be imported for another reason.
    """
    chosen = os.environ.get("MUJOCO_GL", "").strip().lower()
    try:
        with _environment():
            importlib.import_module("mujoco")
    except Exception:  # RuntimeError, AttributeError, OSError: whatever a missing library leads to
        if chosen in (*_UNCHOSEN, *_DISABLING):
            raise
        with _environment(MUJOCO_GL="disable"):
            importlib.import_module("mujoco")


_import_mujoco()


def gl_available() -> str | None:
    """Whether something can be drawn, found out without loading any OpenGL into this process.

    Returns:
        The platform that would be used: "egl", "osmesa", "glfw" or "cgl"; None where there is none, see `ensure_gl`.
    """
    try:
        return _working_platform()
    except RenderError:
        return None


def ensure_gl() -> str:
    """Make MuJoCo's renderer use an OpenGL platform that works on this machine.

    The one that MUJOCO_GL names and no other, if it names one; else on Linux EGL, a window system, or OSMesa.

    Returns:
        The platform's name.

    Raises:
        RenderError: None works; the message says why, and which Debian packages help.
    """
    platform = _working_platform()
    from mujoco.rendering.classic import gl_context

    wanted = f"mujoco.{platform}"
    if getattr(getattr(gl_context, "GLContext", None), "__module__", None) != wanted:
        try:
            with _environment():
                gl_context.GLContext = importlib.import_module(wanted).GLContext
        except Exception as error:  # another OpenGL is loaded in this process
            raise RenderError(
                f"OpenGL platform {platform} works on this machine, but not beside what this process has loaded "
                f"({error}); set MUJOCO_GL={platform} before Python starts"
            ) from error
    return platform


def _working_platform() -> str:
    """The first platform that works, of those that MUJOCO_GL and the system leave.

    Raises:
        RenderError: None does.
    """
    chosen = os.environ.get("MUJOCO_GL", "").strip().lower()
    known = _PLATFORMS.get(sys.platform, ("glfw",))
    unharmed = "Walks, records and figures need no OpenGL."
    if chosen in _DISABLING:
        raise RenderError(f"MUJOCO_GL={chosen} switches drawing off; unset it, or set it to {known[0]}. {unharmed}")
    if chosen in _UNCHOSEN:
        candidates = known
    elif _ALIASES.get(chosen, chosen) in known:
        candidates = (_ALIASES.get(chosen, chosen),)
    else:
        raise RenderError(f"MUJOCO_GL={chosen} is no OpenGL platform; valid are {', '.join(known)}. {unharmed}")
    reasons = []
    for platform in candidates:
        reason = _obstacle(platform, tuple(sorted((k, v) for k, v in os.environ.items() if _matters(k))))
        if not reason:
            return platform
        reasons.append(f"{platform} ({reason})")
    cure = ""
    if sys.platform == "linux":
        cure = " On Debian or Ubuntu install libegl1 and libgl1-mesa-dri for EGL, or libosmesa6 for OSMesa."
    named = f"MUJOCO_GL={chosen} does not work here" if chosen not in _UNCHOSEN else "no OpenGL platform works here"
    raise RenderError(f"{named}: {'; '.join(reasons)}.{cure} {unharmed}")


def _matters(variable: str) -> bool:
    """Whether an environment variable can change what OpenGL does."""
    return variable == "DISPLAY" or any(part in variable for part in ("GL", "MESA", "GALLIUM", "LD_LIBRARY"))


@lru_cache(maxsize=32)
def _obstacle(platform: str, environment: tuple[tuple[str, str], ...]) -> str:
    """Why a platform cannot draw, in one line; empty where it can. Asked once per environment."""
    del environment  # only makes the answer be looked for anew
    if platform == "glfw" and sys.platform == "linux" and not (os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}):
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
    return _reason(probe.stderr, probe.returncode)


def _reason(errors: str, code: int) -> str:
    """The exception that a traceback tells of, or what else is known."""
    named = [line for line in errors.splitlines() if line and not line[0].isspace() and ": " in line]
    for line in reversed(named):
        kind, _, text = line.partition(": ")
        if kind.rpartition(".")[2].endswith(("Error", "Exception")):
            return "its library is missing" if "'NoneType' object has no attribute" in text else text.rstrip(".")
    return f"its driver failed with code {code}"
