"""Figures of lateral basins: how many steps a biped in space makes from another roll and roll rate than its gait's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_hex
from matplotlib.figure import Figure

from mjbiped.errors import InputError
from mjbiped.limit_cycles.lateral import LateralBasin
from mjbiped.plotting import width
from mjbiped.plotting.panels import plain, titled
from mjbiped.plotting.style import drawn

_GREYS = (0.9, 0.6)  # of walks that end at once, and of those that end just before the limit


def plot_lateral_basins(basins: Sequence[LateralBasin], path: str | Path | None = None) -> Figure:
    """Draw maps side by side: steps of each walk, and lines of equal divergent component.

    Args:
        basins: One to four maps.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix, or the maps are not one to four.
        RenderError: The file cannot be written.
    """
    if not 1 <= len(basins) <= 4:
        raise InputError(f"one to four lateral basins can be drawn, got {len(basins)}")
    with drawn(path) as figure:
        across = width().beside(min(len(basins), 2))
        lines = math.ceil(len(basins) / across)
        figure.set_figheight(0.4 + 4.3 * lines)
        for k, basin in enumerate(basins):
            axes = figure.add_subplot(lines, across, k + 1)
            _draw(figure, axes, basin, "abcd"[k] if len(basins) > 1 else "")
    return figure


def _draw(figure: Figure, axes: Axes, basin: LateralBasin, letter: str) -> None:
    """Draw one map: walks that go on in colour, walks that end in grey."""
    x, y, limit = np.degrees(basin.rolls), basin.roll_rates, basin.limit
    greys = [str(grey) for grey in np.linspace(*_GREYS, limit)]
    colours = ListedColormap([*greys, to_hex(colormaps["viridis"](0.35))])
    edges = np.arange(limit + 2) - 0.5
    steps = np.where(basin.steps < 0, np.nan, np.where(basin.fallen, np.minimum(basin.steps, limit - 1), limit))
    mesh = axes.pcolormesh(x, y, steps, cmap=colours, norm=BoundaryNorm(edges, limit + 1), rasterized=True)
    label = f"steps of the walk; at {limit} it goes on"
    ticks = sorted({0, limit // 2, limit})
    figure.colorbar(mesh, ax=axes, location="bottom", shrink=0.9, aspect=30, pad=0.02, ticks=ticks, label=label)
    if min(steps.shape) > 1 and np.isfinite(basin.deviations).all():
        lines = axes.contour(x, y, 100 * basin.deviations, levels=[-8, -4, 0, 4, 8], colors="black", linewidths=0.8)
        axes.clabel(lines, fmt=lambda cm: f"{cm:+.0f} cm".replace("-", "\u2212") if cm else "0 cm", fontsize="small")
    axes.plot(0.0, 0.0, "o", color="white", markeredgecolor="black", markersize=6)
    axes.set(xlabel="roll less the gait's (°)", ylabel="roll rate less the gait's (rad/s)")
    ground = f"{math.degrees(basin.slope):.3g}° down" if basin.slope else "level ground"
    titled(axes, letter, plain(f"{basin.walker} on {ground}: {100 * basin.share:.0f} %\u00a0of the starts walk on"))
