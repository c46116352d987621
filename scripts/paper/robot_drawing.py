"""The robot with its symbols, in single and in double support (Fig. 1 of the paper).

Every line and arc comes from `Compass` and `Terrain`; nothing is placed by eye but the texts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from numpy.typing import NDArray
from scipy.optimize import brentq

import mjbiped
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.style import BLACK, BLUE, GROUND, GUIDE, ORANGE, SHADE, VERMILLION

Point: TypeAlias = NDArray[np.float64]

ROBOT = mjbiped.Compass()
SLOPE, POSTURE = math.radians(12.0), np.radians([15.0, -33.0])  # stance and swing leg from the ground's normal
SLOPES, SWING = np.radians([5.0, 16.0]).tolist(), math.radians(-17.0)  # of double support, the leg from the vertical
BREAK = 0.42  # where that ground's slope changes, m
LEFT, RIGHT = -0.76, 1.16  # ends of single support, m
LEFT_2, RIGHT_2 = -0.55, 1.20  # of double support
BOTTOM, TOP = -0.40, 1.10

DARK_ORANGE = "#9A6700"  # for letters and arcs that belong to the orange leg
BOX: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 1.2}
SMALL: dict[str, Any] = {"fontsize": 8.5, "color": SHADE}


def direction(angle: float) -> Point:
    """Unit vector up a line that leans forward by an angle from the vertical (rad): e of docs/model.md."""
    return np.array([math.sin(angle), math.cos(angle)])


def from_ground(point: Sequence[float] | Point, slope: float) -> Point:
    """A point given along the ground and along its normal, in x forward and z up."""
    along, normal = point
    return np.asarray(along * direction(slope + math.pi / 2) + normal * direction(slope))


def write(axes: Axes, point: Point, text: str, aside: tuple[float, float] = (0.0, 0.0), **style: Any) -> None:
    """A text with its middle at a point, or somewhat aside of it (m)."""
    x, z = point + np.array(aside)
    axes.text(x, z, text, **{"fontsize": 11, "ha": "center", "va": "center", "zorder": 9, **style})


def line(axes: Axes, start: Point, end: Point, **style: Any) -> None:
    """A straight line between two points."""
    axes.plot(*np.array([start, end]).T, **{"color": SHADE, "linewidth": 0.9, "zorder": 3, **style})


def arrow(axes: Axes, start: Point, end: Point, colour: str, style: str = "-|>", **more: Any) -> None:
    """A straight arrow."""
    settings = {"mutation_scale": 9, "lw": 1.1, "shrinkA": 0, "shrinkB": 0, "zorder": 6, **more}
    axes.add_patch(FancyArrowPatch(tuple(start), tuple(end), arrowstyle=style, color=colour, **settings))


def arc(axes: Axes, centre: Point, radius: float, start: float, stop: float, colour: str, width: float = 1.2) -> None:
    """An arc between two lines that lean by angles from the vertical (rad), with an arrow at the second."""
    angles = np.linspace(start, stop, 60)
    head = min(0.4 * abs(stop - start), 0.045 / radius)
    points = np.array([centre + radius * direction(angle) for angle in angles])
    axes.plot(*points[np.abs(angles - stop) > 0.6 * head].T, color=colour, linewidth=width, zorder=6)
    before = centre + radius * direction(stop - math.copysign(head, stop - start))
    arrow(axes, before, points[-1], colour, mutation_scale=7 + 2 * width, lw=0)


def dimension(axes: Axes, start: Point, end: Point, text: str, offset: float) -> None:
    """A length between two points, drawn beside them: `offset` m to the right of the way from start to end."""
    along = (end - start) / np.linalg.norm(end - start)
    aside = offset * np.array([along[1], -along[0]])
    for point in (start, end):
        line(axes, point + 0.25 * aside, point + 1.15 * aside, color=GUIDE, linewidth=0.6)
    arrow(axes, start + aside, end + aside, SHADE, "<|-|>", mutation_scale=7, lw=0.8)
    write(axes, (start + end) / 2 + aside, text, bbox=BOX)


def legs(axes: Axes, stance: Point, swing: Point, hip: Point) -> list[Point]:
    """Both legs, in the colours of all figures; returns their centres of mass."""
    centres = []
    for foot, colour in ((stance, BLUE), (swing, ORANGE)):
        assert math.isclose(float(np.linalg.norm(hip - foot)), ROBOT.leg_length)
        line(axes, foot, hip, color=colour, linewidth=5.5, solid_capstyle="round", zorder=5)
        centres.append(foot + ROBOT.lower_length / ROBOT.leg_length * (hip - foot))
        axes.plot(*centres[-1], "o", color=BLACK, markersize=9, zorder=7)
    axes.plot(*hip, "o", color="white", markeredgecolor=BLACK, markeredgewidth=1.5, markersize=11, zorder=8)
    return centres


def ground(axes: Axes, terrain: mjbiped.Terrain, start: float, stop: float) -> None:
    """The profile and what is under it."""
    x, z = terrain.outline(start, stop)
    axes.fill_between(x, z, BOTTOM, color=GROUND, linewidth=0, zorder=1)
    axes.plot(x, z, color=SHADE, linewidth=1.4, zorder=2)


def slope_angle(axes: Axes, terrain: mjbiped.Terrain, x: float, text: str) -> None:
    """The ground's slope at a place, against a horizontal line."""
    point = np.array([x, terrain.height_at(x)])
    line(axes, point, point + 0.32 * direction(math.pi / 2), linestyle=":")
    arc(axes, point, 0.27, math.pi / 2, math.pi / 2 + terrain.slope_at(x), SHADE)
    write(axes, point, text, (0.27, 0.05))


