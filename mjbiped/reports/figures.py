"""How the interactive figures of reports look: colours, letters, and what a figure is to the page."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.plotting.style import GUIDE, SHADE
from mjbiped.records.signals import DASHED, DOTTED, SIGNALS, SOLID

_DASHES = {SOLID: "solid", DASHED: "dash", DOTTED: "dot"}

_LAYOUT: dict[str, Any] = {
    "template": "none",
    "font": {"family": "system-ui, sans-serif", "size": 13, "color": "#222222"},
    "paper_bgcolor": "white",
    "plot_bgcolor": "white",
    "margin": {"l": 70, "r": 20, "t": 40, "b": 50},
    "legend": {"orientation": "h", "yanchor": "bottom", "y": 1.0, "xanchor": "left", "x": 0.0},
    "autosize": True,
}
AXIS: dict[str, Any] = {"gridcolor": "#e6e6e6", "linecolor": SHADE, "zerolinecolor": GUIDE, "ticks": "outside"}
"""Of every axis."""

HEADING: dict[str, Any] = {
    "showarrow": False,
    "align": "left",
    "font": {"size": 13},
    "xanchor": "left",
    "yanchor": "bottom",
}
"""Of a panel's title, an annotation."""


_LEAST_SPAN = 0.02  # of the values


class Shown(NamedTuple):
    """A figure of a page.

    Attributes:
        name: Of its place in the page, letters and dashes.
        title: Above it.
        note: Under the title; may be empty.
        plot: Of plotly.
        height: Pixels.
    """

    name: str
    title: str
    note: str
    plot: Any
    height: int


def layout(**more: Any) -> dict[str, Any]:
    """The layout of a figure, in plotly's own names."""
    return {**_LAYOUT, **more}


def line(signal: str, **more: Any) -> dict[str, Any]:
    """The look of a line that shows a signal of `mjbiped.records.signals.SIGNALS`, in plotly's own names."""
    row = SIGNALS[signal]
    return {"color": row.colour, "dash": _DASHES[row.line], "width": 1.6, **more}


def span(values: NDArray[Any]) -> dict[str, Any]:
    """The range of an axis whose values hardly differ, so that rounding does not fill the panel; else nothing."""
    known = values[np.isfinite(values)]
    if not known.size or np.ptp(known) > _LEAST_SPAN * np.abs(known).max():
        return {}
    middle, half = float(known.mean()), float(np.abs(known).max()) or 1.0
    return {"range": [middle - _LEAST_SPAN * half, middle + _LEAST_SPAN * half]}


def small(values: NDArray[Any]) -> NDArray[np.float32]:
    """Numbers as a page needs them: seven digits, half the bytes."""
    return np.asarray(values, dtype=np.float32)
