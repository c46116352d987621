"""Figure of a comparison: the curves of both engines over each other, and their difference below."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjbiped.analysis.compare import Comparison, torque_differences
from mjbiped.errors import RenderError
from mjbiped.plotting.panels import head, labelled, legend_above, plain, titled, wrapped
from mjbiped.plotting.style import HYBRID, MUJOCO, SHADE, TRUTH, drawn, look, note_at, widen, zero_line
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Array

_LOOKS: tuple[dict[str, Any], ...] = (
    {**MUJOCO, "linewidth": 2.4, "label": "MuJoCo"},
    {**HYBRID, "linewidth": 1.1, "label": "hybrid"},
)
_BURST = 3.0  # an axis is cut where the last, unfinished step would make it longer by this factor
_LENGTH_SPAN = 0.01  # least span, as a share of the longest step; the differences have their own panel
_SLOPE_SPAN = 1.0  # least span, deg; smaller differences are rounding
_TOGETHER = 0.1  # ends closer than this share of the time axis share a label


def plot_comparison(comparison: Comparison, path: str | Path | None = None) -> Figure:
    """Draw a comparison of both engines.

    (a) Ankle and hip torque over time, and their differences at equal times since the touchdown; axes are cut, and a
    note says so, where the last, unfinished step needs far more than all before. (b) Step lengths and (c) the slope
    estimate with the true slope, over the distance, each with its difference; for a controller without an estimate the
    slope alone. Lines mark where the walks part, and where a walk ends before its time.

    Args:
        comparison: Result of `mjbiped.compare`, including a fall in the first step.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: A record holds no samples, or the file cannot be written.
    """
    walks = comparison.mujoco, comparison.hybrid
    if not all(len(walk.samples["time"]) for walk in walks):
        raise RenderError("a record holds no samples: there is nothing to draw")
    with drawn(path) as figure:
        name = comparison.mujoco.settings["controller"]["name"]
        lines = [f"{name} on {comparison.mujoco.terrain.caption}, in both engines", comparison.verdict]
        title = "\n".join(plain(wrapped(line)) for line in lines)
        estimated = any(np.isfinite(walk.touchdowns["slope_estimate"]).any() for walk in walks)
        figure.set_figheight((10.0 if estimated else 8.8) + head(figure, title))
        parts: Any = figure.subfigures(2, 1, height_ratios=(5.0, 5.2 if estimated else 4.0))
        joints = len(comparison.mujoco.robot.joints)
        torques = parts[0].subplots(joints + 1, 1, sharex=True, height_ratios=(*[1.5] * joints, 1.0))
        ratios = (1.5, 1.0, 1.5, 1.0) if estimated else (1.5, 1.0, 1.5)
        grounds = parts[1].subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
        _draw_torques(torques, comparison, walks)
        _draw_step_lengths(grounds[0], walks)
        _draw_slopes(grounds[2], walks, estimated)
        n = len(comparison.touchdowns["x"])
        one, other = (measures.step_lengths(walk)[:n] for walk in walks)
        differences = (1e3 * (one - other), "mm"), (np.degrees(comparison.touchdowns["slope_estimate"]), "°")
        for axes, (difference, unit) in zip(grounds[1::2], differences, strict=False):
            axes.plot(comparison.mujoco.touchdowns["x"][:n], difference, "k.-", linewidth=0.8, markersize=4.0)
            axes.set(ylabel=f"Δ ({unit})")
            zero_line(axes)
        labelled(grounds[-1], "x of the touchdown (m);  Δ = MuJoCo − hybrid")
        _mark_parting(torques, grounds, comparison, walks)
        _mark_ends(torques, walks)
        for part in parts:
            part.align_ylabels()
    return figure


def _draw_torques(grid: Any, comparison: Comparison, walks: Sequence[Walk]) -> None:
    """Draw each joint's torque in both engines, and below them the differences of all joints."""
    time, difference = torque_differences(comparison)
    ends = [_end_of_steps(walk) for walk in walks]
    cut, under = [], grid[-1]
    for joint, (axes, name) in enumerate(zip(grid, comparison.mujoco.robot.joints, strict=False)):
        torques = [walk.samples["torque"][:, joint] for walk in walks]
        for walk, torque, engine in zip(walks, torques, _LOOKS, strict=True):
            axes.plot(walk.samples["time"], torque, **engine)
        steady = [t[walk.samples["time"] <= end] for t, walk, end in zip(torques, walks, ends, strict=True)]
        axes.set(ylabel=f"{name} (N m)")
        if _cut_burst(axes, np.concatenate(torques), np.concatenate(steady), room=0.25):
            cut.append(f"{name} to {max(float(walk.peak_torque[joint]) for walk in walks):.3g}")
        under.plot(time, difference[:, joint], label=name, linewidth=0.9, **look(f"torque_{name}"))
    titled(grid[0], "a", "Joint torque")
    legend_above(grid[0])
    under.set(ylabel="Δ (N m)")
    labelled(under, "time (s);  Δ = MuJoCo − hybrid at equal times since the touchdown")
    if _cut_burst(under, difference, difference[time <= min(ends)], room=2.0):
        cut.append(f"Δ to {np.nanmax(np.abs(difference)):.3g}")
    if cut:
        text = f"cut off in the last, unfinished step: {', '.join(cut)} N m"
        grid[0].set_title(text, loc="center", fontsize=8, fontweight="normal", color=SHADE)
    zero_line(under)
    legend_above(under)
    early = any(walk.outcome != "finished" for walk in walks)
    under.set_xlim(0.0, max((1.01 if early else 1.0) * max(float(walk.end[0]) for walk in walks), 1e-3))