def frame(axes: Axes, corner: Point) -> None:
    """The axes, gravity, and which way round is positive."""
    for way, text in ((np.array([0.2, 0.0]), "$x$"), (np.array([0.0, 0.2]), "$z$")):
        arrow(axes, corner, corner + way, BLACK)
        write(axes, corner + 1.17 * way, text)
    write(axes, corner, "walking direction", (0.0, -0.06), **SMALL, ha="left")
    top = corner + np.array([0.38, 0.36])
    arrow(axes, top, top - 0.2 * direction(0.0), BLACK)
    write(axes, top, "$g$", (0.05, -0.08))
    centre = corner + np.array([0.12, 0.40])
    arc(axes, centre, 0.08, math.radians(-100), math.radians(100), BLACK)
    write(axes, centre, "+")


def single_support(axes: Axes) -> None:
    """Angles, lengths, masses and torques."""
    q1, q2 = POSTURE.tolist()
    terrain = mjbiped.Terrain.incline(math.degrees(SLOPE))
    along, _ = ROBOT.swing_foot(POSTURE)
    stance, swing, below = np.zeros(2), from_ground(ROBOT.swing_foot(POSTURE), SLOPE), from_ground((along, 0.0), SLOPE)
    hip = ROBOT.leg_length * direction(q1 + SLOPE)
    ground(axes, terrain, LEFT, RIGHT)
    slope_angle(axes, terrain, LEFT + 0.04, r"$\varphi$")
    line(axes, stance, 0.74 * direction(0.0), linestyle=":")
    line(axes, stance, 0.74 * direction(SLOPE), linestyle="--")
    line(axes, hip, hip - 0.43 * direction(SLOPE), linestyle="--")
    write(axes, 0.78 * direction(-0.05), "vertical", **SMALL)
    write(axes, 0.78 * direction(SLOPE), "normal", **SMALL)
    stance_centre, swing_centre = legs(axes, stance, swing, hip)
    arc(axes, stance, 0.44, 0.0, SLOPE, SHADE)
    write(axes, 0.49 * direction(0.5 * SLOPE), r"$\varphi$")
    arc(axes, stance, 0.44, SLOPE, SLOPE + q1, BLUE)
    write(axes, 0.50 * direction(SLOPE + 0.45 * q1), "$q_1$", color=BLUE)
    arc(axes, stance, 0.27, 0.0, SLOPE + q1, SHADE)
    write(axes, 0.325 * direction(0.5 * (SLOPE + q1)), r"$\theta_1$", bbox=BOX)
    arc(axes, hip, 0.34, SLOPE + math.pi, SLOPE + q2 + math.pi, DARK_ORANGE)
    write(axes, hip - 0.40 * direction(SLOPE + 0.5 * q2), "$q_2$", color=DARK_ORANGE)
    dimension(axes, swing, swing_centre, "$a$", 0.12)
    dimension(axes, swing_centre, hip, "$b$", 0.12)
    dimension(axes, swing, hip, "$l$", 0.26)
    dimension(axes, below, swing, "$H$", -0.09)
    write(axes, swing_centre, "$m, J$", (-0.10, -0.045))
    write(axes, stance_centre, "$m, J$", (0.10, -0.045))
    write(axes, hip, "$m_H$", (-0.11, -0.055))
    arc(axes, stance, 0.13, math.radians(-105), math.radians(-14), VERMILLION, width=2.0)
    write(axes, stance, r"$\tau_1$", (-0.16, 0.135), color=VERMILLION)
    arc(axes, hip, 0.13, math.radians(-75), math.radians(60), VERMILLION, width=2.0)
    write(axes, hip + 0.19 * direction(-0.2), r"$\tau_2$", color=VERMILLION)
    write(axes, stance, "stance leg", (0.0, -0.11), **{**SMALL, "color": BLUE})
    write(axes, below, "swing leg", (0.0, -0.10), **{**SMALL, "color": DARK_ORANGE})
    frame(axes, np.array([-0.70, 0.58]))
    text = (
        r"$\theta = q + \varphi$; drawn with $\varphi > 0$, $q_1 > 0$, $q_2 < 0$"
        "\n"
        r"on stance and swing leg: $B\tau = (\tau_1 - \tau_2,\, \tau_2)$"
    )
    write(axes, np.array([-0.70, -0.29]), text, **SMALL, ha="left", linespacing=1.6)


