"""Figures of walks and gaits, without pyplot: nothing global is changed, and no window system is needed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from mjbiped.analysis.replay import drawn_gait, drawn_transitions
from mjbiped.errors import RenderError
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.plotting.panels import head, labelled, legend_above, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import (
    BLUE,
    C_MT,
    GUIDE,
    ORANGE,
    PLANNED,
    STANCE,
    SWING,
    TRUTH,
    drawn,
    look,
    note_at,
    widen,
)
from mjbiped.plotting.timelapse import draw_row, rows_of
from mjbiped.plotting.width import width
from mjbiped.records.record import Walk
from mjbiped.records.signals import PANELS, Signal, knee_strikes, panels_of, signals_of, values_of

_LINES = 3  # at most, of who walked where: a terrain's name may be of any length
_NOT_OVER_TIME = ("angle", "rate", "power")  # panels that phase portraits show, or reports alone
_MOST_TICKED = 60  # touchdowns that are marked on time axes


def plot_walk(walk: Walk, path: str | Path | None = None) -> Figure:
    """Draw a walk in the manner of the paper's Fig. 4.

    (a) Time lapse over the ground, in rows where it is long, x and z in one scale; slopes and steps are written under
    the ground. (b) and so on: the signals of `mjbiped.records.signals` over time: slope and its estimate, torques,
    where the ankle's torque asks for the centre of pressure, up to half a leg; with knees also torque and flexion of
    the swing knee, and the torque that holds the stance knee, negative where its stop bears it. The last panels: phase
    portraits of all angles, with the limit cycle of the gait that the controller imitates and the transitions to it
    that it re-planned.

    For a journal's column: `with mjbiped.plotting.width.figure_width("single"): plot_walk(walk, "walk.pdf")`.

    Args:
        walk: Any record, a fall in the first step included.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: The record holds no samples, or the file cannot be written.
    """
    if not len(walk.samples["time"]):
        raise RenderError("the record holds no samples: there is nothing to draw")
    with drawn(path) as figure:
        rows = rows_of(walk)
        title = _title(walk)
        narrow = width().beside(2) == 1  # titles stand over legends, labels take two lines, panels are smaller
        panels = {panel: signals for panel, signals in panels_of(type(walk.robot)) if panel not in _NOT_OVER_TIME}
        portraits = len(walk.robot.angles)
        across = min(portraits, max(2, width().beside(portraits)))
        margin, history, portrait = (0.8, 1.15, 2.0) if narrow else (0.45, 1.65, 3.3)
        histories_height, phases_height = history * len(panels), portrait * math.ceil(portraits / across)
        heights = [sum(row.height + 0.25 for row in rows) + margin, histories_height, phases_height]
        figure.set_figheight(sum(heights) + 0.1 + head(figure, title))
        parts: Any = figure.subfigures(3, 1, height_ratios=heights)
        lapse, histories, phases = parts
        grid = lapse.subplots(len(rows), 1, squeeze=False, height_ratios=[row.height for row in rows])
        for row, (axes,) in zip(rows, grid, strict=True):
            draw_row(axes, walk, row)
        titled(grid[0, 0], "a", "Time lapse")
        labelled(grid[-1, 0], "x (m);  under the ground: step height and slope, positive downhill")
        legend_above(
            grid[0, 0],
            handles=[
                Line2D([], [], color=BLUE, linewidth=1.8, label="stance leg"),
                Line2D([], [], color=ORANGE, linewidth=1.2, label="swing leg"),
            ],
        )
        letters = iter("bcdefghijklm")
        axes = histories.subplots(len(panels), 1, sharex=True)
        for below, (panel, signals) in zip(axes, panels.items(), strict=True):
            _draw_over_time(below, walk, next(letters), panel, signals)
        axes[-1].set_xlabel("time (s)")
        _draw_phases(phases, walk, letters, across)
    return figure


def plot_gait(gait: PassiveGait, path: str | Path | None = None) -> Figure:
    """Draw a passive gait: the limit cycle of both legs with its impacts, and its Floquet multipliers.

    Args:
        gait: The gait.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: The file cannot be written.
    """
    with drawn(path) as figure:
        across = width().beside(2)
        stable = "stable" if gait.stable else "unstable"
        text = wrapped(
            f"Passive gait on {math.degrees(gait.slope):.3g}°, {stable}: period {gait.period:.4f}\u00a0s, "
            f"step {gait.step_length:.4f}\u00a0m, speed {gait.speed:.4f}\u00a0m/s, energy {gait.energy:.3f}\u00a0J"
        )
        panel = 4.5 if width().inches / across > 3.5 else 3.2
        figure.set_figheight(panel * (2 // across) + 0.1 + head(figure, text))
        if across == 2:
            cycle, circle = figure.subplots(1, 2, width_ratios=(1.45, 1.0))
        else:
            cycle, circle = figure.subplots(2, 1)
        draw_cycle(cycle, gait)
        _draw_multipliers(circle, gait)
    return figure


def _title(walk: Walk) -> str:
    """Who walked where and what came of it."""
    steps = f"{walk.steps} step{'' if walk.steps == 1 else 's'}"
    cost = f"{walk.cost_of_transport:.4f}" if math.isfinite(walk.cost_of_transport) else "none"
    name = walk.settings["controller"]["name"]
    who = f"{name} on {walk.terrain.caption}, {walk.settings['engine']} engine"
    what = (
        f"{walk.outcome} after {steps}, {walk.end[0]:.2f}\u00a0s and {walk.distance:.2f}\u00a0m;  {C_MT}\u00a0{cost};  "
        f"peak torque {_peaks(walk)}\u00a0N\u00a0m"
    )
    return f"{plain(wrapped(who, lines=_LINES))}\n{wrapped(what)}"


def _peaks(walk: Walk) -> str:
    """The greatest torques, by joint."""
    first, *others = zip(walk.peak_torque, walk.robot.joints, strict=True)
    return ", ".join([f"{first[0]:.2f} ({first[1]})", *(f"{peak:.2f}\u00a0({joint})" for peak, joint in others)])


def _prepare_time_axis(axes: Axes, walk: Walk) -> None:
    """Span the record; mark touchdowns unless they are too many."""
    time = walk.samples["time"]
    axes.set(xlim=(float(time[0]), max(float(time[-1]), float(time[0]) + 1e-3)))
    if walk.steps <= _MOST_TICKED:
        for moment in walk.touchdowns["time"]:
            axes.axvline(moment, color=GUIDE, linewidth=0.4, alpha=0.6, zorder=0)


def _draw_over_time(axes: Axes, walk: Walk, letter: str, panel: str, signals: Mapping[str, Signal]) -> None:
    """A panel of signals over time; one without a number, an estimate that nobody makes, is left out and named."""
    _prepare_time_axis(axes, walk)
    title, quantity, unit, _, least, _ = PANELS[panel]
    missing = []
    for name, signal in signals.items():
        values = values_of(walk, name)
        if np.isfinite(values).any():
            axes.plot(walk.samples["time"], values, label=f"{signal.name} {signal.symbol}".strip(), **look(name))
        else:
            missing.append(signal.name)
    if panel == "flexion" and walk.steps <= _MOST_TICKED:
        strikes = knee_strikes(walk)
        axes.plot(strikes, np.zeros_like(strikes), "k|", markersize=5, label="knee strike")
    widen(axes, least)
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        axes.axhline(0.0, color=GUIDE, linewidth=0.5, zorder=0)
    axes.set(ylabel=f"{quantity} ({unit})")
    titled(axes, letter, f"{title} (no {', '.join(missing)})" if missing else title)
    if len(axes.get_legend_handles_labels()[0]) > 1:
        legend_above(axes)


def _draw_phases(figure: Any, walk: Walk, letters: Iterator[str], across: int) -> None:
    """A panel per angle: a line per step, without the jumps between steps, over the re-planned reference if any."""
    samples = walk.samples
    first_of_step = np.flatnonzero(np.diff(samples["stance"])) + 1
    # a sample at a touchdown's own instant has the rates after the impact, but still the old roles
    nearest = np.searchsorted(samples["time"], walk.touchdowns["time"] - 1e-9).clip(max=len(samples["time"]) - 1)
    at_impact = nearest[np.abs(samples["time"][nearest] - walk.touchdowns["time"]) < 1e-9]
    gait, replanned = drawn_gait(walk), drawn_transitions(walk)
    signals, angles = signals_of(type(walk.robot)), walk.robot.angles
    grid = figure.subplots(math.ceil(len(angles) / across), across, squeeze=False).ravel()
    for unused in grid[len(angles) :]:
        unused.set_axis_off()
    legs = [signals[f"q_{part}"].name for part in angles]
    entries: dict[str, Any] = {}
    for k, (axes, part) in enumerate(zip(grid, angles, strict=False)):
        angle, rate = signals[f"q_{part}"], signals[f"dq_{part}"]
        q = samples["q"][:, k].copy()
        q[at_impact] = np.nan
        q = np.insert(q, first_of_step, np.nan)
        dq = np.insert(samples["dq"][:, k], first_of_step, np.nan)
        axes.plot(q, dq, color=angle.colour, linewidth=0.8, label=angle.name)
        for number, planned in enumerate(replanned):
            band = {**PLANNED, "label": "re-planned reference" if number == 0 else None}
            axes.plot(planned[:, k], planned[:, len(angles) + k], **band)
        if gait is not None:
            reference, speed, _ = gait.reference(np.linspace(0.0, gait.period, 200))
            axes.plot(reference[:, k], speed[:, k], label="imitated gait", **TRUTH, linewidth=1.4)
        axes.plot(samples["q"][0, k], samples["dq"][0, k], "k.", markersize=6, label="start")
        axes.set(xlabel=f"angle {angle.symbol} (rad)", ylabel=f"rate {rate.symbol} (rad/s)")
        titled(axes, next(letters), f"Phase portrait, {angle.name}")
        handles, names = axes.get_legend_handles_labels()
        entries |= dict(zip(names, handles, strict=True))
    order = sorted(entries, key=lambda entry: entry not in legs)
    legend_below(figure, [entries[entry] for entry in order], order)


def draw_cycle(axes: Axes, gait: Gait) -> None:
    """Both legs' phase portrait; a leg goes round it in two steps."""
    q, dq, _ = gait.reference(np.linspace(0.0, gait.period, 300))
    for leg, (name, style) in enumerate((("stance leg", STANCE), ("swing leg", SWING))):
        axes.plot(q[:, leg], dq[:, leg], label=name, linewidth=1.6, **style)
        middle = len(q) // 4
        axes.annotate(
            "",
            (q[middle + 2, leg], dq[middle + 2, leg]),
            (q[middle, leg], dq[middle, leg]),
            arrowprops={"arrowstyle": "-|>", "color": style["color"], "mutation_scale": 16},
        )
    for before, after, what in ((0, 1, "lift-off"), (1, 0, "touchdown")):
        ends = (gait.end[before], gait.start[after]), (gait.end[2 + before], gait.start[2 + after])
        axes.plot(*ends, color=GUIDE, linestyle=":", marker="o", markersize=3.5, zorder=1)
        q_between, dq_between = (sum(pair) / 2 for pair in ends)
        note_at(axes, f"impact\n({what})", q_between, dq_between, (6, 0), xycoords="data", ha="left", va="center")
    axes.set(xlabel="angle from the ground's normal (rad)", ylabel="rate (rad/s)")
    titled(axes, "a", "Limit cycle of each leg")
    low, high = axes.get_xlim()
    axes.set_xlim(low, high + 0.15 * (high - low))  # room for the words
    axes.legend(loc="center", bbox_to_anchor=(0.5, 0.25))


