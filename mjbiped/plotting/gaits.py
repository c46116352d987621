"""Figures of many gaits and walks: return map, bifurcation diagram, multipliers over slope, basins of attraction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from mjbiped.errors import InputError
from mjbiped.limit_cycles.basin import Basin, Fate
from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade
from mjbiped.limit_cycles.map_slices import PUSH, MapSlices
from mjbiped.limit_cycles.periodic import PeriodicGait, places_of
from mjbiped.plotting import width
from mjbiped.plotting.gait import draw_multipliers
from mjbiped.plotting.panels import head, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import BLUE, GREEN, GUIDE, ORANGE, SHADE, VERMILLION, drawn, note_at, told_apart
from mjbiped.robots.compass import Array

_FALL_LIMIT = 6  # greatest number of steps until a fall with a grey of its own
_FALL_GREYS = (0.89, 0.77)
_SETTLED = ListedColormap(colormaps["viridis"](np.linspace(0.8, 0.0, 256)))
"""Without yellow, so that all of it is darker than falling starts in grey print."""


def plot_bifurcation(diagram: BifurcationDiagram, cascade: Cascade, path: Path | None = None) -> Figure:
    """Draw step length over slope: the whole diagram, and its cascade magnified.

    Args:
        diagram: Step lengths on each slope.
        cascade: Onsets to mark, and the gaits of period one, drawn as a line where they are unstable.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: The file cannot be written.
    """
    degrees, onsets, lost = np.degrees(diagram.slopes), np.degrees(cascade.onsets), math.degrees(diagram.lost)
    onsets = onsets[(onsets >= degrees[0]) & (onsets <= degrees[-1])]
    spans = [degrees[[0, -1]]]
    if cascade.window is not None:
        near = np.clip(np.degrees(cascade.window), degrees[0], np.fmin(degrees[-1], lost))
        spans += [near] if near[1] > near[0] else []
    words = ("Step lengths on which the passive robot settles", "The same, magnified")
    with drawn(path) as figure:
        figure.set_figheight(7.4 if len(spans) > 1 else 4.2)
        grid: Any = figure.subplots(len(spans), 1, squeeze=False)
        for (axes,), letter, title, span in zip(grid, "ab", words, spans, strict=False):
            _draw_diagram(axes, diagram, cascade, (float(span[0]), float(span[1])), onsets)
            titled(axes, letter, title)
            axes.set_title(axes.get_title(loc="left"), pad=6.0 + 1.5 * width().small)  # above the names of the onsets
        handles = [
            Line2D([], [], color=BLUE, linestyle="", marker=".", label="walked, the last steps of each slope"),
            Line2D([], [], color=VERMILLION, linestyle="--", label="period one, unstable"),
        ]
        legend_below(figure, handles)
        if math.isfinite(lost):
            grid[0, 0].axvline(lost, color=SHADE, linestyle=":", linewidth=1.0)
            paper = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}  # lines of onsets pass under the words
            note_at(grid[0, 0], f"first fall on {lost:.2f}°", lost, 0.02, (-4, 0), ha="right", va="bottom", bbox=paper)
    return figure


def _draw_diagram(
    axes: Axes, diagram: BifurcationDiagram, cascade: Cascade, limits: tuple[float, float], onsets: Array
) -> None:
    """Draw the points between two slopes, larger ones for periodic walking, and lines at the onsets."""
    degrees, lengths = np.degrees(diagram.slopes), diagram.step_lengths
    inside = (degrees >= limits[0]) & (degrees <= limits[1])
    repeats = diagram.counts() > 0
    for mine, size, alpha in ((inside & ~repeats, 1.0, 0.5), (inside & repeats, 1.8, 1.0)):
        x = np.repeat(degrees[mine], lengths.shape[1])
        look: dict[str, Any] = {"color": BLUE, "markersize": size, "alpha": alpha, "markeredgewidth": 0}
        axes.plot(x, lengths[mine].ravel(), ".", rasterized=True, **look)
    first = cascade.branches[0]
    born = [] if first.doubling is None else [first.doubling]
    # from the onset on, beyond both ends of the panel: it ends at none of the slopes that were followed
    unstable = [*born, *(gait for gait in first.gaits if not gait.stable)]
    if unstable:
        line = [(math.degrees(gait.slope), gait.step_lengths[0]) for gait in unstable]
        axes.plot(*np.transpose(line), color=VERMILLION, linestyle="--", linewidth=1.0)
    _name_onsets(axes, limits, [(onset, f"{2**number}: {onset:.4f}°") for number, onset in enumerate(onsets, start=1)])
    axes.set(xlim=limits, xlabel="slope (°)", ylabel="step length (m)")


def _name_onsets(axes: Axes, limits: tuple[float, float], onsets: Sequence[tuple[float, str]]) -> None:
    """Draw a line at each onset between two slopes, and names above them; those of near lines share a text."""
    letter = 0.07 / width().inches * (limits[1] - limits[0])  # width, in degrees of slope
    texts: list[tuple[float, str]] = []
    for onset, name in onsets:
        if limits[0] <= onset <= limits[1]:
            axes.axvline(onset, color=GUIDE, linewidth=0.7, zorder=0)
            if texts and onset < texts[-1][0] + letter * len(texts[-1][1]):
                texts[-1] = (texts[-1][0], f"{texts[-1][1]}, {name}")
            else:
                texts.append((onset, f"period {name}"))
    for onset, text in texts:
        x, side = (onset, "left") if onset + letter * len(text) < limits[1] else (limits[1], "right")
        above = axes.get_xaxis_transform()
        axes.text(x, 1.015, text, transform=above, ha=side, fontsize=width().small, color=SHADE)


def plot_multipliers(branches: Sequence[Sequence[PeriodicGait]], path: Path | None = None) -> Figure:
    """Draw the Floquet multipliers of branches of gaits over slope: their magnitudes and their real parts.

    Args:
        branches: Gaits of each branch in the order of their slopes, at least two, with equal numbers of steps.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix, or a branch has fewer than two gaits.
        RenderError: The file cannot be written.
    """
    if not branches or min(len(gaits) for gaits in branches) < 2:
        raise InputError("multipliers over slope need branches of at least two gaits each")
    with drawn(path) as figure:
        figure.set_figheight(7.0)
        grid: Any = figure.subplots(2, 1, sharex=True)
        for number, gaits in enumerate(branches):
            color, _, line = told_apart(number)
            degrees = [math.degrees(gait.slope) for gait in gaits]
            multipliers = np.array([gait.multipliers for gait in gaits])
            for part, axes in zip((np.abs(multipliers), multipliers.real), grid, strict=True):
                for k, values in enumerate(np.sort(part, axis=1).T):
                    label = f"period {len(gaits[0].states)}" if k == 0 else None
                    axes.plot(degrees, values, color=color, linestyle=line, label=label)
        grid[0].axhline(1.0, color=SHADE, linewidth=0.8)
        grid[0].set(ylabel="|multiplier|", ylim=(0, 2.5))
        titled(grid[0], "a", "Magnitude; the gait is stable while all are below one")
        legend_below(figure, *grid[0].get_legend_handles_labels())
        for level in (-1.0, 1.0):
            grid[1].axhline(level, color=SHADE, linewidth=0.8)
        grid[1].set(ylabel="real part", xlabel="slope (°)", ylim=(-2.5, 1.25))
        titled(grid[1], "b", "Real part; at −1 the period doubles")
    return figure


def plot_basins(basins: Sequence[Basin], path: Path | None = None) -> Figure:
    """Draw maps of fates side by side: steps until settled or fallen, and peak torques where there is control.

    Args:
        basins: One or two maps; if the second contains the first, a frame shows where.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix, or the maps are not one or two.
        RenderError: The file cannot be written.
    """
    if not 1 <= len(basins) <= 2:
        raise InputError(f"one or two basins can be drawn, got {len(basins)}")
    with drawn(path) as figure:
        across = width().beside(len(basins))
        figure.set_figheight(0.4 + 4.8 * (len(basins) // across))
        panels = figure.subplots(len(basins) // across, across, squeeze=False).ravel().tolist()
        for axes, letter, basin in zip(panels, "ab", basins, strict=False):
            _draw_basin(figure, axes, basin, letter if len(basins) > 1 else "")
        if len(basins) == 2:
            _frame(panels[1], basins[0], basins[1])
        light, dark = (str(grey) for grey in _FALL_GREYS)
        handles: list[Artist] = [  # under the maps, whose whole area holds data
            Line2D([], [], linestyle="", marker="o", color="white", markeredgecolor="black", label="the gait"),
            Patch(facecolor=light, edgecolor=GUIDE, label="falls at once"),
            Patch(facecolor=dark, edgecolor=GUIDE, label=f"falls after {_FALL_LIMIT} steps or more"),
        ]
        if any(np.isin(basin.fates, (Fate.SETTLED, Fate.FELL), invert=True).any() for basin in basins):
            handles.append(Patch(facecolor=VERMILLION, label="neither"))
        legend_below(figure, handles)
    return figure


def _draw_basin(figure: Figure, axes: Axes, basin: Basin, letter: str) -> None:
    """Draw one map: settling starts in colour, falling starts in grey."""
    settled, fell = basin.fates == Fate.SETTLED, basin.fates == Fate.FELL
    x, y = basin.stance_rates, basin.swing_rates
    greys = ListedColormap([str(grey) for grey in np.linspace(*_FALL_GREYS, _FALL_LIMIT + 1)])
    falls = np.where(fell, np.minimum(basin.steps, _FALL_LIMIT), np.nan)
    axes.pcolormesh(x, y, falls, cmap=greys, vmin=-0.5, vmax=_FALL_LIMIT + 0.5, rasterized=True)
    neither = np.where(settled | fell, np.nan, 1.0)
    axes.pcolormesh(x, y, neither, cmap=ListedColormap([VERMILLION]), vmin=0, vmax=1, rasterized=True)
    controlled = bool(basin.peak_torque.any())
    values = np.where(settled, basin.peak_torque if controlled else basin.steps, np.nan)
    inside = values[settled] if settled.any() else np.array([1.0, 10.0])
    if controlled:
        norm: Normalize = LogNorm(max(float(inside.min()), 0.1), max(float(inside.max()), 1.0))
        label, ends = "greatest joint torque on the way (N m)", "neither"
    else:
        norm = Normalize(0.0, max(float(np.quantile(inside, 0.995)), 1.0))
        label, ends = "steps until settled on the gait", "max"
    mesh = axes.pcolormesh(x, y, values, cmap=_SETTLED, norm=norm, rasterized=True)
    figure.colorbar(mesh, ax=axes, location="bottom", shrink=0.9, aspect=30, pad=0.02, extend=ends, label=label)
    half = len(basin.start) // 2
    axes.plot(basin.start[half], basin.start[half + 1], "o", color="white", markeredgecolor="black", markersize=6)
    axes.set(xlabel="rate of the stance leg after the impact (rad/s)", ylabel="rate of the swing leg (rad/s)")
    ground = f"{math.degrees(basin.slope):.3g}° down" if basin.slope else "level ground"
    share = f"{100 * basin.share(Fate.SETTLED):.1f} %\u00a0of the window settle"
    titled(axes, letter, plain(f"{basin.walker} on {ground}: {share}"))


def _frame(axes: Axes, small: Basin, great: Basin) -> None:
    """Draw a frame where the smaller map lies in the larger one."""
    left, right = small.stance_rates[[0, -1]]
    low, high = small.swing_rates[[0, -1]]
    inside = great.stance_rates[0] < left < right < great.stance_rates[-1]
    if inside and great.swing_rates[0] < low < high < great.swing_rates[-1]:
        axes.plot([left, right, right, left, left], [low, low, high, high, low], color="black", linewidth=0.8)


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
    stable = "stable" if gait.stable else "unstable"
    text = f"Return map on {math.degrees(gait.slope):.4g}°: the gait of period one is {stable}"
    if slices.settled is not None:
        text += f"; walks settle on one of period {len(slices.settled.states)}"
    text = wrapped(text)
    with drawn(path) as figure:
        across = width().beside(2)
        lines = math.ceil(panels / across)
        figure.set_figheight(0.4 + 3.3 * lines + head(figure, text))
        *places, last = (figure.add_subplot(lines, across, k) for k in range(1, panels + 1))
        for k, axes in enumerate(places):
            _draw_slice(axes, "abcde"[k], slices, k)
        draw_multipliers(last, "abcdef"[panels - 1], gait)
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
