"""Figure of a return map: each component after a step over the same one before it, and the gait's multipliers."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mjbiped.limit_cycles.map_slices import PUSH, MapSlices
from mjbiped.limit_cycles.periodic import places_of
from mjbiped.plotting.gait import draw_multipliers
from mjbiped.plotting.panels import head, legend_below, titled, wrapped
from mjbiped.plotting.style import BLUE, GREEN, GUIDE, ORANGE, drawn
from mjbiped.plotting.width import width

_PANEL = 3.3  # height, inches


def plot_return_map(slices: MapSlices, path: str | Path | None = None) -> Figure:
    """Draw a panel for each component, with the diagonal, the gait and a walk, and one for the multipliers.

    Where a curve crosses the diagonal the component repeats itself. The walk goes up or down to the next state, and
    across to the diagonal, where the next step begins.

    Args:
        slices: Slices through the map.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: The file cannot be written.
    """
    gait, panels = slices.gait, 1 + len(slices.components)
    with drawn(path) as figure:
        across = width().beside(2)
        lines = math.ceil(panels / across)
        stable = "stable" if gait.stable else "unstable"
        text = f"Return map on {math.degrees(gait.slope):.4g}°: the gait of period one is {stable}"
        if slices.settled is not None:
            text += f"; walks settle on one of period {len(slices.settled.states)}"
        text = wrapped(text)
        figure.set_figheight(0.4 + _PANEL * lines + head(figure, text))
        grid = figure.add_gridspec(lines, across)
        places = [figure.add_subplot(grid[k // across, k % across]) for k in range(panels)]
        for k, axes in enumerate(places[:-1]):
            _draw_slice(axes, "abc"[k], slices, k)
        draw_multipliers(places[-1], "abcd"[panels - 1], slices)
        legend_below(figure, *places[0].get_legend_handles_labels())
    return figure


def _draw_slice(axes: Axes, letter: str, slices: MapSlices, k: int) -> None:
    """One component after a step over the same one before it."""
    name, unit = slices.components[k].rsplit(" ", 1)
    ends = slices.before[k, [0, -1]]
    axes.plot(ends, ends, color=GUIDE, linewidth=0.9, label="diagonal: repeats itself")
    axes.plot(slices.before[k], slices.after[k], color=BLUE, label="one step, this component alone varied")
    stairs = np.repeat(slices.walk[:, k], 2)
    look: dict[str, Any] = {"color": ORANGE, "linewidth": 0.8, "marker": ".", "markersize": 3, "markevery": (0, 2)}
    axes.plot(stairs[:-1], stairs[1:], label=f"walk that begins {100 * PUSH:g} % off the gait", **look)
    if slices.settled is not None:
        count, found = len(slices.settled.states), places_of(slices.settled.states)[:, k]
        axes.plot(found, np.roll(found, -1), "s", color=GREEN, markersize=5, label=f"gait of period {count}", zorder=4)
    fixed = slices.fixed_point[k]
    ring: dict[str, Any] = {"color": "white", "markeredgecolor": "black", "markersize": 6, "zorder": 5}
    axes.plot(fixed, fixed, "o", label="gait of period one", **ring)
    axes.set(xlim=ends, ylim=ends, xlabel=f"before the step {unit}", ylabel=f"after it {unit}")
    titled(axes, letter, name[0].upper() + name[1:])
