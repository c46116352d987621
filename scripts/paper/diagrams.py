"""The drawings of docs/: robot and symbols, control loop, update of the slope estimate, clearance of the swing foot.

python -m scripts.paper.diagrams
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

import mjbiped
from controllers import AdaptiveController
from mjbiped.plotting import style as plot_style
from mjbiped.plotting import width
from mjbiped.plotting.style import BLACK, BLUE, ESTIMATE, GUIDE, SHADE, TRUTH, VERMILLION
from scripts.paper.robot_drawing import (
    BOTTOM,
    DARK_ORANGE,
    LEFT_2,
    RIGHT_2,
    ROBOT,
    SLOPES,
    SMALL,
    TOP,
    arc,
    direction,
    draw_robot,
    ground,
    legs,
    line,
    touchdown,
    write,
)

GROUND = mjbiped.Terrain.from_segments([(1.9, 0.0, 0.0), (1.4, 3.0, 0.0), (1.4, -2.0, 0.0), (3.0, 1.0, 0.0)])
STEPS = 14


def posture(axes: Axes, *, after: bool) -> None:
    """The robot at touchdown: the leg that stood, its angle from the normal that counts, and the new normal."""
    first, second = SLOPES
    terrain, lean, front = touchdown()
    rear = np.zeros(2)
    ground(axes, terrain, LEFT_2, RIGHT_2)
    legs(axes, rear, front, ROBOT.leg_length * direction(lean))
    standing, normal = (front, second) if after else (rear, first)
    line(axes, standing, standing + 0.74 * direction(normal), linestyle="-." if after else "--")
    write(axes, standing + 0.80 * direction(normal), "$n_2$" if after else "$n_1$", **SMALL)
    write(axes, standing, "it stands here", (-0.05, -0.14), **SMALL)
    if not after:
        arc(axes, rear, 0.50, first, lean, BLUE)
        write(axes, rear + 0.58 * direction(0.4 * first + 0.6 * lean), "$q_1^-$", color=BLUE)
        text = "the leg that stands,\nfrom the normal $n_1$"
    else:
        for angle, name, dashes in ((first, "$n_1$", "--"), (second, "$n_2$", "-.")):
            line(axes, rear, rear + 0.74 * direction(angle), linestyle=dashes)
            write(axes, rear + 0.80 * direction(angle), name, **SMALL)
        arc(axes, rear, 0.50, second, lean, BLUE)
        write(axes, rear + 0.585 * direction(0.35 * second + 0.65 * lean), "$q_2^+$", color=BLUE)
        arc(axes, rear, 0.66, first, second, VERMILLION, width=2.0)
        write(axes, np.array([-0.50, 0.62]), "$q_1^- - q_2^+$\n" + r"$= \Delta\varphi$", ha="left", color=VERMILLION)
        text = "the same leg, not turned,\nfrom the new normal $n_2$"
    write(axes, np.array([-0.52, 1.08]), text, ha="left", va="top", fontsize=9, color=BLUE, linespacing=1.4)
    if not after:
        write(axes, front + np.array([0.02, -0.14]), "touches here", **{**SMALL, "color": DARK_ORANGE})


def along_a_walk(axes: Axes) -> None:
    """The estimate with and without the update, over the true slope, on ground of three changes."""
    gait = mjbiped.find_passive_gait(ROBOT, math.radians(2.0))
    for update, style, name in (
        (False, {"color": VERMILLION, "linestyle": (0, (4, 1.5))}, "estimate without (27)"),
        (True, {**ESTIMATE}, "estimate with (27)"),
    ):
        law = AdaptiveController(ROBOT, gait, estimate_update=update)
        walk = mjbiped.walk(law, GROUND, engine="hybrid", steps=STEPS)
        time, estimate, slope = (walk.samples[column] for column in ("time", "slope_estimate", "slope"))
        if update:
            axes.plot(time, np.degrees(slope), **{**TRUTH, "linewidth": 3.0, "alpha": 0.5}, label="true slope")
        axes.plot(time, np.degrees(estimate), **style, label=name)
    axes.set(xlabel="time (s)", ylabel="slope under the stance foot (°)", ylim=(-3.2, 6.0))
    axes.legend(loc="upper right", fontsize=8.5)


def draw_estimator() -> Figure:
    """Before the touchdown, after it, and along a walk."""
    figure = plot_style.new_figure(3.1)
    before, after, walk = figure.subplots(1, 3, width_ratios=[1.0, 1.0, 1.15])
    for axes, shown, title in ((before, False, "(a) Just before touchdown"), (after, True, "(b) Just after it")):
        posture(axes, after=shown)
        axes.set(xlim=(LEFT_2, RIGHT_2), ylim=(BOTTOM, TOP), title=title)
        axes.set_aspect("equal")
        axes.axis("off")
    along_a_walk(walk)
    walk.set(title="(c) The estimate along a walk")
    return figure


DRAWING: Mapping[str, Any] = tomllib.loads(Path(__file__).with_name("framework.toml").read_text(encoding="utf-8"))
HEIGHT = 4.85  # of the drawing, whose unit is the inch
LOWEST = 0.2
KINDS: Mapping[str, Mapping[str, Any]] = {
    "always": {"color": BLACK, "linestyle": "-"},
    "touchdown": {"color": VERMILLION, "linestyle": (0, (4, 1.6))},
}


def box(axes: Axes, ends: Sequence[float], **look: Any) -> None:
    """A rounded box between its left and right, lower and upper ends."""
    left, right, low, high = ends
    style = "round,pad=0,rounding_size=0.06"
    axes.add_patch(FancyBboxPatch((left, low), right - left, high - low, boxstyle=style, **look))


def block(axes: Axes, ends: Sequence[float], name: str, law: str) -> None:
    """A part of the loop: its box, its name, and what it computes under it."""
    box(axes, ends, facecolor="white", edgecolor=BLACK, lw=1.1, zorder=4)
    x, top = (ends[0] + ends[1]) / 2, (ends[2] + ends[3]) / 2 + 0.10 * (law.count("\n") + 1)
    axes.text(x, top, name, fontsize=9, weight="bold", ha="center", va="center", zorder=6)
    axes.text(x, top - 0.13, law, fontsize=9, linespacing=1.45, ha="center", va="top", zorder=6)


def wire(axes: Axes, kind: str, points: Sequence[tuple[float, float]]) -> None:
    """A signal's way through some points, with an arrow at its end."""
    look = KINDS[kind]
    axes.plot(*zip(*points, strict=True), linewidth=1.2, zorder=3, solid_capstyle="butt", **look)
    (x0, y0), (x1, y1) = points[-2:]
    share = 0.15 / max(abs(x1 - x0), abs(y1 - y0))  # of the last piece, for the arrow's head
    style = {"arrowstyle": "-|>", "color": look["color"], "lw": 0.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    axes.annotate("", points[-1], (x1 - share * (x1 - x0), y1 - share * (y1 - y0)), arrowprops=style, zorder=5)


def draw_framework() -> Figure:
    """The whole loop."""
    figure = plot_style.new_figure(HEIGHT - LOWEST)
    axes = figure.add_subplot()
    axes.set(xlim=(0.0, width().inches), ylim=(LOWEST, HEIGHT))
    axes.axis("off")
    for *ends, colour, name in DRAWING["groups"]:
        box(axes, ends, facecolor=colour, edgecolor=SHADE, lw=0.6, zorder=1)
        axes.text(ends[0] + 0.12, ends[2] + 0.13, name, fontsize=9, color=SHADE, va="bottom", linespacing=1.4)
    for *ends, name, law in DRAWING["blocks"]:
        block(axes, ends, name, law)
    for kind, *points in DRAWING["wires"]:
        wire(axes, kind, points)
    for kind, x, y in DRAWING["joins"]:
        axes.plot(x, y, "o", color=KINDS[kind]["color"], markersize=4, zorder=5)
    for kind, x, y, text in DRAWING["signals"]:
        axes.text(x, y, text, color=KINDS[kind]["color"], fontsize=9.5, va="bottom", ha="left", zorder=6)
    for x, text in ((0.65, "at every moment"), (2.45, "once a step, at touchdown")):
        axes.text(x, 4.62, text, fontsize=8.5, va="center")
    return figure


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
