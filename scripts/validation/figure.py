"""The figure of docs/validation.md: gaits of the simplest walker on all slopes, and how the compass tends to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from mjbiped.plotting.panels import titled
from mjbiped.plotting.style import BLACK, BLUE, GREEN, GUIDE, ORANGE, VERMILLION, drawn, make_small, note_at
from scripts.validation.published import GARCIA, GARCIA_SLOPE
from scripts.validation.simplest_walker import GARCIAS, branch, convergence, long_gait

STEEPEST = 0.018  # rad
TICKS = (0.0, 0.001, 0.003, 0.006, 0.009, 0.012, 0.015, 0.018)
RATIOS = 10.0 ** -np.arange(2.0, 6.1, 0.5)
LOOKS = {"long": (BLUE, "-"), "short": (ORANGE, (0, (5, 1.5)))}


def _draw_gaits(axes: Axes) -> None:
    for name, (colour, line) in LOOKS.items():
        slopes = np.concatenate([np.geomspace(GARCIA_SLOPE, 2e-5, 40), np.linspace(GARCIA_SLOPE, STEEPEST, 30)])
        half = 40
        gaits = [*branch(name, slopes[:half])[::-1], *branch(name, slopes[half:])]
        found = np.array([each.slope for each in gaits])
        angles = np.array([-each.states[0, 0] for each in gaits])
        axes.plot(found, angles / np.cbrt(found), color=colour, linestyle=line, label=f"{name} gaits, ours")
        first, second = (GARCIA[f"{name} {term}"].value.real for term in ("Theta0", "Theta1"))
        ends = np.linspace(0.0, STEEPEST, 100)
        look: Any = {"color": VERMILLION if name == "long" else GREEN, "linestyle": (0, (1, 1.2)), "linewidth": 1.8}
        axes.plot(ends, first + second * ends ** (2 / 3), label=f"{name} gaits, series as published", **look)
        point = GARCIA[f"{name} angle"].value.real / np.cbrt(GARCIA_SLOPE)
        label = "gaits on 0.009, as published" if name == "long" else None
        axes.plot(GARCIA_SLOPE, point, "o", color=BLACK, markerfacecolor="white", label=label)
    onset = GARCIAS["doubling"]().value.real
    axes.axvline(onset, color=GUIDE, linewidth=0.8)
    note_at(axes, "period doubles", onset, 0.97, (-4, 0), ha="right", va="top")
    axes.set_xscale(
        "function", functions=(lambda x: np.maximum(x, 0.0) ** (2 / 3), lambda x: np.maximum(x, 0.0) ** 1.5)
    )
    axes.set(xlim=(0.0, STEEPEST), ylim=(0.908, None), xticks=TICKS, ylabel=r"$\theta\,/\,\gamma^{1/3}$")
    axes.set_xlabel("slope γ, rad (spaced as its power 2/3)")
    axes.legend(loc="lower left")
    titled(axes, "a", "angle of the simplest walker after the heel strike")


def _draw_convergence(axes: Axes) -> None:
    exact = long_gait()
    limit = np.array([-exact.start[0], -exact.start[2], exact.period, abs(exact.multipliers[0])])
    distance = np.abs(convergence(RATIOS) - limit)
    marks = (
        (BLUE, "o", "θ"),
        (ORANGE, "s", "θ̇"),
        (GREEN, "^", "period"),
        (VERMILLION, "D", "modulus of the multipliers"),
    )
    for column, (colour, mark, label) in zip(distance.T, marks, strict=True):
        axes.loglog(RATIOS, column, color=colour, marker=mark, markersize=4, linewidth=0.8, label=label)
    axes.loglog(RATIOS, 0.7 * RATIOS, color=GUIDE, linestyle=(0, (3, 1.5)), label="first order")
    axes.set(xlabel="mass of a leg over that of the hip", ylabel="distance from the limit")
    axes.legend(loc="lower right")
    titled(axes, "b", "compass with light legs")


def draw(path: Path) -> None:
    """Draw both panels.

    Args:
        path: A PNG file.
    """
    with drawn(path) as figure:
        figure.set_figheight(4.2)
        panels: Any = figure.subplots(1, 2, width_ratios=(3, 2))
        _draw_gaits(panels[0])
        _draw_convergence(panels[1])
    make_small(path)
