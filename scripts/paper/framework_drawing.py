"""The control loop as a block diagram: what is computed where, and what passes between (Fig. 2 of the paper)."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from mjbiped.plotting import style as plot_style
from mjbiped.plotting import width
from mjbiped.plotting.style import BLACK, SHADE, VERMILLION

DRAWING: Mapping[str, Any] = tomllib.loads(Path(__file__).with_name("framework.toml").read_text(encoding="utf-8"))
HEIGHT = 4.85  # of the drawing, whose unit is the inch
LOWEST = 0.2
KINDS: Mapping[str, Mapping[str, Any]] = {
    "always": {"color": BLACK, "linestyle": "-"},
    "touchdown": {"color": VERMILLION, "linestyle": (0, (4, 1.6))},
}


def box(axes: Axes, ends: Sequence[float], **look: Any) -> None:
    """A rounded box between its left and right, lower and upper ends."""
    left, right, low, high = ends
    style = "round,pad=0,rounding_size=0.06"
    axes.add_patch(FancyBboxPatch((left, low), right - left, high - low, boxstyle=style, **look))


def block(axes: Axes, ends: Sequence[float], name: str, law: str) -> None:
    """A part of the loop: its box, its name, and what it computes under it."""
    box(axes, ends, facecolor="white", edgecolor=BLACK, lw=1.1, zorder=4)
    x, top = (ends[0] + ends[1]) / 2, (ends[2] + ends[3]) / 2 + 0.10 * (law.count("\n") + 1)
    axes.text(x, top, name, fontsize=9, weight="bold", ha="center", va="center", zorder=6)
    axes.text(x, top - 0.13, law, fontsize=9, linespacing=1.45, ha="center", va="top", zorder=6)


def wire(axes: Axes, kind: str, points: Sequence[tuple[float, float]]) -> None:
    """A signal's way through some points, with an arrow at its end."""
    look = KINDS[kind]
    axes.plot(*zip(*points, strict=True), linewidth=1.2, zorder=3, solid_capstyle="butt", **look)
    (x0, y0), (x1, y1) = points[-2:]
    share = 0.15 / max(abs(x1 - x0), abs(y1 - y0))  # of the last piece, for the arrow's head
    style = {"arrowstyle": "-|>", "color": look["color"], "lw": 0.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    axes.annotate("", points[-1], (x1 - share * (x1 - x0), y1 - share * (y1 - y0)), arrowprops=style, zorder=5)


def draw_framework() -> Figure:
    """The whole loop."""
    figure = plot_style.new_figure(HEIGHT - LOWEST)
    axes = figure.add_subplot()
    axes.set(xlim=(0.0, width().inches), ylim=(LOWEST, HEIGHT))
    axes.axis("off")
    for *ends, colour, name in DRAWING["groups"]:
        box(axes, ends, facecolor=colour, edgecolor=SHADE, lw=0.6, zorder=1)
        axes.text(ends[0] + 0.12, ends[2] + 0.13, name, fontsize=9, color=SHADE, va="bottom", linespacing=1.4)
    for *ends, name, law in DRAWING["blocks"]:
        block(axes, ends, name, law)
    for kind, *points in DRAWING["wires"]:
        wire(axes, kind, points)
    for kind, x, y in DRAWING["joins"]:
        axes.plot(x, y, "o", color=KINDS[kind]["color"], markersize=4, zorder=5)
    for kind, x, y, text in DRAWING["signals"]:
        axes.text(x, y, text, color=KINDS[kind]["color"], fontsize=9.5, va="bottom", ha="left", zorder=6)
    for x, text in ((0.65, "at every moment"), (2.45, "once a step, at touchdown")):
        axes.text(x, 4.62, text, fontsize=8.5, va="center")
    return figure