def touchdown() -> tuple[mjbiped.Terrain, float, Point]:
    """Ground whose slope changes between the feet; the stance leg's lean at touchdown, rad; and the swing foot."""
    first, second = SLOPES
    pieces = [(BREAK / math.cos(first), math.degrees(first), 0.0), (2.0, math.degrees(second), 0.0)]
    terrain = mjbiped.Terrain.from_segments(pieces)

    def swing_foot(lean: float) -> Point:
        return from_ground(ROBOT.swing_foot([lean - first, SWING - first]), first)

    def clearance(lean: float) -> float:
        x, z = swing_foot(lean).tolist()
        return float(z - terrain.height_at(x))

    lean = float(brentq(clearance, 0.0, 0.8))
    return terrain, lean, swing_foot(lean)


def double_support(axes: Axes) -> None:
    """The angles before and after the impact, where the ground's slope changes between the feet."""
    first, second = SLOPES
    terrain, lean, front = touchdown()
    rear, hip = np.zeros(2), ROBOT.leg_length * direction(lean)
    ground(axes, terrain, LEFT_2, RIGHT_2)
    slope_angle(axes, terrain, -0.50, r"$\varphi_1$")
    slope_angle(axes, terrain, 0.78, r"$\varphi_2$")
    legs(axes, rear, front, hip)
    for foot, angle, colour, before, after, name in (
        (rear, lean, BLUE, "$q_1^-$", "$q_2^+$", "stance leg, now\nthe swing leg"),
        (front, SWING, DARK_ORANGE, "$q_2^-$", "$q_1^+$", "swing leg, now\nthe stance leg"),
    ):
        for normal, text, radius, dashes in ((first, before, 0.56, "--"), (second, after, 0.40, "-.")):
            line(axes, foot, foot + 0.66 * direction(normal), linestyle=dashes)
            write(axes, foot + 0.70 * direction(normal), "$n_1$" if normal == first else "$n_2$", **SMALL)
            arc(axes, foot, radius, normal, angle, colour)
            write(axes, foot + (radius + 0.06) * direction(0.4 * normal + 0.6 * angle), text, color=colour)
        write(axes, foot, name, (0.0, -0.13), **{**SMALL, "color": colour})
    text = (
        "swing and stance leg exchanged:\n"
        r"$q_1^+ = q_2^- - \Delta\varphi$,   $q_2^+ = q_1^- - \Delta\varphi$"
        "\n"
        r"$\Delta\varphi = \varphi_2 - \varphi_1$"
    )
    write(axes, np.array([-0.50, 1.08]), text, ha="left", va="top", fontsize=9.5, linespacing=1.5)


def draw_robot() -> Figure:
    """Both states of the robot."""
    figure = plot_style.new_figure(4.5)
    one, two = figure.subplots(1, 2, width_ratios=[RIGHT - LEFT, RIGHT_2 - LEFT_2])
    single_support(one)
    double_support(two)
    one.set(xlim=(LEFT, RIGHT), title="(a) Single support")
    two.set(xlim=(LEFT_2, RIGHT_2), title="(b) Double support")
    for axes in (one, two):
        axes.set(ylim=(BOTTOM, TOP))
        axes.set_aspect("equal")
        axes.axis("off")
    return figure
