"""Figure of a walk, drawn without pyplot: no global state is changed, and no window system is needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from mjbiped.analysis.replay import drawn_gait, drawn_transitions
from mjbiped.plotting.panels import draw_signals, head, labelled, legend_above, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import BLUE, C_MT, GUIDE, ORANGE, PLANNED, TRUTH, drawn, figure_png, widen, zero_line
from mjbiped.plotting.timelapse import Row, draw_row, rows_of
from mjbiped.plotting.width import width
from mjbiped.records.record import Walk
from mjbiped.records.signals import PANELS, Lines, Signal, check_panels, lines_of, signals_of, without_zeros
from mjbiped.robots.robot import Array

_LINES = 3  # greatest number of title lines for the terrain and controller, whose names may have any length
_POINTS = 200  # of an imitated gait
_MOST_TICKED = 60  # greatest number of touchdowns that are marked on time axes


def plot_walk(walk: Walk, path: str | Path | None = None, *, panels: Sequence[str] | None = None) -> Figure:
    """Draw a walk in the manner of the paper's Fig. 4.

    Time lapse over the ground, in rows if it is long, with x and z in one scale; slopes and steps are written under
    the ground. Signals of `mjbiped.records.signals` over time, without those that are zero throughout: slope and its
    estimate, torques, the centre of pressure that the ankle's torque requires, up to half a leg; with knees also torque
    and flexion of the swing knee, and the torque that holds the stance knee, negative where its stop bears it. Phase
    portraits of all angles, with the limit cycle of the gait that the controller imitates and the re-planned
    transitions to it.

    For a journal's column: `with mjbiped.plotting.width.figure_width("single"): plot_walk(walk, "walk.pdf")`. The width
    "slide" makes a figure of 16:9, with time lapse and torques unless other panels are named.

    Args:
        walk: Any record, including a fall in the first step.
        path: File to write as well, `.png`, `.pdf` or `.svg`.
        panels: Names of its panels, of `mjbiped.records.signals.FIGURE`, as ("torque", "phase"); unless given, those
            above.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix, or there is no such panel; nothing has been drawn then.
        RenderError: The record holds no samples, or the file cannot be written.
    """
    rows, letters = rows_of(walk), iter(ascii_lowercase)
    named = check_panels(width().panels if panels is None else panels)
    every = list(lines_of(walk))
    chosen = [PANELS.get(name) for name in named]
    lines = [each for each in every if (each.panel in chosen if named else each.panel.in_figure)]
    lines = without_zeros(lines) if panels is None else lines
    portraits_across = min(len(walk.robot.angles), max(2, width().beside(len(walk.robot.angles))))
    portrait_lines = math.ceil(len(walk.robot.angles) / portraits_across)
    narrow = width().beside(2) == 1  # titles stand over legends, labels take two lines, panels are smaller
    margin, history, portrait = (0.8, 1.15, 2.0) if narrow else (0.45, 1.65, 3.3)
    parts: list[tuple[float, Callable[[FigureBase], None]]] = []  # heights, inches, and what is drawn there
    if "lapse" in named or not named:
        height = sum(row.height + 0.25 for row in rows) + margin
        parts.append((height, lambda part: _draw_lapse(part, walk, rows, next(letters))))
    if lines:
        parts.append((history * len(lines), lambda part: _draw_histories(part, walk, lines, letters)))
    if "phase" in named or not named:
        parts.append((portrait * portrait_lines, lambda part: _draw_phases(part, walk, letters, portraits_across)))
    with drawn(path) as figure:
        heights = [height for height, _ in parts]
        natural = sum(heights) + 0.1 + head(figure, _title(walk))
        figure.set_figheight(width().height or natural)
        places: Any = figure.subfigures(len(parts), 1, squeeze=False, height_ratios=heights)
        for place, (_, draw) in zip(places[:, 0], parts, strict=True):
            draw(place)
    return figure


def _draw_lapse(figure: FigureBase, walk: Walk, rows: list[Row], letter: str) -> None:
    """Draw the time lapse with title and legend."""
    grid = _draw_rows(figure, walk, rows)
    titled(grid[0], letter, "Time lapse")
    labelled(grid[-1], "x (m);  under the ground: step height and slope, positive downhill")
    legs = (BLUE, 1.8, "stance leg"), (ORANGE, 1.2, "swing leg")
    legend_above(grid[0], handles=[Line2D([], [], color=c, linewidth=size, label=leg) for c, size, leg in legs])


def _draw_histories(figure: FigureBase, walk: Walk, every: list[Lines], letters: Iterator[str]) -> None:
    """Draw panels of signals over each other, with one axis of time."""
    grid = figure.subplots(len(every), 1, sharex=True, squeeze=False)[:, 0]
    for axes, lines in zip(grid, every, strict=True):
        draw_over_time(axes, walk, next(letters), lines)
    grid[-1].set_xlabel("time (s)")


def time_lapse_picture(walk: Walk) -> bytes:
    """Draw the time lapse of a walk as a PNG file's bytes, for a notebook.

    Raises:
        RenderError: The record holds no samples.
    """
    rows = rows_of(walk)
    with drawn(None) as figure:
        figure.set_figheight(sum(row.height + 0.25 for row in rows) + 0.25)
        _draw_rows(figure, walk, rows)[-1].set_xlabel("x (m)")
    return figure_png(figure)


def _draw_rows(figure: FigureBase, walk: Walk, rows: list[Row]) -> list[Axes]:
    """Draw the time lapse, a panel for each row."""
    grid = figure.subplots(len(rows), 1, squeeze=False, height_ratios=[row.height for row in rows])
    for row, (axes,) in zip(rows, grid, strict=True):
        draw_row(axes, walk, row)
    return [axes for (axes,) in grid]


def _title(walk: Walk) -> str:
    """Controller, ground and result of a walk."""
    steps = f"{walk.steps} step{'' if walk.steps == 1 else 's'}"
    cost = f"{walk.cost_of_transport:.4f}" if math.isfinite(walk.cost_of_transport) else "none"
    name = walk.settings["controller"]["name"]
    who = f"{name} on {walk.terrain.caption}, {walk.settings['engine']} engine"
    first, *others = zip(walk.peak_torque, walk.robot.joints, strict=True)
    peaks = [f"{first[0]:.2f} ({first[1]})", *(f"{peak:.2f}\u00a0({joint})" for peak, joint in others)]
    what = (
        f"{walk.outcome} after {steps}, {walk.end[0]:.2f}\u00a0s and {walk.distance:.2f}\u00a0m;  {C_MT}\u00a0{cost};  "
        f"peak torque {', '.join(peaks)}\u00a0N\u00a0m"
    )
    return f"{plain(wrapped(who, lines=_LINES))}\n{wrapped(what)}"


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
    motion: Array
    planned: list[Array]
    gait: Array | None


def portraits(walk: Walk, keep: slice | NDArray[np.int64] = slice(None)) -> Iterator[Portrait]:
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


def _draw_phases(figure: FigureBase, walk: Walk, letters: Iterator[str], across: int) -> None:
    """Draw a panel per angle: a line per step, without the jumps between steps, over the re-planned reference."""
    drawn_in = list(portraits(walk))
    grid = figure.subplots(math.ceil(len(drawn_in) / across), across, squeeze=False).ravel()
    for unused in grid[len(drawn_in) :]:
        unused.set_axis_off()
    entries: dict[str, Any] = {}
    for axes, portrait in zip(grid, drawn_in, strict=False):
        angle, (start, *_) = portrait.angle, portrait.motion
        axes.plot(*portrait.motion.T, color=angle.colour, linewidth=0.8, label=angle.name)
        for planned in portrait.planned:
            axes.plot(*planned.T, label="re-planned reference", **PLANNED)
        if portrait.gait is not None:
            axes.plot(*portrait.gait.T, label="imitated gait", **TRUTH, linewidth=1.4)
        axes.plot(*start, "k.", markersize=6, label="start")
        axes.set(xlabel=f"angle {angle.symbol} (rad)", ylabel=f"rate {portrait.rate.symbol} (rad/s)")
        titled(axes, next(letters), f"Phase portrait, {angle.name}")
        handles, names = axes.get_legend_handles_labels()
        entries |= dict(zip(names, handles, strict=True))
    legs = [portrait.angle.name for portrait in drawn_in]
    order = sorted(entries, key=lambda entry: entry not in legs)
    legend_below(figure, [entries[entry] for entry in order], order)