def _draw_multipliers(axes: Axes, gait: PassiveGait) -> None:
    """The multipliers in the complex plane, and in figures."""
    reach = 1.25 * max(1.0, float(np.abs(gait.multipliers).max()))
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=GUIDE, linestyle="--"))
    axes.axhline(0.0, color=GUIDE, linewidth=0.5)
    axes.axvline(0.0, color=GUIDE, linewidth=0.5)
    axes.plot(gait.multipliers.real, gait.multipliers.imag, "o", color=BLUE, markersize=7)
    axes.set(xlim=(-reach, reach), ylim=(-reach, 1.25 * reach), xlabel="real part", ylabel="imaginary part")
    axes.set_aspect("equal")
    titled(axes, "b", "Floquet multipliers and the unit circle")
    message = "\n".join(f"λ{k} = {_complex(value)}" for k, value in enumerate(gait.multipliers, start=1))
    axes.text(
        0.02,
        0.98,
        f"{message}\n|λ| ≤ {abs(gait.multipliers[0]):.5f}",
        transform=axes.transAxes,
        va="top",
        fontsize=width().small,
    )


def _complex(value: complex) -> str:
    """A number of five digits, its imaginary part only where there is one."""
    real = f"{value.real:+.5f}"
    return (real if value.imag == 0.0 else f"{real} {'+' if value.imag > 0 else '-'} {abs(value.imag):.5f} i").replace(
        "-", "−"
    )
