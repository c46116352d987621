"""The figures of passive and of optimised gaits with knees."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mjbiped.gaits.kneed import SAMPLES, KneedGait
from mjbiped.gaits.optimised import OptimisedKneedGait
from mjbiped.plotting.panels import head, legend_above, titled, wrapped
from mjbiped.plotting.style import ANKLE, C_MT, GROUND, GUIDE, HIP, KNEE, SHADE, SHANK, STANCE, SWING, drawn, note_at
from mjbiped.plotting.width import width
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import KneedBiped

APART = 0.5  # between two postures of a step, leg lengths


class _Step(NamedTuple):
    """What is drawn of a gait; see `KneedGait` for times, states and bent."""

    robot: KneedBiped
    slope: float
    period: float
    knee_strike: float
    times: Array
    states: Array
    bent: int

    @property
    def feet(self) -> Array:
        """The swing foot from the stance foot at `times`, shape (n, 2), m."""
        return np.array([self.robot.swing_foot(q) for q in self.states[:, :3]])


def plot_kneed_gait(gait: KneedGait, path: str | Path | None = None) -> Figure:
    """Draw a passive gait with knees: postures over the step, limit cycle, flexion of the knee, height of the foot.

    Args:
        gait: The gait.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: The file cannot be written.
    """
    text = (
        f"Passive gait with knees on {math.degrees(gait.slope):.3g}°, {'stable' if gait.stable else 'unstable'}: "
        f"period {gait.period:.4f}\u00a0s, knee strike at {gait.knee_strike:.4f}\u00a0s, "
        f"step {gait.step_length:.4f}\u00a0m, clearance {100 * gait.clearance:.2f}\u00a0cm, "
        f"largest |multiplier| {abs(gait.multipliers[0]):.3f}"
    )
    step = _Step(gait.robot, gait.slope, gait.period, gait.knee_strike, gait.times, gait.states, gait.bent_samples)
    return _drawn(step, text, path, [_draw_cycle, _draw_knee, _draw_foot])


def plot_kneed_reference(gait: OptimisedKneedGait, path: str | Path | None = None) -> Figure:
    """Draw an optimised gait with knees: postures, limit cycle, flexion, the foot's height, torques on level ground.

    Arguments, result and errors are those of `plot_kneed_gait`.
    """
    told = gait.measures
    text = (
        f"Optimised gait with knees: {C_MT} {told.cost_of_transport:.4f}, period {gait.period:.4f}\u00a0s, "
        f"knee strike at {gait.knee_strike:.4f}\u00a0s, step {gait.step_length:.4f}\u00a0m, "
        f"speed {gait.speed:.4f}\u00a0m/s, clearance {100 * gait.goal.clearance:.3g}\u00a0cm"
    )
    bent = np.linspace(0.0, gait.knee_strike, 1 + round(SAMPLES * gait.knee_strike / gait.period))
    straight = np.linspace(gait.knee_strike, gait.period, SAMPLES - len(bent))
    branches = [gait.branch(bent, bent=True), gait.branch(straight, bent=False)]
    states = [np.concatenate([q, dq], axis=-1) for q, dq, _ in branches]
    states[1] = states[1][:, [0, 1, 1, 2, 3, 3]]
    times = np.concatenate([bent, straight])
    step = _Step(gait.robot, 0.0, gait.period, gait.knee_strike, times, np.concatenate(states), len(bent))
    torques = np.concatenate([gait.model.course(*branch).torques for branch in branches])

    def draw_torques(axes: Axes, step: _Step) -> None:
        for joint, (label, look) in enumerate((("ankle", ANKLE), ("hip", HIP), ("swing knee", KNEE))):
            axes.plot(step.times, torques[:, joint], label=label, **look)
        axes.axhline(0.0, color=GUIDE, linewidth=0.5, zorder=0)
        axes.set(xlabel="time (s)", ylabel="torque (N\u00a0m)", xlim=(0, step.period))
        titled(axes, "e", "Torques on level ground")
        legend_above(axes)

    return _drawn(step, text, path, [_draw_cycle, _draw_knee, _draw_foot, draw_torques])


def _drawn(step: _Step, text: str, path: str | Path | None, panels: Sequence[Callable[[Axes, _Step], None]]) -> Figure:
    """Postures across the figure, and panels below them."""
    with drawn(path) as figure:
        across = min(width().beside(3), len(panels))
        if len(panels) == 4 and across == 3:
            across = 2
        lines = math.ceil(len(panels) / across)
        postures = 8 if width().beside(3) == 3 else 5
        text = wrapped(text)
        top = 1.1 + 1.45 * width().inches / (APART * (postures - 1) + 1.24)
        figure.set_figheight(top + 2.9 * lines + head(figure, text))
        grid = figure.add_gridspec(1 + lines, across, height_ratios=(top, *[2.9] * lines))
        _draw_postures(figure.add_subplot(grid[0, :]), step, postures)
        for k, draw in enumerate(panels):
            draw(figure.add_subplot(grid[1 + k // across, k % across]), step)
    return figure


def _draw_postures(axes: Axes, gait: _Step, count: int) -> None:
    """Panel (a): the robot on its slope at equal times, and at the knee strike, each beside the one before."""
    leg = gait.robot.leg_length
    times = np.sort([*np.linspace(0, gait.period, count - 1), gait.knee_strike])
    at = np.searchsorted(gait.times, times - 1e-12)
    places = APART * leg * np.arange(count)
    ground = np.array([-0.62 * leg, places.max() + 0.62 * leg])
    sine, cosine = math.sin(gait.slope), math.cos(gait.slope)
    for place, k, time in zip(places.tolist(), at.tolist(), times.tolist(), strict=True):
        along, normal = _joints(gait, gait.states[min(k, len(gait.states) - 1), :3]).T
        along = along + place
        x, z = along * cosine + normal * sine, normal * cosine - along * sine
        axes.plot(x[:3], z[:3], linewidth=2.2, color=STANCE["color"], solid_capstyle="round")
        axes.plot(x[2:4], z[2:4], linewidth=2.2, color=SWING["color"], solid_capstyle="round")
        axes.plot(x[3:], z[3:], linewidth=2.2, color=SHANK["color"], solid_capstyle="round")
        axes.plot(x[[1, 3]], z[[1, 3]], "o", color="white", markeredgecolor=SHADE, markersize=3.5)
        axes.plot(x[2], z[2], "o", color=SHADE, markersize=5)
        strike = "\nknee strike" if time == gait.knee_strike else ""
        axes.annotate(
            f"{time:.3f} s{strike}",
            (x[2], z[2]),
            (0, 5),
            textcoords="offset points",
            ha="center",
            fontsize=width().small,
        )
    axes.fill_between(ground * cosine, -ground * sine, -(ground * sine).max() - 0.12 * leg, color=GROUND, linewidth=0)
    axes.plot(ground * cosine, -ground * sine, color=SHADE, linewidth=0.8)
    axes.set_aspect("equal")
    axes.set(xlim=(ground * cosine).tolist(), ylim=(-(ground * sine).max() - 0.12 * leg, 1.28 * leg))
    axes.set(xlabel="along (m), postures set apart", ylabel="height (m)")
    handles = [
        Line2D([], [], color=look["color"], linewidth=2.2, label=label)
        for look, label in ((STANCE, "stance leg"), (SWING, "swing thigh"), (SHANK, "swing shank"))
    ]
    titled(axes, "a", "One step")
    legend_above(axes, handles=handles)


def _joints(gait: _Step, q: Array) -> Array:
    """Stance foot, stance knee, hip, swing knee, swing foot: shape (5, 2), m, along the ground and its normal."""
    robot = gait.robot
    turned = np.column_stack([np.sin(q), np.cos(q)])
    links = [robot.shank_length * turned[0], robot.thigh_length * turned[0]]
    links += [-robot.thigh_length * turned[1], -robot.shank_length * turned[2]]
    return np.vstack([np.zeros(2), np.cumsum(links, axis=0)])


def _draw_cycle(axes: Axes, gait: _Step) -> None:
    """Panel (b): rate over angle of all segments, jumps at impacts dotted."""
    bent = gait.bent
    for segment, look in ((0, STANCE), (1, SWING), (2, SHANK)):
        q, dq = gait.states[:, segment], gait.states[:, 3 + segment]
        axes.plot(q[:bent], dq[:bent], **look)
        if segment < 2:  # afterwards thigh and shank are one leg
            axes.plot(q[bent:], dq[bent:], **look)
        axes.plot(q[bent - 1 : bent + 1], dq[bent - 1 : bent + 1], color=GUIDE, linestyle=":")
    start, end = gait.states[0], gait.states[-1]
    for before, after in ((0, 1), (1, 0)):
        axes.plot([end[before], start[after]], [end[3 + before], start[3 + after]], color=GUIDE, linestyle=":")
    axes.set(xlabel="angle from the ground's normal (rad)", ylabel="rate (rad/s)")
    titled(axes, "b", "Limit cycle; impacts dotted")


def _draw_knee(axes: Axes, gait: _Step) -> None:
    """Panel (c): flexion of the swing knee."""
    axes.plot(gait.times, np.degrees(gait.states[:, 2] - gait.states[:, 1]), **KNEE)
    axes.axvline(gait.knee_strike, color=GUIDE, linewidth=0.8)
    late = gait.knee_strike > 0.7 * gait.period
    note_at(
        axes, "knee strike", gait.knee_strike, 0.97, (-4 if late else 4, 0), ha="right" if late else "left", va="top"
    )
    axes.set(xlabel="time (s)", ylabel="flexion of the swing knee (°)", xlim=(0, gait.period), ylim=(0, None))
    titled(axes, "c", "The knee")


def _draw_foot(axes: Axes, gait: _Step) -> None:
    """Panel (d): the swing foot's way over the ground."""
    along, height = gait.feet.T
    axes.plot(along, 100 * height, **SWING)
    middle = np.flatnonzero(np.abs(along) < along[-1] / 2)
    lowest = int(middle[np.argmin(height[middle])])
    axes.plot(along[lowest], 100 * height[lowest], "o", color=SHADE, markersize=4)
    axes.annotate(
        f"clearance {100 * height[lowest]:.2f} cm",
        (along[lowest], 100 * height[lowest]),
        (0, -6),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=width().small,
    )
    axes.axhline(0.0, color=SHADE, linewidth=0.8)
    axes.set(xlabel="swing foot ahead of the stance foot (m)", ylabel="above the ground (cm)", ylim=(0, None))
    titled(axes, "d", "The swing foot")
