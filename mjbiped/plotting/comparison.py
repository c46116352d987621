"""Figures of comparisons: a walk in both engines, walks by Theorem 1, and robots by the survival of their walks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjbiped.analysis.compare import Comparison, torque_differences
from mjbiped.analysis.stability import RESOLVED, Stability
from mjbiped.analysis.survival import Survival
from mjbiped.errors import InputError, RenderError
from mjbiped.plotting import style, width
from mjbiped.plotting.panels import draw_survivals, head, labelled, legend_above, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import SHADE, TRUTH, drawn, look, note_at, widen, zero_line
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.records.signals import Values

_LOOKS: tuple[dict[str, Any], ...] = (
    {**style.MUJOCO, "linewidth": 2.4, "label": "MuJoCo"},
    {**style.HYBRID, "linewidth": 1.1, "label": "hybrid"},
)
_BURST = 3.0  # an axis is cut where the last, unfinished step would make it longer by this factor
_LENGTH_SPAN = 0.01  # least span, as a share of the longest step; the differences have their own panel
_SLOPE_SPAN = 1.0  # least span, deg; smaller differences are rounding
_TOGETHER = 0.1  # ends closer than this share of the time axis share a label
_MOST = 4  # walks in a figure of Theorem 1
_MOST_NAMED = 40  # greatest number of steps with labelled changes of slope


def plot_comparison(comparison: Comparison, path: str | Path | None = None) -> Figure:
    """Draw a comparison of both engines, without panels in which nothing happens, such as torques of passive walks.

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
    driven = any(walk.samples["torque"].any() for walk in walks)
    stepped = any(walk.steps for walk in walks)
    estimated = any(np.isfinite(walk.touchdowns["slope_estimate"]).any() for walk in walks)
    ratios = [1.5, 1.0] * stepped + [1.5] + [1.0] * estimated
    heights = [4.9] * driven + [0.7 + 0.88 * sum(ratios)]
    name, letters = comparison.mujoco.settings["controller"]["name"], iter("abc")
    lines = [f"{name} on {comparison.mujoco.terrain.caption}, in both engines", comparison.verdict]
    with drawn(path) as figure:
        figure.set_figheight(sum(heights) + head(figure, "\n".join(plain(wrapped(line)) for line in lines)))
        parts: list[Any] = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0].tolist()
        if driven:
            joints = len(comparison.mujoco.robot.joints)
            over_time = parts[0].subplots(joints + 1, 1, sharex=True, height_ratios=(*[1.5] * joints, 1.0))
            _draw_torques(over_time, comparison, walks, next(letters))
            _mark(over_time, comparison, walks, 0, named=True)
        over_ground = parts[-1].subplots(len(ratios), 1, sharex=True, squeeze=False, height_ratios=ratios)[:, 0]
        differences = []
        if stepped:
            _draw_step_lengths(over_ground[0], walks, next(letters))
            one, other = (measures.step_lengths(walk)[: len(comparison.touchdowns["x"])] for walk in walks)
            differences.append((over_ground[1], 1e3 * (one - other), "mm"))
        _draw_slopes(over_ground[2 * stepped], walks, next(letters), estimated)
        if estimated:
            differences.append((over_ground[-1], np.degrees(comparison.touchdowns["slope_estimate"]), "°"))
        for axes, difference, unit in differences:
            x = comparison.mujoco.touchdowns["x"][: len(difference)]
            axes.plot(x, difference, "k.-", linewidth=0.8, markersize=4.0)
            axes.set(ylabel=f"Δ ({unit})")
            zero_line(axes)
        labelled(over_ground[-1], "x of the touchdown (m);  Δ = MuJoCo − hybrid" if differences else "x (m)")
        _mark(over_ground, comparison, walks, 1, named=not driven)
        for part in parts:
            part.align_ylabels()
    return figure


def _draw_torques(grid: Sequence[Axes], comparison: Comparison, walks: Sequence[Walk], letter: str) -> None:
    """Draw each joint's torque in both engines, and below them the differences of all joints."""
    time, difference = torque_differences(comparison)
    touchdowns = [float(walk.touchdowns["time"].max(initial=-math.inf)) for walk in walks]
    ends = [walk.end[0] if walk.outcome == "finished" else last for walk, last in zip(walks, touchdowns, strict=True)]
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
    titled(grid[0], letter, "Joint torque")
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
    under.set_xlim(0.0, max((1.01 if early else 1.0) * max(walk.end[0] for walk in walks), 1e-3))


