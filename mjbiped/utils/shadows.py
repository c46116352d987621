"""Detect a user's module that hides the package `controllers`, because Python finds it first."""

from __future__ import annotations

import importlib.util
import sys
import warnings
from pathlib import Path

_OURS = Path(__file__).parents[2] / "controllers"


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
