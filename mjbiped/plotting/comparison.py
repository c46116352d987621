"""Figure of a comparison: the curves of both engines over each other, and their difference below."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjbiped.analysis.compare import Comparison, torque_differences
from mjbiped.errors import RenderError
from mjbiped.plotting.panels import head, labelled, legend_above, plain, titled, wrapped
from mjbiped.plotting.style import ANKLE, HIP, HYBRID, MUJOCO, SHADE, TRUTH, drawn, note_at, widen, zero_line
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
    walks = _walks(comparison)
    if not all(len(walk.samples["time"]) for walk in walks):
        raise RenderError("a record holds no samples: there is nothing to draw")
    with drawn(path) as figure:
        name = comparison.mujoco.settings["controller"]["name"]
        lines = [f"{name} on {comparison.mujoco.terrain.caption}, in both engines", comparison.verdict]
        title = "\n".join(plain(wrapped(line)) for line in lines)
        estimated = any(np.isfinite(walk.touchdowns["slope_estimate"]).any() for walk in walks)
        figure.set_figheight((10.0 if estimated else 8.8) + head(figure, title))
        parts: Any = figure.subfigures(2, 1, height_ratios=(5.0, 5.2 if estimated else 4.0))
        torques = parts[0].subplots(3, 1, sharex=True, height_ratios=(1.5, 1.5, 1.0))
        _draw_torques(torques, comparison)
        ratios = (1.5, 1.0, 1.5, 1.0) if estimated else (1.5, 1.0, 1.5)
        grounds = parts[1].subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
        _draw_step_lengths(grounds[0], grounds[1], comparison)
        _draw_slopes(grounds[2], comparison, estimated)
        if estimated:
            _draw_difference(grounds[3], comparison, np.degrees(comparison.touchdowns["slope_estimate"]), "°")
        labelled(grounds[-1], "x of the touchdown (m);  Δ = MuJoCo − hybrid")
        _mark_parting(torques, grounds, comparison)
        _mark_ends(torques, comparison)
        for part in parts:
            part.align_ylabels()
    return figure


def _walks(comparison: Comparison) -> tuple[Walk, Walk]:
    """Both walks, in the order of `_LOOKS`."""
    return comparison.mujoco, comparison.hybrid


def _draw_torques(grid: Any, comparison: Comparison) -> None:
    walks = _walks(comparison)
    time, difference = torque_differences(comparison)
    steady_ends = [_end_of_steps(walk) for walk in walks]
    cut = []
    for joint, (axes, name, line) in enumerate(zip(grid[:2], ("ankle", "hip"), (ANKLE, HIP), strict=True)):
        torques, steady = [], []
        for walk, look, end in zip(walks, _LOOKS, steady_ends, strict=True):
            axes.plot(walk.samples["time"], walk.samples["torque"][:, joint], **look)
            torques.append(walk.samples["torque"][:, joint])
            steady.append(torques[-1][walk.samples["time"] <= end])
        axes.set(ylabel=f"{name} (N m)")
        if _cut_burst(axes, np.concatenate(torques), np.concatenate(steady), room=0.25):
            cut.append(f"{name} to {max(float(walk.peak_torque[joint]) for walk in walks):.3g}")
        grid[2].plot(time, difference[:, joint], label=name, linewidth=0.9, **line)
    titled(grid[0], "a", "Joint torque")
    legend_above(grid[0])
    grid[2].set(ylabel="Δ (N m)")
    labelled(grid[2], "time (s);  Δ = MuJoCo − hybrid at equal times since the touchdown")
    if _cut_burst(grid[2], difference, difference[time <= min(steady_ends)], room=2.0):
        cut.append(f"Δ to {np.nanmax(np.abs(difference)):.3g}")
    if cut:
        text = f"cut off in the last, unfinished step: {', '.join(cut)} N m"
        grid[0].set_title(text, loc="center", fontsize=8, fontweight="normal", color=SHADE)
    zero_line(grid[2])
    legend_above(grid[2])
    last = max(float(walk.end[0]) for walk in walks)
    early = any(walk.outcome != "finished" for walk in walks)
    grid[2].set_xlim(0.0, max((1.01 if early else 1.0) * last, 1e-3))


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


def _draw_step_lengths(axes: Axes, under: Axes, comparison: Comparison) -> None:
    lengths = [measures.step_lengths(walk) for walk in _walks(comparison)]
    for own, walk, look in zip(lengths, _walks(comparison), _LOOKS, strict=True):
        axes.plot(walk.touchdowns["x"], own, marker="o", markersize=3.0, **look)
    axes.set(ylabel="length (m)")
    titled(axes, "b", "Step length")
    widen(axes, _LENGTH_SPAN * float(np.concatenate(lengths).max(initial=0.0)))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    legend_above(axes)
    n = len(comparison.touchdowns["x"])
    _draw_difference(under, comparison, 1e3 * (lengths[0][:n] - lengths[1][:n]), "mm")


def _draw_slopes(axes: Axes, comparison: Comparison, estimated: bool) -> None:
    reached = 0.4
    for walk, look in zip(_walks(comparison), _LOOKS, strict=True):
        x, estimate = walk.touchdowns["x"], np.degrees(walk.touchdowns["slope_estimate"])
        reached = max(reached, float(x.max(initial=0.0)))
        if estimated:
            axes.plot(x, estimate, marker="o", markersize=3.0, **look)
    places = np.linspace(0.0, reached, 2001)
    slopes = np.degrees(comparison.mujoco.terrain.slope(places))
    axes.plot(places, slopes, label="ground", zorder=1, linewidth=1.0, **TRUTH)
    axes.set(ylabel="slope (°)")
    words = "Slope estimate at touchdown, and slope of the ground"
    titled(axes, "c", words if estimated else "Slope of the ground (the controller makes no estimate)")
    widen(axes, _SLOPE_SPAN)
    legend_above(axes)
    axes.set_xlim(0.0, 1.02 * reached)


def _draw_difference(axes: Axes, comparison: Comparison, difference: Any, unit: str) -> None:
    """Draw a row of differences at the touchdowns."""
    n = len(difference)
    axes.plot(comparison.mujoco.touchdowns["x"][:n], difference, "k.-", linewidth=0.8, markersize=4.0)
    axes.set(ylabel=f"Δ ({unit})")
    zero_line(axes)


def _mark_parting(torques: Any, grounds: Any, comparison: Comparison) -> None:
    """Draw a line where the walks part."""
    divergence = comparison.divergence
    if divergence is None:
        return
    beyond = [walk.touchdowns["x"][divergence.touchdown - 1 :] for walk in _walks(comparison)]
    x = next((float(places[0]) for places in beyond if len(places)), divergence.x)
    for panels, place in ((torques, divergence.time), (grounds, x)):
        for axes in panels:
            axes.axvline(place, color=SHADE, linewidth=0.9, linestyle="-.", zorder=0)
    note_at(torques[0], "they part", divergence.time, 1.0, (3, -2), color=SHADE, va="top")


def _mark_ends(torques: Any, comparison: Comparison) -> None:
    """Draw lines where walks end before their time, and name the outcome above the second panel."""
    ends = [
        (float(walk.end[0]), style["label"], walk.outcome)
        for walk, style in zip(_walks(comparison), _LOOKS, strict=True)
        if walk.outcome != "finished"
    ]
    for time, *_ in ends:
        for axes in torques:
            axes.axvline(time, color=SHADE, linewidth=0.9, zorder=0)
    last = torques[0].get_xlim()[1]
    if len(ends) == 2 and abs(ends[0][0] - ends[1][0]) < _TOGETHER * last:
        (_, one, how), (_, other, other_how) = ends
        names = ("both", how) if how == other_how else (f"{one} {how},", f"{other} {other_how}")
        ends = [(max(ends)[0], *names)]
    for time, name, outcome in ends:
        shift, side = (-3, "left") if time < _TOGETHER * last else (3, "right")
        note_at(torques[1], f"{name} {outcome}", time, 1.0, (shift, 2), ha=side, va="bottom", color=SHADE)
