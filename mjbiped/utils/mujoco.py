"""MuJoCo, imported even if MUJOCO_GL names an OpenGL platform that this machine has not.

MuJoCo reads MUJOCO_GL once, when it is imported, and cannot be imported at all if the library of the platform that it
names is missing. A walk needs no OpenGL, so every module of this package takes MuJoCo from here.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

DISABLING = ("disable", "disabled", "off", "false", "0")  # MuJoCo's own words
UNCHOSEN = ("", "enable", "enabled", "on", "true", "1")


@contextmanager
def environment(**changes: str) -> Iterator[None]:
    """Change environment variables for a block, and restore PYOPENGL_PLATFORM, which MuJoCo sets, as well."""
    kept = {name: os.environ.get(name) for name in (*changes, "PYOPENGL_PLATFORM")}
    os.environ.update(changes)
    try:
        yield
    finally:
        for name, value in kept.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


def chosen_platform() -> str:
    """Return what MUJOCO_GL says, in small letters."""
    return os.environ.get("MUJOCO_GL", "").strip().lower()


try:
    with environment():
        import mujoco as mujoco
except Exception:  # RuntimeError, AttributeError, OSError: whatever a missing library of the chosen platform leads to
    if chosen_platform() in (*UNCHOSEN, *DISABLING):
        raise
    with environment(MUJOCO_GL="disable"):
        import mujoco as mujoco
