"""How a walk is drawn, for those who ask the record for it.

A record knows neither Matplotlib nor OpenGL, and no package that does. The package `mjbiped` itself names, when it is
imported, what draws each view; that is imported when the first one is asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from pkgutil import resolve_name
from typing import Any

_DRAWERS: dict[str, str] = {}


def register(**drawers: str) -> None:
    """Say what draws a view.

    Args:
        **drawers: Functions as "module:name", by view: `figure` (walk, path) gives a figure and writes it where there
            is a path; `video` (walk, path, **settings) writes a file; `picture` (walk) gives a small PNG's bytes.
    """
    _DRAWERS.update(drawers)


def drawer(view: str) -> Callable[..., Any]:
    """The function that draws a view."""
    function: Callable[..., Any] = resolve_name(_DRAWERS[view])
    return function