def _cut_burst(axes: Axes, values: Values, steady: Values, *, room: float) -> bool:
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


def _draw_step_lengths(axes: Axes, walks: Sequence[Walk], letter: str) -> None:
    for walk, engine in zip(walks, _LOOKS, strict=True):
        axes.plot(walk.touchdowns["x"], measures.step_lengths(walk), marker="o", markersize=3.0, **engine)
    axes.set(ylabel="length (m)")
    titled(axes, letter, "Step length")
    widen(axes, _LENGTH_SPAN * max(float(measures.step_lengths(walk).max(initial=0.0)) for walk in walks))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    legend_above(axes)


def _draw_slopes(axes: Axes, walks: Sequence[Walk], letter: str, estimated: bool) -> None:
    """Draw the slope of the ground, and the estimates, each of which holds from its touchdown to the next."""
    reached = max(0.4, *(float(walk.touchdowns["x"].max(initial=walk.end[1])) for walk in walks))
    for walk, engine in zip(walks, _LOOKS if estimated else (), strict=estimated):
        estimate = np.degrees(walk.touchdowns["slope_estimate"])
        axes.step(walk.touchdowns["x"], estimate, where="post", marker="o", markersize=3.0, **engine)
    places = np.linspace(0.0, reached, 2001)
    axes.plot(places, np.degrees(walks[0].terrain.slope(places)), label="ground", zorder=1, linewidth=1.0, **TRUTH)
    axes.set(ylabel="slope (°)", xlim=(0.0, 1.02 * reached))
    words = "Slope estimate at touchdown, and slope of the ground"
    titled(axes, letter, words if estimated else "Slope of the ground (no estimate)")
    widen(axes, _SLOPE_SPAN)
    legend_above(axes)


def _mark(grid: Sequence[Axes], comparison: Comparison, walks: Sequence[Walk], axis: int, *, named: bool) -> None:
    """Draw lines where the walks part, and where one ends before its time.

    Args:
        grid: Panels over each other.
        comparison: The comparison.
        walks: Its walks.
        axis: Horizontal axis of the panels: 0 time (s), 1 place (m).
        named: Whether a note says what the lines mean; the outcomes stand above the second panel,
            or in the only one.
    """
    divergence = comparison.divergence
    if divergence is not None:
        beyond = [walk.touchdowns["x"][divergence.touchdown - 1 :] for walk in walks]
        x = next((float(places[0]) for places in beyond if len(places)), divergence.x)
        for axes in grid:
            axes.axvline((divergence.time, x)[axis], color=SHADE, linewidth=0.9, linestyle="-.", zorder=0)
        if named:
            note_at(grid[0], "they part", (divergence.time, x)[axis], 1.0, (3, -2), color=SHADE, va="top")
    early = [
        (max(0.0, walk.end[axis]), engine["label"], walk.outcome) for walk, engine in zip(walks, _LOOKS, strict=True)
    ]
    early = [end for end in early if end[2] != "finished"]
    for place, *_ in early:
        for axes in grid:
            axes.axvline(place, color=SHADE, linewidth=0.9, zorder=0)
    last, names = grid[0].get_xlim()[1], [(place, f"{engine} {outcome}") for place, engine, outcome in early]
    if len(early) == 2 and abs(early[0][0] - early[1][0]) < _TOGETHER * last:
        same = early[0][2] == early[1][2]
        names = [(max(names)[0], f"both {early[0][2]}" if same else ", ".join(name for _, name in names))]
    rise, above = (2, "bottom") if len(grid) > 1 else (-2, "top")  # a single panel has its title there
    for place, name in names if named else ():
        shift, side = (3, "left") if place < _TOGETHER * last else (-3, "right")
        note_at(grid[:2][-1], name, place, 1.0, (shift, rise), ha=side, va=above, color=SHADE)


