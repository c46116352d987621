"""Packages that a program cannot import, and the second name of `controllers`, which a user's file may hide."""

from __future__ import annotations

import importlib.util
import pkgutil
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

from mjbiped.errors import InputError

_OURS = tuple(Path(__file__).parents[up] / "controllers" for up in (1, 2))

_IN_WORDS = {
    "distributed": "Dask Distributed",
    "pyarrow": "PyArrow",
    "plotly": "Plotly",
    "jinja2": "Jinja",
    "mcap_ros2": "mcap-ros2-support",
}


def needed(module: str, extra: str, what: str) -> ModuleType:
    """Import a module of an extra.

    Args:
        module: Full name of the module.
        extra: The extra of mjbiped that installs its package.
        what: Feature that needs the module; the message begins with it.

    Returns:
        The module.

    Raises:
        InputError: The package is not installed; the message says how to install it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise InputError(
            f"{what} needs {_IN_WORDS.get(package, package)}, which is not installed: pip install 'mjbiped[{extra}]'"
        ) from error


def second_name(package: str, second: str) -> None:
    """Let a package and its modules be imported by a second name too: each is loaded once and has both names.

    Args:
        package: Its own name.
        second: Name of the module that stands for it, which calls this while it is imported.
    """
    ours = import_module(package)
    for found in pkgutil.walk_packages(ours.__path__, f"{package}."):
        sys.modules[second + found.name.removeprefix(package)] = import_module(found.name)
    sys.modules[second] = ours


def hidden_laws() -> str:
    """Return a message that names the file which hides the package `controllers`; empty if there is none."""
    module = sys.modules.get("controllers")
    found = getattr(importlib.util.find_spec("controllers") if module is None else module.__spec__, "origin", None)
    if found is None or Path(found).parent in _OURS:
        return ""
    return (
        f"{found} hides mjbiped's package `controllers`: import from `mjbiped.controllers`, which is the same, or give "
        "the file (or folder) another name"
    )
