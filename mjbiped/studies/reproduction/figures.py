"""Figures 5 and 6 of the paper, and Table III as a picture; Fig. 4 is `mjbiped.plotting.walk.plot_walk`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from mjbiped.plotting import width
from mjbiped.plotting.panels import draw_over_time, head, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import BLACK, C_MT, ESTIMATE, GUIDE, HYBRID, MUJOCO, TRUTH, drawn, make_small
from mjbiped.plotting.walk import plot_walk
from mjbiped.records.record import Walk
from mjbiped.records.signals import lines_of
from mjbiped.studies.reproduction import section_5 as paper
from mjbiped.studies.reproduction.claims import walks_of
from mjbiped.studies.reproduction.results import ENGINES, Row, engine_shown

_SHOWN = 16.0  # s of Fig. 5
_STARTS = ({"linestyle": (0, (5, 1.5)), "linewidth": 1.6}, {"linestyle": "-", "linewidth": 1.0})
_WITHOUT = {**ESTIMATE, "color": "#8FD3BF"}
"""The estimate, paler."""
_ENGINE_LOOKS = {
    "hybrid": {**HYBRID, "marker": "s", "markersize": 5.5, "linestyle": "-", "markerfacecolor": "white"},
    "mujoco": {**MUJOCO, "marker": "x", "markersize": 5.0, "linestyle": (0, (1.5, 1.2))},
}
_NAMES, _AXES = ("Greatest torque", "Cost of transport"), ("greatest torque (N m)", C_MT)
_UNKNOWN = (math.nan, math.nan)
_PAPER_LOOK = {"color": BLACK, "marker": "o", "markersize": 4.0, "linestyle": (0, (4, 1.2))}

Curve = Mapping[float | None, tuple[float, float]]
"""Greatest torque (N m) and c_mt by zeta; None: no re-planning."""


def draw(recorded: Sequence[tuple[Row, Walk]], rows: Sequence[Row], pages: Path, prints: Path) -> list[Path]:
    """Draw Figs. 4 to 6 of each engine that has the walks, and Table III.

    Args:
        recorded: Walks whose records are kept, with their rows.
        rows: Rows of all walks.
        pages: Folder for the figures that the page shows, small PNG files.
        prints: Folder for all figures as PDF files.

    Returns:
        The files.
    """
    drawings: dict[str, Callable[[Path], object]] = {"table_3": partial(plot_table_3, rows)}
    for engine in dict.fromkeys(row.engine for row, _ in recorded):
        mine = [(row, walk) for row, walk in recorded if row.engine == engine]
        by_delay = {row.delay: walk for row, walk in mine if (row.part, row.ground) == ("table 3", "mixed")}
        curves: dict[float, dict[tuple[float, bool], Walk]] = {gain: {} for gain in paper.ADAPTATION_GAINS}
        for row, walk in mine:
            if row.part == "figure 5":
                curves[row.adaptation_gain][row.start_estimate, row.update == "yes"] = walk
        drawings |= {
            f"fig_6_mixed_{engine}": partial(plot_figure_6, {delay: by_delay[delay] for delay in paper.DRAWN_DELAYS}),
            f"fig_5_{engine}": partial(plot_figure_5, curves),
            f"fig_4_mixed_{engine}": partial(plot_walk, curves[paper.PAPER_GAIN][paper.START_ESTIMATES[0], True]),
        }
    written = []
    for name, make in drawings.items():
        written.append(prints / f"reproduction_{name}.pdf")
        make(written[-1])
        if name.endswith((engine_shown(rows), "table_3")):
            written.append(pages / f"reproduction_{name}.png")
            make(written[-1])
            make_small(written[-1])
    return written


def plot_figure_5(walks: Mapping[float, Mapping[tuple[float, bool], Walk]], path: str | Path | None = None) -> Figure:
    """Draw the slope estimate with and without the estimate update (27), from several estimates at the start.

    Args:
        walks: By gamma, a row of the figure each; then by the estimate at the start (degrees) and whether the update
            acts, a curve each.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix.
        RenderError: The file cannot be written.
    """
    first = next(iter(next(iter(walks.values())).values()))
    with drawn(path) as figure:
        figure.set_figheight(0.9 + 1.65 * len(walks) + head(figure, _caption("Fig. 5", first)))
        grid = figure.subplots(len(walks), 1, sharex=True, sharey=True, squeeze=False)
        for letter, (axes,), (gain, curves) in zip(ascii_lowercase, grid, walks.items(), strict=False):
            styles = dict(zip(sorted({start for start, _ in curves}), _STARTS, strict=True))
            for (start, update), walk in sorted(curves.items()):  # those with the update over those without
                name = f"{'with' if update else 'without'} the update (27), from {start:+g}°".replace("-", "−")
                shown = walk.samples["time"] <= _SHOWN
                estimate = np.degrees(walk.samples["slope_estimate"][shown])
                color = (ESTIMATE if update else _WITHOUT)["color"]
                axes.plot(walk.samples["time"][shown], estimate, label=name, color=color, **styles[start])
            # a walk that lands on the other side of an edge has another truth there
            truths = {tuple(walk.touchdowns["slope"].round(6).tolist()): walk for walk in curves.values()}
            for place, walk in enumerate(truths.values()):
                slope = np.degrees(walk.samples["slope"])
                axes.plot(walk.samples["time"], slope, label=None if place else "true", **TRUTH)
            for moment in next(iter(truths.values())).touchdowns["time"]:
                axes.axvline(moment, color=GUIDE, linewidth=0.3, alpha=0.5, zorder=0)
            axes.set(ylabel="slope (°)", xlim=(0.0, _SHOWN))
            titled(axes, letter, f"γ = {gain:g}")
        legend_below(figure, *grid[0, 0].get_legend_handles_labels())
        grid[-1, 0].set_xlabel("time (s)")
    return figure


def plot_figure_6(walks: Mapping[float | None, Walk], path: str | Path | None = None) -> Figure:
    """Draw slope estimate and joint torques for some zeta, a row each.

    Args:
        walks: By zeta; None: no re-planning.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix.
        RenderError: The file cannot be written.
    """
    with drawn(path) as figure:
        across = width().beside(2)
        caption = _caption("Fig. 6", next(iter(walks.values())))
        figure.set_figheight(0.4 + 1.9 * len(walks) * (2 // across) + head(figure, caption))
        shared: Any = {"sharex": True, "sharey": "col" if across == 2 else "none", "squeeze": False}
        grid = figure.subplots(2 * len(walks) // across, across, **shared)
        panels = iter(grid.ravel())
        letters = iter(ascii_lowercase)
        for delay, walk in walks.items():
            name = "no re-planning" if delay is None else f"ζ = {delay:g}"
            torque = f"Torque, {name}: greatest {max(walk.peak_torque):.1f}\u00a0N\u00a0m"
            for title, lines in zip((f"Slope estimate, {name}", torque), lines_of(walk), strict=False):
                draw_over_time(next(panels), walk, next(letters), lines, title)
        for axes in grid[-1]:
            axes.set_xlabel("time (s)")
    return figure


def plot_table_3(rows: Sequence[Row], path: str | Path | None = None) -> Figure:
    """Draw Table III, the paper's and ours: greatest torque and c_mt over zeta, on both mixed grounds.

    Args:
        rows: Rows of the report.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix.
        RenderError: The file cannot be written.
    """
    zetas = [zeta for zeta in paper.TABLE_3 if zeta is not None]
    with drawn(path) as figure:
        across = width().beside(2)
        figure.set_figheight(0.4 + 2.8 * (4 // across))
        order: Any = "C" if across == 2 else "F"  # below each other, those of one ground stand together
        grid = figure.subplots(4 // across, across, sharex=True, squeeze=False).reshape(2, 2, order=order)
        letters = np.array(list("abcd")).reshape(2, 2, order=order)
        for column, (ground, title) in enumerate((("mixed", "our mixed ground"), ("found", "the ground found"))):
            curves: dict[str, tuple[Curve, Mapping[str, Any]]] = {"paper": (paper.TABLE_3, _PAPER_LOOK)}
            for engine, label in ENGINES.items():
                walks = walks_of(rows, ground, engine)
                if walks.keys() >= paper.TABLE_3.keys():
                    ours = {z: (w.torque, w.absolute_end) if w.finished else _UNKNOWN for z, w in walks.items()}
                    curves[label] = ours, _ENGINE_LOOKS[engine]
            for place, (axes, name, what) in enumerate(zip(grid[:, column], _NAMES, _AXES, strict=True)):
                for label, (values, look) in curves.items():
                    axes.plot(zetas, [values[zeta][place] for zeta in zetas], label=label, **look)
                    lines = {"color": look["color"], "linestyle": look["linestyle"]}
                    axes.axhline(values[None][place], **lines, linewidth=0.8, alpha=0.8)
                axes.set(yscale="log", ylabel=what, xticks=zetas)
                axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
                axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
                axes.yaxis.set_minor_locator(NullLocator())
                titled(axes, letters[place, column], f"{name}, {title}")
        for axes in grid[-1][2 - across :]:
            axes.set_xlabel("ζ;  horizontal lines: no re-planning")
        legend_below(figure, *grid[0, 0].get_legend_handles_labels())
    return figure


def _caption(figure: str, walk: Walk) -> str:
    law = walk.settings["controller"]
    gains = f"K₁ = {law['position_gain']:g}, K₂ = {law['velocity_gain']:g}"
    slope = math.degrees(law["gait"]["slope"])
    engine = ENGINES[walk.settings["engine"]]
    return plain(
        wrapped(f"{figure}: {walk.terrain.caption}, from rest, {gains}, imitated slope {slope:g}°, {engine} engine")
    )
