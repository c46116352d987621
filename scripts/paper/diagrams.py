"""The drawings of docs/: robot and symbols, control loop, update of the slope estimate, clearance of the swing foot.

python -m scripts.paper.diagrams
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.figure import Figure

import mjbiped
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.style import BLUE, GUIDE, SHADE, VERMILLION
from scripts.paper.estimator_drawing import draw_estimator
from scripts.paper.framework_drawing import draw_framework
from scripts.paper.robot_drawing import draw_robot

SLOPE = math.radians(2.0)


def draw_clearance() -> Figure:
    """Height of the swing foot over the ground through a passive step: where (4) holds, and where the foot collides."""
    robot, rule = mjbiped.Compass(), mjbiped.ScuffingRule()
    gait = mjbiped.find_passive_gait(robot, SLOPE)
    time = np.linspace(0.0, gait.period, 4001)
    feet = np.array([robot.swing_foot(q) for q in gait.reference(time)[0]])
    ahead = feet[:, 0] * math.cos(SLOPE) + feet[:, 1] * math.sin(SLOPE)
    height, share = 1e3 * feet[:, 1], 100.0 * time / gait.period
    below = np.flatnonzero((time > 0.0) & (time < gait.period) & (height < 0.0))
    contact_enabled = share[
        np.flatnonzero((ahead >= rule.reach * robot.leg_length) & (time > rule.delay) & (height > 0.0))[0]
    ]
    lowest = below[height[below].argmin()]
    ends = (below[0], below[0] - 1), (below[-1], below[-1] + 1)
    first, last = (np.interp(0.0, height[[inner, outer]], share[[inner, outer]]) for inner, outer in ends)
    along = -100.0 * np.interp(first, share, feet[:, 0])  # cm behind the stance foot
    small: dict[str, Any] = {"fontsize": 8.0}
    figure = plot_style.new_figure(3.0)
    whole, near = figure.subplots(1, 2, width_ratios=[1.35, 1.0])
    for axes in (whole, near):
        axes.axhline(0.0, color=SHADE, linewidth=0.9)
        axes.plot(share, height, color=BLUE, linewidth=1.6)
        axes.fill_between(share[below], height[below], 0.0, color=VERMILLION, linewidth=0, alpha=0.6)
        axes.plot(first, 0.0, "v", color=VERMILLION, markersize=7, zorder=5)
        axes.set(xlabel="time since the impact (% of the step)", ylabel="height of the swing foot (mm)")
    whole.axvspan(contact_enabled, 100.0, color=GUIDE, alpha=0.22, linewidth=0)
    text = f"the rule lets it collide:\nfrom {rule.reach:g} leg lengths ahead"
    whole.text(contact_enabled - 1.5, 44.0, text, va="top", ha="right", color=SHADE, **small)
    printed, pointer = "(4) as printed\nends the step here", {"arrowstyle": "-", "color": VERMILLION, "lw": 0.8}
    whole.annotate(printed, (first, 1.5), (17.0, 27.0), color=VERMILLION, arrowprops=pointer, **small)
    whole.set(title="(a) A passive step down 2°", xlim=(0.0, 100.0))
    depth = f"{height[lowest]:.2f} mm".replace("-", "−")
    near.text(share[lowest], height[lowest] - 0.12, depth, ha="center", va="top", **small)
    behind = f"{first:.1f} %: the foot is\n{along:.1f} cm behind"
    near.text(first - 0.5, -0.2, behind, ha="right", va="top", **small)
    near.text(last + 0.6, -0.2, f"{last:.1f} %:\nlegs level", va="top", **small)
    near.set(title="(b) Where it scuffs", xlim=(31.0, 52.0), ylim=(-1.6, 3.0), xticks=range(35, 55, 5))
    return figure


DRAWINGS = {"robot": draw_robot, "framework": draw_framework, "estimator": draw_estimator, "clearance": draw_clearance}


@click.command(help=__doc__)
@click.option(
    "--folder",
    default="docs/images",
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Where they go.",
)
def main(folder: Path) -> None:
    """Draw them all."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in DRAWINGS.items():
        with plot_style.styled():
            figure = draw()
        path = folder / f"{name}.png"
        plot_style.save_figure(figure, path)
        plot_style.make_small(path)
        click.echo(path)


if __name__ == "__main__":
    main()
