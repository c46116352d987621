"""Survival curves: the share of walks that go on, over the number of steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from mjbiped.analysis.survival import Survival
from mjbiped.plotting.panels import legend_below, plain
from mjbiped.plotting.style import GUIDE, drawn, told_apart


def plot_survival(survivals: Mapping[str, Survival], path: str | Path | None = None) -> Figure:
    """Draw survival curves by Kaplan and Meier with 95 % bands, and the mean numbers of steps to a fall in words.

    Args:
        survivals: Survival curves by their names in the legend.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: The file cannot be written.
    """
    with drawn(path) as figure:
        figure.set_figheight(3.4)
        axes = figure.subplots()
        for number, (name, survival) in enumerate(survivals.items()):
            draw_curve(axes, survival, f"{name}: {mean_in_words(survival)}", told_apart(number))
        lay_axes(axes, max(max(survival.steps) for survival in survivals.values()))
        axes.set_xlabel("steps (logarithmic)")
        legend_below(figure, *axes.get_legend_handles_labels())
    return figure


def mean_in_words(survival: Survival) -> str:
    """Return the mean number of steps to a fall in words."""
    return "no fall" if math.isinf(survival.mean) else f"a fall in {survival.mean:.3g} steps"


def draw_curve(axes: Axes, survival: Survival, label: str, looks: tuple[str, str, object]) -> None:
    """Draw a curve and its band."""
    colour, _, line = looks
    steps, share, low, high = survival.curve()
    axes.step(steps, share, where="post", color=colour, linestyle=line, label=plain(label))
    axes.fill_between(steps, low, high, step="post", color=colour, alpha=0.15, linewidth=0.0)


def lay_axes(axes: Axes, most: int) -> None:
    """Set the axes of a panel of curves, up to a greatest number of steps."""
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.set_xlim(1.0, max(most, 2))
    axes.set_ylim(0.0, 1.03)
    axes.set_ylabel("share still walking")
    axes.grid(color=GUIDE, alpha=0.3)
