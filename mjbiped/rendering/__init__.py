"""Pictures and videos of walks, and their contents: the elements that explain a walk, each of which can be hidden.

The names are here, without MuJoCo and Matplotlib, which take long to load, because the command line's help shows them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from mjbiped.errors import InputError, shown
from mjbiped.utils.domains import entries, known_name

ELEMENTS: Mapping[str, str] = {
    "torque": "arcs at ankle and hip, whose area is the torque",
    "force": "the ground's force on the stance foot, an arrow",
    "ghost": "the posture that the controller tracks, if it tracks one",
    "estimate": "a line through the stance foot with the slope that the controller estimates",
    "traces": "the paths of the feet",
    "shadows": "a dark spot under each foot, which fades as the foot rises",
    "scale": "a bar of known length",
    "labels": "slopes and steps of the ground, in words",
    "caption": "time, step, slope and its estimate, and the legend",
    "chart": "slope, estimate and torques over time, with a cursor",
}
"""Elements that a picture can show beside robot and ground."""

ALL = "all"
"""Hides all elements."""

SUFFIXES = (".mp4", ".gif")
"""Suffixes of videos."""


class Look(NamedTuple):
    """Contents of a picture.

    Attributes:
        elements: Names of the `ELEMENTS` that are visible.
        visual: MuJoCo's visualisation flags to set or clear, by index.
        rendering: MuJoCo's rendering flags to set or clear, by index.
    """

    elements: frozenset[str]
    visual: Mapping[int, bool]
    rendering: Mapping[int, bool]

    def set_flags(self, visual: Any, rendering: Any, usual: Mapping[int, bool]) -> None:
        """Set MuJoCo's flags: the usual rendering flags of a window or picture first, then those of the look."""
        for flags, values in ((rendering, usual), (visual, self.visual), (rendering, self.rendering)):
            for flag, value in values.items():
                flags[flag] = value


def look(hide: str | Iterable[str] = (), flags: str | Iterable[str] = ()) -> Look:
    """Choose the contents of a picture.

    Args:
        hide: Names of `ELEMENTS` that are not shown, or "all"; one text may hold several, parted by commas.
        flags: Names of MuJoCo's visual flags that are set, as "contactpoint" for mjVIS_CONTACTPOINT or "wireframe" for
            mjRND_WIREFRAME, and with "no-" before them cleared, as "no-static"; several as above.

    Raises:
        InputError: A name is unknown; the message lists the valid ones.
    """
    from mjbiped.utils.mujoco import mujoco

    hidden = {known_name("element to hide", name, (*ELEMENTS, ALL)) for name in _names("hide", hide)}
    known: dict[str, tuple[int, int]] = {}
    for place, kind in enumerate((mujoco.mjtVisFlag, mujoco.mjtRndFlag)):
        for name, flag in kind.__members__.items():
            if not name.startswith("mjN"):
                known[name.partition("_")[2].lower()] = (place, int(flag))
    chosen: tuple[dict[int, bool], dict[int, bool]] = ({}, {})
    for name in _names("flags", flags):
        plain = name.lower().removeprefix("no-")
        place, flag = known[known_name("visual flag", plain, sorted(known))]
        chosen[place][flag] = plain == name.lower()
    return Look(frozenset() if ALL in hidden else frozenset(ELEMENTS) - hidden, *chosen)


def _names(what: str, value: object) -> list[str]:
    """Split names in a text or in a list of texts.

    Raises:
        InputError: It is neither.
    """
    parts = (value,) if isinstance(value, str) else entries(value)
    if parts is None or not all(isinstance(part, str) for part in parts):
        raise InputError(f"{what} = {shown(value)}: must be names, as a text parted by commas or a list of texts")
    return [name.strip() for part in parts for name in part.split(",") if name.strip()]
