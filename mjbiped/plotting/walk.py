"""Figures of walks and gaits, without pyplot: nothing global is changed, and no window system is needed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from numpy.typing import NDArray

from mjbiped.analysis.replay import drawn_gait, drawn_transitions
from mjbiped.errors import RenderError
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.plotting.panels import head, labelled, legend_above, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import (
    ANKLE,
    BLUE,
    C_MT,
    ESTIMATE,
    GUIDE,
    HIP,
    KNEE,
    ORANGE,
    PLANNED,
    STANCE,
    STANCE_KNEE,
    SWING,
    TRUTH,
    drawn,
    note_at,
    widen,
)
from mjbiped.plotting.timelapse import draw_row, rows_of
from mjbiped.plotting.width import width
from mjbiped.records import stance_knee
from mjbiped.records.columns import SAMPLES
from mjbiped.records.pressure import centre_of_pressure
from mjbiped.records.record import Walk

_LINES = 3  # at most, of who walked where: a terrain's name may be of any length
_FARTHEST_PRESSURE = 0.5  # leg lengths that are shown on either side of the ankle
_MOST_TICKED = 60  # touchdowns that are marked on time axes


def plot_walk(walk: Walk, path: str | Path | None = None) -> Figure:
    """Draw a walk in the manner of the paper's Fig. 4.

    (a) Time lapse over the ground, in rows where it is long, x and z in one scale; slopes and steps are written under
    the ground. (b) Slope estimate and true slope. (c) Torques. (d) Where the ankle's torque asks for the centre of
    pressure, up to half a leg. (e), (f) Phase portraits of stance and swing leg, with the limit cycle of the gait that
    the controller imitates and the transitions to it that it re-planned. With knees two panels more come before these,
    torque and flexion of the swing knee; and (c) has the torque that holds the stance knee, negative where its stop
    bears it.

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
        margins, histories_height, phases_height = (0.8, 1.15, 2.0) if narrow else (0.45, 1.65, 3.3)
        knees = walk.robot.knees
        panels = 5 if knees else 3
        histories_height *= panels
        heights = [sum(row.height + 0.25 for row in rows) + margins, histories_height, phases_height]
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
        axes = histories.subplots(panels, 1, sharex=True)
        letters = iter("bcdefgh")
        _draw_slopes(axes[0], walk, next(letters))
        torque = walk.samples["torque"]
        drawn_torques = {"ankle": (torque[:, 0], ANKLE), "hip": (torque[:, 1], HIP)}
        if knees:
            drawn_torques["stance knee"] = (stance_knee.torque(walk), STANCE_KNEE)
        _draw_torques(axes[1], walk, next(letters), "Joint torque", drawn_torques)
        _draw_pressure(axes[2], walk, next(letters))
        if knees:
            swing_knee = {"knee": (torque[:, 2], KNEE)}
            _draw_torques(axes[3], walk, next(letters), "Torque of the swing knee", swing_knee)
            _draw_flexion(axes[4], walk, next(letters))
        axes[-1].set_xlabel(_axis_label("time", "time"))
        _draw_phases(phases, walk, next(letters), next(letters))
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


def _axis_label(name: str, column: str) -> str:
    """A quantity with its unit as the record has it."""
    return f"{name} ({SAMPLES[column].unit})"


def _prepare_time_axis(axes: Axes, walk: Walk) -> None:
    """Span the record; mark touchdowns unless they are too many."""
    time = walk.samples["time"]
    axes.set(xlim=(float(time[0]), max(float(time[-1]), float(time[0]) + 1e-3)))
    if walk.steps <= _MOST_TICKED:
        for moment in walk.touchdowns["time"]:
            axes.axvline(moment, color=GUIDE, linewidth=0.4, alpha=0.6, zorder=0)


def _draw_slopes(axes: Axes, walk: Walk, letter: str) -> None:
    """The panel of the slope and its estimate."""
    samples = walk.samples
    estimate = np.degrees(samples["slope_estimate"])
    estimated = bool(np.isfinite(estimate).any())
    _prepare_time_axis(axes, walk)
    if estimated:
        axes.plot(samples["time"], estimate, label="estimate", **ESTIMATE)
    axes.plot(samples["time"], np.degrees(samples["slope"]), label="true, under the stance foot", **TRUTH)
    axes.set(ylabel="slope (°)")
    titled(axes, letter, "Slope estimate" if estimated else "Slope (the controller makes no estimate)")
    axes.margins(y=0.12)
    widen(axes, 1.0)  # rounding is no news
    legend_above(axes)


