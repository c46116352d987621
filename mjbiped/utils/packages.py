"""Packages that a program cannot import: extras that are not installed, or `controllers` hidden by a user's file."""

from __future__ import annotations

import importlib.util
import sys
import warnings
from importlib import import_module
from pathlib import Path
from types import ModuleType

from mjbiped.errors import InputError

_OURS = Path(__file__).parents[2] / "controllers"

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


def hidden_laws() -> str:
    """Return a message that names the file which hides the package `controllers`; empty if there is none."""
    module = sys.modules.get("controllers")
    found = getattr(importlib.util.find_spec("controllers") if module is None else module.__spec__, "origin", None)
    if found is None or Path(found).parent == _OURS or not _OURS.is_dir():
        return ""
    return (
        f"the file {found} hides mjbiped's own package `controllers`, which Python looks for by that name: give the "
        "file (or folder) another name, for instance my_controllers.py"
    )


def warn_of_hidden_laws() -> None:
    """Warn when a program imports mjbiped: its next import from `controllers` would fail without explanation."""
    # `python -m mjbiped` reports it by itself, and ends
    if sys.argv[:1] != ["-m"] and (hidden := hidden_laws()):
        warnings.warn(hidden, stacklevel=3)