def plot_stability(walks: Mapping[str, Stability], path: str | Path | None = None) -> Figure:
    """Draw Theorem 1 along up to four walks over the same ground.

    (a) V_a (15) over time. (b) Norm of eta before each touchdown. (c) Eigenvalues of each step's Gramian.
    (d) Left side of (24), which must be below 1, the left side for the best possible constants, and the actual ratio of
    the norms of eta.

    Args:
        walks: Walks by their names in the legend.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: There is no walk or more than four, or the path has another suffix.
        RenderError: The file cannot be written.
    """
    if not 1 <= len(walks) <= _MOST:
        raise InputError(f"a figure shows one to {_MOST} walks, got {len(walks)}")
    with drawn(path) as figure:
        across = width().beside(2)
        figure.set_figheight(0.6 + 3.0 * (4 // across))
        over_time, errors, excitation, condition = figure.subplots(4 // across, across).flat
        for number, (name, found) in enumerate(walks.items()):
            color, marker, line = style.LOOKS[1 + number]
            steps, first = np.arange(1, found.steps + 1), number == 0
            look = {"color": color, "marker": marker, "markersize": 3.5, "linewidth": 0.9, "linestyle": line}
            over_time.plot(found.time, _positive(found.lyapunov, RESOLVED**2), color=color, linestyle=line)
            errors.plot(steps, _positive(np.linalg.norm(found.end, axis=1), RESOLVED), label=name, **look)
            excitation.plot(steps, found.excitation, **look)
            condition.plot(steps, _positive(found.condition), label="left side of (24)" if first else None, **look)
            hollow = {**look, "linestyle": "none", "markerfacecolor": "white"}
            apart = "‖η‖ over its value a step before, (26)" if first else None
            condition.plot(steps, _positive(found.ratio), label=apart, **hollow)
        first_walk = next(iter(walks.values()))
        floor = "left side of (24), best possible constants"
        steps = np.arange(1, first_walk.steps + 1)
        condition.plot(steps, first_walk.condition_floor, color=style.BLACK, linewidth=0.9, label=floor)
        over_time.set(yscale="log", xlabel="time (s)", ylabel="$V_a$")
        errors.set(yscale="log", ylabel="‖η‖ (rad, rad/s, 1)")
        excitation.set(ylabel="eigenvalue of ∫WWᵀdt (1/s³)", ylim=(0.0, None))
        # a factor from a zero error does not stretch the axis
        factors = np.concatenate([[1.0], *(np.append(found.condition, found.ratio) for found in walks.values())])
        low, high = np.log10([f(factors[np.isfinite(factors) & (factors > 0.0)]) for f in (np.min, np.max)])
        limits = 10.0 ** (math.floor(low) - 2.5), min(10.0 ** math.ceil(high), 1e5)
        condition.set(yscale="log", ylabel="factor per step", ylim=limits)
        condition.axhline(1.0, color=style.GUIDE, linewidth=1.0)
        titled(over_time, "a", "Lyapunov function (15)")
        titled(errors, "b", "Error before each touchdown")
        titled(excitation, "c", "Excitation: sine (upper), cosine (lower)")
        titled(condition, "d", "Condition (24) and what happened")
        for axes in (errors, excitation, condition):
            axes.set_xlabel("step")
            axes.xaxis.get_major_locator().set_params(integer=True)
        changes = first_walk.slope_change * (np.abs(first_walk.slope_change) > 1e-9)
        for step in np.flatnonzero(changes).tolist() if first_walk.steps <= _MOST_NAMED else ():
            excitation.axvline(step + 1, color=style.GUIDE, linewidth=0.7, zorder=0)
            text = f"{math.degrees(changes[step]):+.3g}°".replace("-", "−")
            note_at(excitation, text, step + 1, 0.02, (2, 0), fontsize=7)
        legend_below(figure, *errors.get_legend_handles_labels())
        condition.legend(loc="lower left")
    return figure


def _positive(values: Values, least: float = 0.0) -> Values:
    """Replace values by NaN that are not finite or not above `least`, for a logarithmic axis."""
    return np.where(np.isfinite(values) & (values > least), values, np.nan)


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
    means = {name: survival.mean for name, survival in survivals.items()}
    words = {name: "no fall" if math.isinf(mean) else f"a fall in {mean:.3g} steps" for name, mean in means.items()}
    with drawn(path) as figure:
        figure.set_figheight(3.4)
        axes = figure.subplots()
        most = max(max(survival.steps) for survival in survivals.values())
        draw_survivals(axes, {f"{name}: {words[name]}": survival for name, survival in survivals.items()}, most)
        axes.set_xlabel("steps (logarithmic)")
        legend_below(figure, *axes.get_legend_handles_labels())
    return figure