def _draw_torques(
    axes: Axes, walk: Walk, letter: str, title: str, joints: Mapping[str, tuple[NDArray[np.float64], Any]]
) -> None:
    """A panel of torques of some joints by name, one number a sample, with their looks."""
    _prepare_time_axis(axes, walk)
    for joint, (torque, style) in joints.items():
        axes.plot(walk.samples["time"], torque, label=joint, **style)
    axes.axhline(0.0, color=GUIDE, linewidth=0.5, zorder=0)
    axes.set(ylabel=_axis_label("torque", "torque"))
    titled(axes, letter, title)
    legend_above(axes)


def _draw_pressure(axes: Axes, walk: Walk, letter: str) -> None:
    """The panel of the centre of pressure, as far as half a leg from the ankle."""
    _prepare_time_axis(axes, walk)
    most = _FARTHEST_PRESSURE * walk.robot.leg_length
    axes.plot(walk.samples["time"], 100.0 * np.clip(centre_of_pressure(walk), -most, most), **ANKLE)
    axes.axhline(0.0, color=GUIDE, linewidth=0.5, zorder=0)
    axes.set(ylabel="from the ankle (cm)")
    titled(axes, letter, "Centre of pressure that the ankle's torque asks for, positive forward")


def _draw_flexion(axes: Axes, walk: Walk, letter: str) -> None:
    """The panel of the swing knee's flexion; knee strikes are marked unless they are too many."""
    time, q = walk.samples["time"], walk.samples["q"]
    _prepare_time_axis(axes, walk)
    axes.plot(time, np.degrees(q[:, 2] - q[:, 1]), label="flexion", **KNEE)
    if walk.steps <= _MOST_TICKED:
        strikes = np.append(0.0, walk.touchdowns["time"])[:-1] + walk.touchdowns["knee_strike"]
        axes.plot(strikes, np.zeros_like(strikes), "k|", markersize=5, label="knee strike")
    axes.set(ylabel="flexion (°)")
    titled(axes, letter, "Flexion of the swing knee")
    legend_above(axes)


def _draw_phases(figure: Any, walk: Walk, *letters: str) -> None:
    """Two panels: a line per step, without the jumps between steps, over the re-planned reference if any."""
    samples = walk.samples
    first_of_step = np.flatnonzero(np.diff(samples["stance"])) + 1
    # a sample at a touchdown's own instant has the rates after the impact, but still the old roles
    nearest = np.searchsorted(samples["time"], walk.touchdowns["time"] - 1e-9).clip(max=len(samples["time"]) - 1)
    at_impact = nearest[np.abs(samples["time"][nearest] - walk.touchdowns["time"]) < 1e-9]
    gait, replanned = drawn_gait(walk), drawn_transitions(walk)
    grid = figure.subplots(1, 2)
    entries: dict[str, Any] = {}
    looks = (("stance leg", STANCE), ("swing thigh" if walk.robot.knees else "swing leg", SWING))
    for leg, (axes, letter, (name, style)) in enumerate(zip(grid, letters, looks, strict=True)):
        q = samples["q"][:, leg].copy()
        q[at_impact] = np.nan
        q = np.insert(q, first_of_step, np.nan)
        dq = np.insert(samples["dq"][:, leg], first_of_step, np.nan)
        axes.plot(q, dq, color=style["color"], linewidth=0.8, label=name)
        for number, planned in enumerate(replanned):
            look = {**PLANNED, "label": "re-planned reference" if number == 0 else None}
            axes.plot(planned[:, leg], planned[:, len(walk.robot.angles) + leg], **look)
        if gait is not None:
            reference, rate, _ = gait.reference(np.linspace(0.0, gait.period, 200))
            axes.plot(reference[:, leg], rate[:, leg], label="imitated gait", **TRUTH, linewidth=1.4)
        axes.plot(samples["q"][0, leg], samples["dq"][0, leg], "k.", markersize=6, label="start")
        axes.set(xlabel=_axis_label("angle", "q"), ylabel=_axis_label("rate", "dq"))
        titled(axes, letter, f"Phase portrait, {name}")
        handles, names = axes.get_legend_handles_labels()
        entries |= dict(zip(names, handles, strict=True))
    order = sorted(entries, key=lambda name: name not in dict(looks))
    legend_below(figure, [entries[name] for name in order], order)


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
