"""Titles and legends of panels, fitted to the figure's width; signals, phase portraits and survival curves in them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray

from mjbiped.analysis.replay import drawn_gait, drawn_transitions
from mjbiped.analysis.survival import Survival
from mjbiped.plotting import width
from mjbiped.plotting.style import BLUE, C_MT, GUIDE, ORANGE, SHADE, look, told_apart, widen, zero_line
from mjbiped.records.record import Walk
from mjbiped.records.signals import Lines, Signal, Values, signals_of
from mjbiped.robots.in_space import InSpace

_MARGIN = 0.62  # inches beside a panel, for the labels of its vertical axis
_MARGIN_OF_ONE_SCALE = 1.1  # beside a panel with one scale for both axes, which is narrower than its place
_PIXELS = 1.04  # letters are fitted to coarser pixels
_GAP = 0.1  # between a title and a legend beside it, inches
_AS_WIDE = "\ue000" * 3  # stands for c_mt while lines are broken
_MOST_TICKED = 60  # greatest number of touchdowns that are marked on time axes
_POINTS = 200  # of an imitated gait

Kept = slice | NDArray[np.int64]
"""Samples that are drawn."""


def plain(text: str) -> str:
    """Escape a text that matplotlib must not read as a formula, such as a file's name."""
    return text.replace("$", r"\$")


def wrapped(text: str, *, lines: int | None = None, beside: float = 0.2) -> str:
    """Wrap a text into lines as wide as the figure.

    Args:
        text: The text, in which the symbol c_mt is not broken, and counts as wide as it is drawn.
        lines: Greatest number of lines.
        beside: Width of the figure that is left free, inches.
    """
    parts = textwrap.wrap(text.replace(C_MT, _AS_WIDE), width().letters(beside), max_lines=lines, placeholder=" ...")
    return "\n".join(parts).replace(_AS_WIDE, C_MT)


def labelled(axes: Axes, text: str) -> None:
    """Label the horizontal axis of a panel that is as wide as the figure, in lines that fit."""
    axes.set_xlabel(wrapped(text, beside=_MARGIN))


def head(figure: FigureBase, text: str) -> float:
    """Write a heading in small letters above the panels, and return its height, inches."""
    figure.suptitle(text, fontsize=width().font, x=0.01, ha="left", linespacing=1.4)
    return 1.4 * width().font / 72.0 * (1 + text.count("\n"))


def titled(axes: Axes, letter: str, words: str) -> None:
    """Give a panel its letter and its title, in lines that fit."""
    title = axes.set_title(f"({letter}) {words}" if letter else words)
    wide = _inches(title)
    if wide > _room(axes):
        lines = title.get_text().split("\n")
        fitting = max(10, int(max(map(len, lines)) * _room(axes) / wide))
        title.set_text("\n".join("\n".join(textwrap.wrap(line, fitting, break_long_words=False)) for line in lines))


def legend_above(axes: Axes, **settings: Any) -> None:
    """Draw a legend above a panel, at its right, below the title if they do not fit beside each other.

    Args:
        axes: The panel.
        **settings: Arguments of matplotlib's `legend`.
    """
    columns = 9
    settings |= {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.0, "columnspacing": 1.2}
    while True:
        legend = axes.legend(ncols=columns, **settings)
        columns = min(columns, len(legend.get_texts())) - 1
        if columns < 1 or _inches(legend) < _room(axes):
            break
    title = axes.set_title(axes.get_title(loc="left"))
    if _inches(title) + _GAP + _inches(legend) > _room(axes):
        axes.set_title(title.get_text(), pad=72.0 * legend.get_window_extent().height / legend.figure.dpi)


def legend_below(figure: FigureBase, handles: Sequence[Artist], names: Sequence[str] | None = None) -> None:
    """Draw a legend under all panels, in as few lines as the figure's width allows."""
    names = [str(handle.get_label()) for handle in handles] if names is None else names
    for columns in range(len(handles), 0, -1):
        legend = figure.legend(handles, names, loc="outside lower center", ncols=columns, columnspacing=1.2)
        if columns == 1 or _inches(legend) < 0.97 * width().inches:
            return
        legend.remove()


def _room(axes: Axes) -> float:
    """Approximate width of a panel of the grid, inches."""
    share, spec = 1.0, axes.get_subplotspec()
    if spec is not None:
        grid = spec.get_gridspec()
        ratios: Any = grid.get_width_ratios() or [1.0] * grid.ncols
        share = sum(ratios[column] for column in spec.colspan) / sum(ratios)
    return float(share * width().inches - (_MARGIN if axes.get_aspect() == "auto" else _MARGIN_OF_ONE_SCALE))


def _inches(artist: Artist) -> float:
    """Width of an artist as drawn, inches."""
    return float(_PIXELS * artist.get_window_extent().width / artist.figure.dpi)


def curves_over_time(
    walk: Walk, lines: Lines, keep: Kept = slice(None)
) -> Iterator[tuple[str, Signal, Values, Values]]:
    """Make the curves of a panel, with a gap between steps where the values jump because the legs change roles.

    Args:
        walk: The record.
        lines: Signals of the panel.
        keep: Samples that are drawn.

    Yields:
        Name in `mjbiped.records.signals.SIGNALS`, signal, times (s) and values in the panel's unit.
    """
    time = walk.samples["time"][keep]
    gaps = np.flatnonzero(np.diff(walk.samples["stance"][keep]) * lines.panel.by_legs) + 1
    for name, signal in lines.signals.items():
        yield name, signal, np.insert(time, gaps, time[gaps]), np.insert(lines.values[name][keep], gaps, np.nan)