def _end_of_steps(walk: Walk) -> float:
    """Time at which the last finished step ended, s."""
    if walk.outcome == "finished":
        return float(walk.end[0])
    return float(walk.touchdowns["time"][-1]) if walk.steps else -math.inf


def _cut_burst(axes: Axes, values: Array, steady: Array, *, room: float) -> bool:
    """Cut the axis where the values outside finished steps would hide those within.

    Args:
        axes: Panel of the values.
        values: All values.
        steady: Values in finished steps.
        room: Margin above and below the values in finished steps, as a share of their span.

    Returns:
        Whether the axis was cut.
    """
    values, steady = values[np.isfinite(values)], steady[np.isfinite(steady)]
    span = float(np.ptp(steady)) if len(steady) else 0.0
    if span == 0.0 or float(np.ptp(values)) < _BURST * span:
        return False
    axes.set_ylim(float(steady.min()) - room * span, float(steady.max()) + room * span)
    return True


def _draw_step_lengths(axes: Axes, walks: Sequence[Walk]) -> None:
    longest = 0.0
    for walk, engine in zip(walks, _LOOKS, strict=True):
        lengths = measures.step_lengths(walk)
        axes.plot(walk.touchdowns["x"], lengths, marker="o", markersize=3.0, **engine)
        longest = max(longest, float(lengths.max(initial=0.0)))
    axes.set(ylabel="length (m)")
    titled(axes, "b", "Step length")
    widen(axes, _LENGTH_SPAN * longest)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    legend_above(axes)


def _draw_slopes(axes: Axes, walks: Sequence[Walk], estimated: bool) -> None:
    """Draw the slope of the ground, and the estimates, each of which holds from its touchdown to the next."""
    reached = max(0.4, *(float(walk.touchdowns["x"].max(initial=0.0)) for walk in walks))
    for walk, engine in zip(walks, _LOOKS if estimated else (), strict=estimated):
        estimate = np.degrees(walk.touchdowns["slope_estimate"])
        axes.step(walk.touchdowns["x"], estimate, where="post", marker="o", markersize=3.0, **engine)
    places = np.linspace(0.0, reached, 2001)
    axes.plot(places, np.degrees(walks[0].terrain.slope(places)), label="ground", zorder=1, linewidth=1.0, **TRUTH)
    axes.set(ylabel="slope (°)", xlim=(0.0, 1.02 * reached))
    words = "Slope estimate at touchdown, and slope of the ground"
    titled(axes, "c", words if estimated else "Slope of the ground (the controller makes no estimate)")
    widen(axes, _SLOPE_SPAN)
    legend_above(axes)


def _mark_parting(torques: Any, grounds: Any, comparison: Comparison, walks: Sequence[Walk]) -> None:
    """Draw a line where the walks part."""
    divergence = comparison.divergence
    if divergence is None:
        return
    beyond = [walk.touchdowns["x"][divergence.touchdown - 1 :] for walk in walks]
    x = next((float(places[0]) for places in beyond if len(places)), divergence.x)
    for panels, place in ((torques, divergence.time), (grounds, x)):
        for axes in panels:
            axes.axvline(place, color=SHADE, linewidth=0.9, linestyle="-.", zorder=0)
    note_at(torques[0], "they part", divergence.time, 1.0, (3, -2), color=SHADE, va="top")


def _mark_ends(torques: Any, walks: Sequence[Walk]) -> None:
    """Draw lines where walks end before their time, and name the outcome above the second panel."""
    early = [(float(walk.end[0]), engine["label"], walk.outcome) for walk, engine in zip(walks, _LOOKS, strict=True)]
    early = [end for end in early if end[2] != "finished"]
    for time, *_ in early:
        for axes in torques:
            axes.axvline(time, color=SHADE, linewidth=0.9, zorder=0)
    last, names = torques[0].get_xlim()[1], [(time, f"{engine} {outcome}") for time, engine, outcome in early]
    if len(early) == 2 and abs(early[0][0] - early[1][0]) < _TOGETHER * last:
        same = early[0][2] == early[1][2]
        names = [(max(names)[0], f"both {early[0][2]}" if same else ", ".join(name for _, name in names))]
    for time, name in names:
        shift, side = (-3, "left") if time < _TOGETHER * last else (3, "right")
        note_at(torques[1], name, time, 1.0, (shift, 2), ha=side, va="bottom", color=SHADE)
