"""The figure of an optimised reference: its limit cycle, the swing foot's path, and the torques on level ground."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mjbiped.gaits.optimised import OptimisedGait
from mjbiped.plotting.panels import head, legend_above, titled, wrapped
from mjbiped.plotting.style import ANKLE, C_MT, GUIDE, HIP, SWING, drawn
from mjbiped.plotting.walk import draw_cycle
from mjbiped.plotting.width import width
from mjbiped.rules.scuffing import ScuffingRule

_MOMENTS = 400


def plot_reference(gait: OptimisedGait, path: str | Path | None = None) -> Figure:
    """Draw an optimised reference.

    (a) The limit cycle of both legs with its impacts. (b) The swing foot's path over level ground: where it begins to
    come back, and, dotted, how it goes on where no ground meets it. (c) The torques on level ground, tracked without
    error.

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
        told = gait.measures
        text = wrapped(
            f"Optimised gait: {C_MT} {told.cost_of_transport:.4f}, period {gait.period:.4f}\u00a0s, "
            f"step {gait.step_length:.4f}\u00a0m, speed {gait.speed:.4f}\u00a0m/s"
        )
        across = width().beside(2)
        if across == 2:
            figure.set_figheight(6.2 + head(figure, text))
            places = figure.add_gridspec(2, 2, width_ratios=(1.2, 1.0))
            cycle = figure.add_subplot(places[:, 0])
            foot, torques = (figure.add_subplot(places[row, 1]) for row in (0, 1))
        else:
            figure.set_figheight(9.5 + head(figure, text))
            cycle, foot, torques = figure.subplots(3, 1, height_ratios=(1.6, 1.0, 1.0))
        draw_cycle(cycle, gait)
        _draw_path(foot, gait)
        _draw_torques(torques, gait)
    return figure


def _draw_path(axes: Axes, gait: OptimisedGait) -> None:
    """Panel (b)."""
    late = gait.period * 1.12
    after = np.linspace(gait.period, late, 40)
    for times, look in (
        (np.linspace(0.0, gait.period, _MOMENTS), {**SWING, "linewidth": 1.6}),
        (after, {**SWING, "linestyle": ":", "linewidth": 1.2}),
    ):
        axes.plot(*_foot(gait, times), **look)
    axes.axhline(0.0, color=GUIDE, linewidth=0.8, zorder=0)
    reach = ScuffingRule().reach * gait.robot.leg_length
    axes.axvline(reach, color=GUIDE, linestyle="--", linewidth=0.8, zorder=0)
    axes.annotate(
        "may touch the ground\nfrom here on",
        (reach, 0.0),
        (-4, 4),
        xycoords=axes.get_xaxis_transform(),
        textcoords="offset points",
        ha="right",
        va="bottom",
    )
    if gait.goal.clearance:
        x, z = _foot(gait, np.array([gait.clearance_phase * gait.period]))
        axes.plot(x, z, "ko", markersize=4)
        axes.annotate(
            "begins to come back" if gait.goal.retraction else "clearance",
            (float(x[0]), float(z[0])),
            (0.03, 0.9),
            textcoords="axes fraction",
            arrowprops={"arrowstyle": "-", "color": GUIDE, "shrinkB": 4},
        )
    axes.set(xlabel="ahead of the stance foot (m)", ylabel="height (m)")
    axes.margins(y=0.15)
    titled(axes, "b", "Path of the swing foot")


def _foot(gait: OptimisedGait, times: np.ndarray[Any, np.dtype[np.float64]]) -> tuple[Any, Any]:
    course = gait.model.course(*gait.reference(times))
    return course.ahead, course.height


def _draw_torques(axes: Axes, gait: OptimisedGait) -> None:
    """Panel (c)."""
    times = np.linspace(0.0, gait.period, _MOMENTS)
    torques = gait.model.course(*gait.reference(times)).torques
    for joint, (label, look) in enumerate((("ankle", ANKLE), ("hip", HIP))):
        axes.plot(times, torques[:, joint], label=label, **look)
    axes.axhline(0.0, color=GUIDE, linewidth=0.5, zorder=0)
    axes.set(xlabel="time since the impact (s)", ylabel="torque (N\u00a0m)")
    titled(axes, "c", "Torques on level ground")
    legend_above(axes)