def draw_signals(axes: Axes, walk: Walk, lines: Lines, keep: Kept = slice(None)) -> None:
    """Draw the signals of a panel over time (s), all samples or a part of them."""
    for name, signal, times, values in curves_over_time(walk, lines, keep):
        axes.plot(times, values, label=signal.label, **look(name))


def draw_over_time(axes: Axes, walk: Walk, letter: str, lines: Lines, title: str = "") -> None:
    """Draw a panel of signals over time; its usual title names signals that have no values."""
    time, few, panel = walk.samples["time"], walk.steps <= _MOST_TICKED, lines.panel
    axes.set(xlim=(float(time[0]), max(float(time[-1]), float(time[0]) + 1e-3)))
    for moment in walk.touchdowns["time"] if few else ():
        axes.axvline(moment, color=GUIDE, linewidth=0.4, alpha=0.6, zorder=0)
    draw_signals(axes, walk, lines)
    if panel.events and few:
        axes.plot(lines.events, np.zeros_like(lines.events), "k|", markersize=5, label=panel.events[0])
    widen(axes, panel.least)
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        zero_line(axes)
    axes.set(ylabel=f"{panel.quantity} ({panel.unit})")
    usual = f"{panel.title} (no {', '.join(lines.missing)})" if lines.missing else panel.title
    titled(axes, letter, title or usual)
    if len(axes.get_legend_handles_labels()[0]) > 1:
        legend_above(axes)


def paths_from_above(walk: Walk, keep: Kept = slice(None)) -> tuple[Values, Values, Values]:
    """Paths x, y of a robot in space: of its swing foot, with gaps between steps, of its hip, and its stance feet."""
    robot, qpos, stance = walk.robot, walk.samples["qpos"][keep], walk.samples["stance"][keep]
    assert isinstance(robot, InSpace)
    feet, steps = robot.points(qpos)[:, :, -1, :2], np.flatnonzero(np.diff(stance)) + 1
    swing = np.insert(feet[np.arange(len(stance)), 1 - stance], steps, np.nan, axis=0)
    begun = np.append(0, steps)
    hip = qpos[:, [robot.places.index(name) for name in ("hip_x", "hip_y")]]
    return swing, hip, feet[begun, stance[begun]]


def draw_paths(axes: Axes, walk: Walk) -> None:
    """Draw the paths of the hip and of the swing foot of a robot in space over the ground, and where it stood."""
    swing, hip, stood = paths_from_above(walk)
    axes.plot(*swing.T, color=ORANGE, linewidth=1.0, label="swing foot")
    axes.plot(*hip.T, color=SHADE, linewidth=1.2, label="middle of the hip")
    axes.plot(*stood.T, "o", color=BLUE, markersize=4, markeredgewidth=0, label="stance foot", zorder=4)
    axes.set_ylabel("y (m)")
    axes.margins(y=0.12)


class Portrait(NamedTuple):
    """Rate over angle of a segment, for a figure or a page.

    Attributes:
        angle: Signal of the angle.
        rate: Signal of the rate.
        motion: Angle (rad) and rate (rad/s) at the samples, shape (n, 2); rows of NaN stand between steps.
        planned: The re-planned references, each of shape (points, 2).
        gait: The gait that the controller imitated, shape (points, 2), or none.
    """

    angle: Signal
    rate: Signal
    motion: Values
    planned: list[Values]
    gait: Values | None


def portraits(walk: Walk, keep: Kept = slice(None)) -> Iterator[Portrait]:
    """Make the phase portrait of each angle of a walk.

    Args:
        walk: A record with samples.
        keep: Samples that are drawn.
    """
    samples, angles = walk.samples, walk.robot.angles
    q, dq = samples["q"].copy(), samples["dq"]
    # a sample at a touchdown's own instant has the rates after the impact, but still the old roles
    nearest = np.searchsorted(samples["time"], walk.touchdowns["time"] - 1e-9).clip(max=len(q) - 1)
    q[nearest[np.abs(samples["time"][nearest] - walk.touchdowns["time"]) < 1e-9]] = np.nan
    steps = np.flatnonzero(np.diff(samples["stance"][keep])) + 1
    motion = np.insert(np.stack([q[keep], dq[keep]], axis=2), steps, np.nan, axis=0)
    gait, planned, signals = drawn_gait(walk), drawn_transitions(walk), signals_of(type(walk.robot))
    cycle = None if gait is None else np.stack(gait.reference(np.linspace(0.0, gait.period, _POINTS))[:2], axis=2)
    for k, part in enumerate(angles):
        curves = [curve[:, [k, len(angles) + k]] for curve in planned]
        own = None if cycle is None else cycle[:, k]
        yield Portrait(signals[f"q_{part}"], signals[f"dq_{part}"], motion[:, k], curves, own)


def draw_survivals(axes: Axes, survivals: Mapping[str, Survival | None], most: int) -> None:
    """Draw curves with their bands by their labels, up to a greatest number of steps; None keeps a look for nobody."""
    for number, (label, survival) in enumerate(survivals.items()):
        if survival is not None:
            colour, _, line = told_apart(number)
            steps, share, low, high = survival.curve()
            axes.step(steps, share, where="post", color=colour, linestyle=line, label=plain(label))
            axes.fill_between(steps, low, high, step="post", color=colour, alpha=0.15, linewidth=0.0)
    axes.set(xscale="log", xlim=(1.0, max(most, 2)), ylim=(0.0, 1.03), ylabel="share still walking")
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.grid(color=GUIDE, alpha=0.3)
