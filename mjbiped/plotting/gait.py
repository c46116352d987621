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
from numpy.typing import NDArray

from mjbiped.gaits.gait import Gait
from mjbiped.plotting import width
from mjbiped.plotting.panels import head, legend_above, titled, wrapped
from mjbiped.plotting.style import BLUE, C_MT, GROUND, GUIDE, SHADE, SWING, drawn, look, note_at, zero_line
from mjbiped.records.signals import signals_of
from mjbiped.robots.robot import Array
from mjbiped.rules.scuffing import ScuffingRule

APART = 0.5  # distance between two postures of a step, leg lengths

_SAMPLES = 400  # of a phase, which is a part of a step without an impact
_PANEL = 2.9  # height, inches
_FAR_OUTSIDE = 3.0  # radii of the unit circle, beyond which a multiplier would hide where the others are


class _Course(NamedTuple):
    """A step of a gait: times (s), angles and rates, one row per time, in phases without an impact.

    Attributes:
        gait: The gait.
        times: Times since the heel strike, s.
        q: Angles, rad.
        dq: Their rates, rad/s.
        motions: Trajectory of each phase: angles, rates and accelerations.
        phases: Rows of each phase: those before and after the knee strike, or all rows without knees.
    """

    gait: Any
    times: Array
    q: Array
    dq: Array
    motions: list[tuple[Array, Array, Array]]
    phases: tuple[slice, ...]


