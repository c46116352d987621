"""Figure of a gait of any robot, passive or optimised."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from mjbiped.plotting.panels import head, legend_above, titled, wrapped
from mjbiped.plotting.style import BLUE, C_MT, GROUND, GUIDE, SHADE, SWING, drawn, look, note_at, zero_line
from mjbiped.plotting.width import width
from mjbiped.records.signals import signals_of
from mjbiped.robots.robot import Array
from mjbiped.rules.scuffing import ScuffingRule

APART = 0.5  # distance between two postures of a step, leg lengths

_SAMPLES = 400  # of a phase
_PANEL = 2.9  # height, inches


class _Phase(NamedTuple):
    """Part of a step without an impact: times (s), angles, rates, and torques if known, one row per time."""

    times: Array
    q: Array
    dq: Array
    torques: Array | None


def plot_gait(gait: Any, path: str | Path | None = None) -> Figure:
    """Draw a gait: postures over a step, limit cycle, path of the swing foot, and what else is known of it.

    A robot with knees has a panel for the flexion of the swing knee; a passive gait, one for its Floquet multipliers;
    an optimised gait, one for its torques on level ground.

    Args:
        gait: Passive or optimised gait of any robot.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: The file cannot be written.
    """
    phases = _phases(gait)
    panels: list[Callable[[Axes, str, Any, list[_Phase]], None]] = [_draw_cycle, _draw_foot]
    panels += [_draw_flexion] if "shank" in gait.robot.angles else []
    panels += [_draw_torques] if phases[0].torques is not None else [_draw_multipliers]
    with drawn(path) as figure:
        across = min(width().beside(3), len(panels) if len(panels) != 4 else 2)
        lines = math.ceil(len(panels) / across)
        postures = 8 if width().beside(3) == 3 else 5
        text = wrapped(_title(gait))
        top = 1.1 + 1.45 * width().inches / (APART * (postures - 1) + 1.24)
        figure.set_figheight(top + _PANEL * lines + head(figure, text))
        grid = figure.add_gridspec(1 + lines, across, height_ratios=(top, *[_PANEL] * lines))
        _draw_postures(figure.add_subplot(grid[0, :]), gait, phases, postures)
        for k, draw in enumerate(panels):
            draw(figure.add_subplot(grid[1 + k // across, k % across]), "bcdef"[k], gait, phases)
    return figure


def _phases(gait: Any) -> list[_Phase]:
    """Phases of a step: one, or with knees one before and one after the knee strike."""
    strike = getattr(gait, "knee_strike", None)
    if strike is None:
        times = np.linspace(0.0, gait.period, _SAMPLES)
        motions = [(times, gait.reference(times))]
    else:
        parts = (np.linspace(0.0, strike, _SAMPLES), True), (np.linspace(strike, gait.period, _SAMPLES), False)
        motions = [(times, gait.branch(times, bent=bent)) for times, bent in parts]
    found = []
    for times, motion in motions:
        torques = gait.model.course(*motion).torques if hasattr(gait, "model") else None
        q, dq = (angles[:, np.minimum(np.arange(len(gait.robot.angles)), angles.shape[1] - 1)] for angles in motion[:2])
        found.append(_Phase(times, q, dq, torques))
    return found


def _title(gait: Any) -> str:
    """Kind of the gait and its main numbers."""
    knees = " with knees" if "shank" in gait.robot.angles else ""
    parts = [
        f"period {gait.period:.4f}\u00a0s",
        f"step {gait.step_length:.4f}\u00a0m",
        f"speed {gait.speed:.4f}\u00a0m/s",
    ]
    if knees:
        parts.insert(1, f"knee strike at {gait.knee_strike:.4f}\u00a0s")
    if hasattr(gait, "goal"):
        parts.append(f"clearance {100 * gait.goal.clearance:.3g}\u00a0cm")
        return f"Optimised gait{knees}: {C_MT} {gait.measures.cost_of_transport:.4f}, {', '.join(parts)}"
    if hasattr(gait, "energy"):
        parts.append(f"energy {gait.energy:.3f}\u00a0J")
    if hasattr(gait, "clearance"):
        parts.append(f"clearance {100 * gait.clearance:.2f}\u00a0cm")
    stable = "stable" if gait.stable else "unstable"
    return f"Passive gait{knees} on {math.degrees(gait.slope):.3g}°, {stable}: {', '.join(parts)}"


def _draw_postures(axes: Axes, gait: Any, phases: list[_Phase], count: int) -> None:
    """Panel (a): the robot at equal times, and at the knee strike if there is one, each beside the one before."""
    robot, leg = gait.robot, gait.robot.leg_length
    strike = [phase.times[0] for phase in phases[1:]]
    times = np.sort([*np.linspace(0.0, gait.period, count - len(strike)), *strike])
    every, q = np.concatenate([phase.times for phase in phases]), np.concatenate([phase.q for phase in phases])
    at = np.searchsorted(every, times - 1e-12).clip(max=len(every) - 1)
    places = APART * leg * np.arange(count)
    ground = np.array([-0.62 * leg, places.max() + 0.62 * leg])
    sine, cosine = math.sin(gait.slope), math.cos(gait.slope)
    for place, k, time in zip(places.tolist(), at.tolist(), times.tolist(), strict=True):
        foot = place * cosine, -place * sine
        stance, swing = robot.limbs(robot.posture(foot, 0, (q[k] + gait.slope).tolist()))[:2]
        axes.plot(*stance.T, linewidth=2.2, color=look("q_stance")["color"], solid_capstyle="round")
        for part, link in zip(robot.angles[1:] or ("swing",), range(len(swing) - 1), strict=True):
            axes.plot(
                *swing[link : link + 2].T, linewidth=2.2, color=look(f"q_{part}")["color"], solid_capstyle="round"
            )
        knees = np.concatenate([stance[1:-1], swing[1:-1]])
        axes.plot(*knees.T, "o", color="white", markeredgecolor=SHADE, markersize=3.5)
        axes.plot(*stance[0], "o", color=SHADE, markersize=5)
        words = f"{time:.3f} s" + ("\nknee strike" if time in strike else "")
        hip_x, hip_z = stance[0].tolist()
        note_at(axes, words, hip_x, hip_z, (0, 5), xycoords="data", ha="center")
    low = -(ground * sine).max() - 0.12 * leg
    axes.fill_between(ground * cosine, -ground * sine, low, color=GROUND, linewidth=0)
    axes.plot(ground * cosine, -ground * sine, color=SHADE, linewidth=0.8)
    axes.set_aspect("equal")
    axes.set(xlim=(ground * cosine).tolist(), ylim=(low, 1.28 * leg))
    axes.set(xlabel="along (m), postures set apart", ylabel="height (m)")
    signals = (signals_of(type(robot))[f"q_{part}"] for part in robot.angles)
    handles = [Line2D([], [], color=each.colour, linewidth=2.2, label=each.name) for each in signals]
    titled(axes, "a", "One step")
    legend_above(axes, handles=handles)


def _draw_cycle(axes: Axes, letter: str, gait: Any, phases: list[_Phase]) -> None:
    """Rate over angle of all segments, with an arrow each and dotted lines for the jumps at impacts."""
    angles = gait.robot.angles
    for k, part in enumerate(angles):
        style = look(f"q_{part}")
        for phase in phases[:1] if part == "shank" else phases:  # afterwards thigh and shank are one leg
            axes.plot(phase.q[:, k], phase.dq[:, k], **style)
        for before, after in pairwise(phases):
            jump = (before.q[-1, k], after.q[0, k]), (before.dq[-1, k], after.dq[0, k])
            axes.plot(*jump, color=GUIDE, linestyle=":")
        q, dq = phases[0].q[:, k], phases[0].dq[:, k]
        middle = len(q) // 4
        arrow = {"arrowstyle": "-|>", "color": style["color"], "mutation_scale": 12}
        axes.annotate("", (q[middle + 2], dq[middle + 2]), (q[middle], dq[middle]), arrowprops=arrow)
    n = len(angles)
    for old, new in ((0, 1), (1, 0)) if n > 1 else ((0, 0),):  # the legs change roles
        ends = (gait.end[old], gait.start[new]), (gait.end[n + old], gait.start[n + new])
        axes.plot(*ends, color=GUIDE, linestyle=":", marker="o", markersize=2.5, zorder=1)
    axes.set(xlabel="angle from the ground's normal (rad)", ylabel="rate (rad/s)")
    titled(axes, letter, "Limit cycle; impacts dotted")


def _draw_flexion(axes: Axes, letter: str, gait: Any, phases: list[_Phase]) -> None:
    """Flexion of the swing knee over time."""
    times, q = np.concatenate([phase.times for phase in phases]), np.concatenate([phase.q for phase in phases])
    axes.plot(times, np.degrees(q[:, 2] - q[:, 1]), **look("flexion"))
    axes.axvline(gait.knee_strike, color=GUIDE, linewidth=0.8)
    shift, side = (-4, "right") if gait.knee_strike > 0.7 * gait.period else (4, "left")
    note_at(axes, "knee strike", gait.knee_strike, 0.97, (shift, 0), ha=side, va="top")
    axes.set(xlabel="time (s)", ylabel="flexion of the swing knee (°)", xlim=(0, gait.period), ylim=(0, None))
    titled(axes, letter, "Swing knee")


def _draw_foot(axes: Axes, letter: str, gait: Any, phases: list[_Phase]) -> None:
    """Path of the swing foot over the ground; dotted, how it continues where no ground meets it."""
    robot, late = gait.robot, np.linspace(gait.period, min(1.12 * gait.period, gait.horizon), 40)
    along, height = np.array([robot.swing_foot(q) for phase in phases for q in phase.q]).T
    axes.plot(along, 100 * height, **SWING)
    if hasattr(gait, "goal"):
        beyond = np.array([robot.swing_foot(q) for q in gait.reference(late)[0]]).T
        axes.plot(beyond[0], 100 * beyond[1], color=SWING["color"], linestyle=":", linewidth=1.2)
    axes.axhline(0.0, color=SHADE, linewidth=0.8)
    if "shank" in robot.angles:
        middle = np.flatnonzero(np.abs(along) < along[-1] / 2)
        lowest = int(middle[np.argmin(height[middle])])
        axes.plot(along[lowest], 100 * height[lowest], "o", color=SHADE, markersize=4)
        words = f"clearance {100 * height[lowest]:.2f} cm"
        note_at(axes, words, along[lowest], 100 * height[lowest], (0, -6), xycoords="data", ha="center", va="top")
        axes.set_ylim(0, None)
    elif not robot.collides_from_lift_off:
        reach = ScuffingRule().reach * robot.leg_length
        axes.axvline(reach, color=GUIDE, linestyle="--", linewidth=0.8, zorder=0)
        note_at(axes, "may touch the ground\nfrom here on", reach, 0.97, (-4, 0), ha="right", va="top")
        axes.margins(y=0.15)
    goal = getattr(gait, "goal", None)
    if goal is not None and goal.clearance and "shank" not in robot.angles:
        x, z = robot.swing_foot(gait.reference(gait.clearance_phase * gait.period)[0])
        axes.plot(x, 100 * z, "o", color=SHADE, markersize=4)
        words = "begins to\ncome back" if goal.retraction else "clearance"
        note_at(axes, words, x, 100 * z, (-6, 0), xycoords="data", ha="right", va="center")
    axes.set(xlabel="swing foot ahead of the stance foot (m)", ylabel="height above the ground (cm)")
    titled(axes, letter, "Path of the swing foot")


def _draw_torques(axes: Axes, letter: str, gait: Any, phases: list[_Phase]) -> None:
    """Torques on level ground over time, tracked without error."""
    times = np.concatenate([phase.times for phase in phases])
    torques = np.concatenate([phase.torques for phase in phases if phase.torques is not None])
    signals = signals_of(type(gait.robot))
    for k, joint in enumerate(gait.robot.joints):
        axes.plot(times, torques[:, k], label=signals[f"torque_{joint}"].name, **look(f"torque_{joint}"))
    zero_line(axes)
    axes.set(xlabel="time (s)", ylabel="torque (N\u00a0m)", xlim=(0, gait.period))
    titled(axes, letter, "Torques on level ground")
    legend_above(axes)


def _draw_multipliers(axes: Axes, letter: str, gait: Any, _: list[_Phase]) -> None:
    """Floquet multipliers in the complex plane and in figures."""
    reach = 1.25 * max(1.0, float(np.abs(gait.multipliers).max()))
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=GUIDE, linestyle="--"))
    axes.axhline(0.0, color=GUIDE, linewidth=0.5)
    axes.axvline(0.0, color=GUIDE, linewidth=0.5)
    axes.plot(gait.multipliers.real, gait.multipliers.imag, "o", color=BLUE, markersize=6)
    axes.set(xlim=(-reach, reach), ylim=(-reach, 2.1 * reach), xlabel="real part", ylabel="imaginary part")
    axes.set_aspect("equal")
    titled(axes, letter, "Floquet multipliers, unit circle")
    lines = [f"λ{k} = {_complex(value)}" for k, value in enumerate(gait.multipliers, start=1)]
    text = "\n".join([*lines, f"|λ| ≤ {abs(gait.multipliers[0]):.5f}"])
    axes.text(0.02, 0.98, text, transform=axes.transAxes, va="top", fontsize=width().small)


def _complex(value: complex) -> str:
    """Format a number with five digits, and its imaginary part only if it has one."""
    text = f"{value.real:+.5f}" if value.imag == 0.0 else f"{value.real:+.5f} {value.imag:+.5f} i"
    for sign in "+-":
        text = text.replace(f" {sign}", f" {sign} ")
    return text.replace("-", "−")
