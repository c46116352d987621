"""The update (27) of the slope estimate: what the robot feels at touchdown where the slope changes, and what it takes.

Legs, normals and arcs come from `Compass` and `Terrain`, the last panel from two walks.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import mjbiped
from controllers import AdaptiveController
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.style import BLUE, ESTIMATE, TRUTH, VERMILLION
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