def plot_gait(gait: Gait, path: str | Path | None = None) -> Figure:
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
    course = _course(gait)
    panels: list[Callable[[Axes, str, _Course], None]] = [_draw_cycle, _draw_foot]
    panels += [_draw_flexion] if len(course.phases) > 1 else []
    panels.append(_draw_torques if hasattr(gait, "goal") else lambda axes, k, _: draw_multipliers(axes, k, gait))
    with drawn(path) as figure:
        across = min(width().beside(3), len(panels) if len(panels) != 4 else 2)
        lines = math.ceil(len(panels) / across)
        postures = 8 if width().beside(3) == 3 else 5
        text = wrapped(_title(gait))
        top = 1.1 + 1.45 * width().inches / (APART * (postures - 1) + 1.24)
        figure.set_figheight(top + _PANEL * lines + head(figure, text))
        grid = figure.add_gridspec(1 + lines, across, height_ratios=(top, *[_PANEL] * lines))
        _draw_postures(figure.add_subplot(grid[0, :]), course, postures)
        for k, draw in enumerate(panels):
            draw(figure.add_subplot(grid[1 + k // across, k % across]), "bcdef"[k], course)
    return figure


def _course(gait: Any) -> _Course:
    """Sample a step of a gait."""
    last = np.nextafter(gait.period, 0.0)  # a reference may stand still from the period on
    ends = [0.0, *([] if gait.knee_strike is None else [gait.knee_strike]), last]
    times = [np.linspace(*span, _SAMPLES) for span in pairwise(ends)]
    motions = [gait.branch(phase, bent=k == 0) for k, phase in enumerate(times)]
    locked = [0, 1, *range(1, len(gait.robot.angles) - 1)]  # the angle of a leg with a locked knee is its shank's, too
    q, dq, _ = (
        np.concatenate([each if each.shape[1] == len(gait.robot.angles) else each[:, locked] for each in parts])
        for parts in zip(*motions, strict=True)
    )
    phases = tuple(slice(k * _SAMPLES, (k + 1) * _SAMPLES) for k in range(len(times)))
    return _Course(gait, np.concatenate(times), q, dq, motions, phases)


def _title(gait: Any) -> str:
    """Kind of the gait and its main numbers."""
    optimised, knees = hasattr(gait, "goal"), gait.knee_strike is not None
    kind = ("Optimised gait" if optimised else "Passive gait") + (" with knees" if knees else "")
    numbers = [f"period {gait.period:.4f} s", f"step {gait.step_length:.4f} m", f"speed {gait.speed:.4f} m/s"]
    if knees:
        numbers.insert(1, f"knee strike at {gait.knee_strike:.4f} s")
    if optimised:
        kind += f": {C_MT} {gait.measures.cost_of_transport:.4f}, "
        numbers.append(f"clearance {100 * gait.goal.clearance:.3g} cm")
    else:
        kind += f" on {math.degrees(gait.slope):.3g}°, {'stable' if gait.stable else 'unstable'}: "
        numbers += [] if knees else [f"energy {gait.energy:.3f} J"]
        numbers += [f"clearance {100 * gait.clearance:.2f} cm"] if hasattr(gait, "clearance") else []
    return kind + ", ".join("\u00a0".join(number.rsplit(" ", 1)) for number in numbers)  # units stay beside numbers


def _draw_postures(axes: Axes, course: _Course, count: int) -> None:
    """Panel (a): the robot at equal times, and at the knee strike if there is one, each beside the one before."""
    gait, robot, leg = course.gait, course.gait.robot, course.gait.robot.leg_length
    pitch = [part for part in robot.angles if part != "roll"]
    parts, slope = pitch if len(pitch) > 1 else ("stance", "swing"), gait.slope * (np.array(robot.angles) != "roll")
    colours = [look(f"q_{part}")["color"] for part in parts]
    strike = course.times[[phase.start for phase in course.phases[1:]]].tolist()
    times = np.sort([*np.linspace(0.0, gait.period, count - len(strike)), *strike])
    at = np.searchsorted(course.times, times - 1e-12).clip(max=len(course.times) - 1)
    down = np.array([math.cos(gait.slope), -math.sin(gait.slope)])
    raised = robot.radius * down[::-1] * [-1.0, 1.0]  # of the centre of a round foot over the ground
    ends = [-0.62 * leg]
    for foot, q, time in zip(np.outer(APART * leg * np.arange(count), down), course.q[at] + slope, times, strict=True):
        stance, swing, *_ = robot.outline(robot.posture(foot + raised, 0, q.tolist()))
        bends = len(robot.bodies.leg)  # points of a leg from the hip down, before its foot
        for line, colour in zip((stance, swing[:2], swing[1:]), (*colours[:2], colours[-1]), strict=True):
            axes.plot(*line.T, color=colour, linewidth=2.2, solid_capstyle="round")
        knees = np.concatenate([stance[1:bends], swing[1:bends]])
        axes.plot(*knees.T, "o", color="white", markeredgecolor=SHADE, markersize=3.5)
        axes.plot(*stance[0], "o", color=SHADE, markersize=5)
        words = f"{time:.3f} s" + ("\nknee strike" if time in strike else "")
        hip_x, hip_z = stance[0].tolist()
        note_at(axes, words, hip_x, hip_z, (0, 5), xycoords="data", ha="center")
        ends.append(max(foot[0] + 0.62 * leg, float(swing[:, 0].max()) + 0.1 * leg))
    x, z = np.outer(down / down[0], [min(ends), max(ends)])
    low = float(z.min()) - 0.12 * leg
    axes.fill_between(x, z, low, color=GROUND, linewidth=0)
    axes.plot(x, z, color=SHADE, linewidth=0.8)
    axes.set_aspect("equal")
    axes.set(xlim=x.tolist(), ylim=(low, 1.28 * leg))
    axes.set(xlabel="along (m), postures set apart", ylabel="height (m)")
    signals = (signals_of(type(robot))[f"q_{part}"] for part in robot.angles if part != "roll")
    handles = [Line2D([], [], color=each.colour, linewidth=2.2, label=each.name) for each in signals]
    titled(axes, "a", "One step")
    legend_above(axes, handles=handles)


def _draw_cycle(axes: Axes, letter: str, course: _Course) -> None:
    """Rate over angle of all segments, with an arrow each and dotted lines for the jumps at impacts."""
    gait, phases, angles = course.gait, course.phases, course.gait.robot.angles
    for part, q, dq in zip(angles, course.q.T, course.dq.T, strict=True):
        style = look(f"q_{part}")
        for phase in phases[:1] if part == "shank" else phases:  # afterwards thigh and shank are one leg
            axes.plot(q[phase], dq[phase], **style)
        for phase in phases[1:]:
            jump = slice(phase.start - 1, phase.start + 1)
            axes.plot(q[jump], dq[jump], color=GUIDE, linestyle=":")
        first = _SAMPLES // 4
        arrow = {"arrowstyle": "-|>", "color": style["color"], "mutation_scale": 12}
        axes.annotate("", (q[first + 2], dq[first + 2]), (q[first], dq[first]), arrowprops=arrow)
    n = len(angles)
    for old, new in ((0, 1), (1, 0)) if n > 1 else ((0, 0),):  # the legs change roles
        ends = (gait.end[old], gait.start[new]), (gait.end[n + old], gait.start[n + new])
        axes.plot(*ends, color=GUIDE, linestyle=":", marker="o", markersize=2.5, zorder=1)
    axes.set(xlabel="angle from the ground's normal (rad)", ylabel="rate (rad/s)")
    titled(axes, letter, "Limit cycle; impacts dotted")


def _draw_flexion(axes: Axes, letter: str, course: _Course) -> None:
    """Flexion of the swing knee over time."""
    gait, q = course.gait, course.q
    axes.plot(course.times, np.degrees(q[:, 2] - q[:, 1]), **look("flexion"))
    axes.axvline(gait.knee_strike, color=GUIDE, linewidth=0.8)
    shift, side = (-4, "right") if gait.knee_strike > 0.7 * gait.period else (4, "left")
    note_at(axes, "knee strike", gait.knee_strike, 0.97, (shift, 0), ha=side, va="top")
    axes.set(xlabel="time (s)", ylabel="flexion of the swing knee (°)", xlim=(0, gait.period), ylim=(0, None))
    titled(axes, letter, "Swing knee")


def _draw_foot(axes: Axes, letter: str, course: _Course) -> None:
    """Path of the swing foot over the ground; dotted, how it continues where no ground meets it."""
    gait, robot, goal = course.gait, course.gait.robot, getattr(course.gait, "goal", None)
    along, height = _foot_path(robot, course.q)
    axes.plot(along, height, **SWING)
    if goal is not None:
        late = np.linspace(gait.period, min(1.12 * gait.period, gait.horizon), 40)
        axes.plot(*_foot_path(robot, gait.reference(late)[0]), color=SWING["color"], linestyle=":", linewidth=1.2)
    axes.axhline(0.0, color=SHADE, linewidth=0.8)
    words, at = "", (0.0, 0.0)
    if len(course.phases) > 1:
        middle = np.flatnonzero(np.abs(along) < along[-1] / 2)
        lowest = int(middle[np.argmin(height[middle])])
        words, at = f"clearance {height[lowest]:.2f} cm", (along[lowest], height[lowest])
        place: dict[str, Any] = {"offset": (0, -6), "ha": "center", "va": "top"}
        axes.set_ylim(0, None)
    elif not robot.collides_from_lift_off:
        reach = ScuffingRule().reach * robot.leg_length
        axes.axvline(reach, color=GUIDE, linestyle="--", linewidth=0.8, zorder=0)
        note_at(axes, "may touch the ground\nfrom here on", reach, 0.97, (-4, 0), ha="right", va="top")
        axes.margins(y=0.15)
        if goal is not None and goal.clearance:
            words = "begins to\ncome back" if goal.retraction else "clearance"
            at = _foot_path(robot, gait.reference(gait.clearance_phase * gait.period)[0])
            place = {"offset": (-6, 0), "ha": "right", "va": "center"}
    if words:
        axes.plot(*at, "o", color=SHADE, markersize=4)
        note_at(axes, words, *at, xycoords="data", **place)
    axes.set(xlabel="swing foot ahead of the stance foot (m)", ylabel="height above the ground (cm)")
    titled(axes, letter, "Path of the swing foot")


def _foot_path(robot: Any, q: Array) -> Any:
    """Places of the swing foot ahead of the stance foot (m) and above the ground (cm) at angles `q`."""
    along, *_, height = np.apply_along_axis(robot.swing_foot, -1, q).T
    return along, 100.0 * height


def _draw_torques(axes: Axes, letter: str, course: _Course) -> None:
    """Torques on level ground over time, tracked without error."""
    robot, signals = course.gait.robot, signals_of(type(course.gait.robot))
    torques = np.concatenate([course.gait.model.course(*motion).torques for motion in course.motions])
    for joint, torque in zip(robot.joints, torques.T, strict=True):
        axes.plot(course.times, torque, label=signals[f"torque_{joint}"].name, **look(f"torque_{joint}"))
    zero_line(axes)
    axes.set(xlabel="time (s)", ylabel="torque (N\u00a0m)", xlim=(0, course.gait.period))
    titled(axes, letter, "Torques")
    legend_above(axes)


def draw_multipliers(axes: Axes, letter: str, gait: Any) -> None:
    """Draw the Floquet multipliers of a gait, in the complex plane and in figures; arrows lead to those far outside."""
    multipliers: NDArray[np.complex128] = gait.multipliers
    size = np.abs(multipliers)
    far = size > _FAR_OUTSIDE
    reach = 1.25 * max(1.0, float(size[~far].max(initial=0.0)))
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=GUIDE, linestyle="--"))
    axes.axhline(0.0, color=GUIDE, linewidth=0.5)
    axes.axvline(0.0, color=GUIDE, linewidth=0.5)
    axes.plot(multipliers[~far].real, multipliers[~far].imag, "o", color=BLUE, markersize=6)
    for way in reach * multipliers[far] / size[far]:
        arrow = {"arrowstyle": "-|>", "color": BLUE, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate("", (way.real, way.imag), (0.8 * way.real, 0.8 * way.imag), arrowprops=arrow)
    axes.set(xlim=(-reach, reach), ylim=(-reach, 2.1 * reach), xlabel="real part", ylabel="imaginary part")
    axes.set_aspect("equal")
    titled(axes, letter, "Floquet multipliers")
    lines = [f"λ{k} = {_complex(value)}" for k, value in enumerate(multipliers, start=1)]
    text = "\n".join([*lines, f"|λ| ≤ {abs(multipliers[0]):.5f}"])
    axes.text(0.02, 0.98, text, transform=axes.transAxes, va="top", fontsize=width().small)


def _complex(value: complex) -> str:
    """Format a number with five digits, and its imaginary part only if it has one."""
    text = f"{value.real:+.5f}" + (f" {value.imag:+.5f} i" if value.imag else "")
    return text.replace(" +", " + ").replace(" -", " - ").replace("-", "−")
