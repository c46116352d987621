"""The control loop as a block diagram: what is computed where, and what passes between (Fig. 2 of the paper)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from mjbiped.plotting import style as plot_style
from mjbiped.plotting.style import BLACK, SHADE, VERMILLION
from mjbiped.plotting.width import width

Point: TypeAlias = tuple[float, float]

HEIGHT = 4.85  # of the drawing, whose unit is the inch
LOWEST = 0.2
ALWAYS: Mapping[str, Any] = {"color": BLACK, "linestyle": "-"}
TOUCHDOWN: Mapping[str, Any] = {"color": VERMILLION, "linestyle": (0, (4, 1.6))}


@dataclass(frozen=True)
class Block:
    """A part of the loop: its ends in inches, its name, and what it computes."""

    left: float
    right: float
    low: float
    high: float
    name: str
    law: str

    @property
    def x(self) -> float:
        """Of its middle."""
        return (self.left + self.right) / 2

    @property
    def y(self) -> float:
        """Of its middle."""
        return (self.low + self.high) / 2

    def draw(self, axes: Axes, face: str = "white", edge: str = BLACK, width: float = 1.1, order: int = 4) -> None:
        """The box alone."""
        outline: dict[str, Any] = {
            "boxstyle": "round,pad=0,rounding_size=0.06",
            "facecolor": face,
            "edgecolor": edge,
            "lw": width,
        }
        place = (self.left, self.low), self.right - self.left, self.high - self.low
        axes.add_patch(FancyBboxPatch(*place, zorder=order, **outline))

    def write(self, axes: Axes) -> None:
        """Its name, and what it computes under it."""
        top = self.y + 0.10 * (self.law.count("\n") + 1)
        axes.text(self.x, top, self.name, fontsize=9, weight="bold", ha="center", va="center", zorder=6)
        axes.text(self.x, top - 0.13, self.law, fontsize=9, linespacing=1.45, ha="center", va="top", zorder=6)


GAIT = Block(0.35, 2.25, 1.75, 2.55, "Passive gait", "limit cycle (28)\n" + r"on the slope $\varphi_r$")
REPLANNING = Block(
    0.35, 2.85, 3.25, 4.05, "Re-planning", "Bézier curves to the gait\n" + r"at $t_c = \zeta\,\Delta T$ (IV-B)"
)
ERRORS = Block(3.75, 5.05, 3.25, 4.05, "Errors", r"$z_1, \dot z_1, z_2$" + "\n(5), (6), (9)")
LAW = Block(5.85, 7.2, 3.25, 4.05, "Tracking law", r"$\tau$ by (14)")
ESTIMATOR = Block(5.6, 7.2, 2.05, 2.75, "Slope estimator", r"$\hat s_\varphi, \hat c_\varphi$ by (17)")
UPDATE = Block(5.25, 7.2, 0.95, 1.6, "Estimate update", r"$\hat\varphi^+ = \hat\varphi^- + q_1^- - q_2^+$ (27)")
ROBOT = Block(7.95, 9.0, 3.0, 4.05, "Robot", "motion (1)\nimpact (2)")
BLOCKS = (GAIT, REPLANNING, ERRORS, LAW, ESTIMATOR, UPDATE, ROBOT)
GROUPS = (
    (Block(0.15, 3.05, 0.75, 4.25, "", "Reference passive trajectory\ngenerator (section IV)"), "#E8F1F8"),
    (Block(3.5, 7.4, 0.75, 4.25, "", "Adaptive controller\n(section III)"), "#EAF5F0"),
)
ROW, ABOVE, BELOW, LATE = LAW.y, 4.55, 0.4, 8.8  # heights of the forward way and of both ways back; x of the late one

SIGNALS = (
    ((1.38, 2.80), r"$q,\, \dot q,\, \ddot q$ on it", BLACK),
    ((2.95, 3.70), r"$q_r, \dot q_r, \ddot q_r$", BLACK),
    ((5.12, 3.70), r"$z_1, \dot z_1, \ddot q_r$", BLACK),
    ((7.47, 3.70), r"$\tau_1, \tau_2$", BLACK),
    ((4.60, 2.45), r"$z_2$", BLACK),
    ((6.60, 2.85), r"$\hat s_\varphi, \hat c_\varphi$", BLACK),
    ((7.68, 2.45), r"$q$", BLACK),
    ((4.50, 4.60), r"$q, \dot q$ of stance and swing leg, from the normal under the stance foot", BLACK),
    ((9.05, 3.57), "unknown\n     " + r"$\varphi$", BLACK),
    ((6.52, 1.72), r"$\hat\varphi^+$", VERMILLION),
    ((7.55, 1.33), r"$q_1^-, q_2^+$", VERMILLION),
    ((4.60, 0.45), r"$q^+, \dot q^+$ after the impact", VERMILLION),
)
"""Names of what passes, by their left lower corners."""


def wire(axes: Axes, *points: Point, kind: Mapping[str, Any] = ALWAYS) -> None:
    """A signal's way through some points, with an arrow at its end."""
    axes.plot(*zip(*points, strict=True), linewidth=1.2, zorder=3, solid_capstyle="butt", **kind)
    (x0, y0), (x1, y1) = points[-2:]
    share = 0.15 / max(abs(x1 - x0), abs(y1 - y0))  # of the last piece, for the arrow's head
    style = {"arrowstyle": "-|>", "color": kind["color"], "lw": 0.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    axes.annotate("", points[-1], (x1 - share * (x1 - x0), y1 - share * (y1 - y0)), arrowprops=style, zorder=5)


def draw_framework() -> Figure:
    """The whole loop."""
    figure = plot_style.new_figure(HEIGHT - LOWEST)
    axes = figure.add_subplot()
    axes.set(xlim=(0.0, width().inches), ylim=(LOWEST, HEIGHT))
    axes.axis("off")
    for group, colour in GROUPS:
        group.draw(axes, colour, SHADE, 0.6, 1)
        axes.text(group.left + 0.12, group.low + 0.13, group.law, fontsize=9, color=SHADE, va="bottom", linespacing=1.4)
    for block in BLOCKS:
        block.draw(axes)
        block.write(axes)
    wire(axes, (GAIT.x, GAIT.high), (GAIT.x, REPLANNING.low))
    wire(axes, (REPLANNING.right, ROW), (ERRORS.left, ROW))
    wire(axes, (ERRORS.right, ROW), (LAW.left, ROW))
    wire(axes, (LAW.right, ROW), (ROBOT.left, ROW))
    wire(axes, (width().inches, ROBOT.y), (ROBOT.right, ROBOT.y))
    wire(axes, (ROBOT.x, ROBOT.high), (ROBOT.x, ABOVE), (ERRORS.x, ABOVE), (ERRORS.x, ERRORS.high))
    wire(axes, (LAW.x, ABOVE), (LAW.x, LAW.high))
    wire(axes, (ERRORS.x, ERRORS.low), (ERRORS.x, ESTIMATOR.y), (ESTIMATOR.left, ESTIMATOR.y))
    wire(axes, (LATE - 0.5, ROBOT.low), (LATE - 0.5, ESTIMATOR.y), (ESTIMATOR.right, ESTIMATOR.y))
    wire(axes, (LAW.x, ESTIMATOR.high), (LAW.x, LAW.low))
    wire(axes, (LATE, ROBOT.low), (LATE, BELOW), (2.6, BELOW), (2.6, REPLANNING.low), kind=TOUCHDOWN)
    wire(axes, (LATE, UPDATE.y), (UPDATE.right, UPDATE.y), kind=TOUCHDOWN)
    wire(axes, (ESTIMATOR.x, UPDATE.high), (ESTIMATOR.x, ESTIMATOR.low), kind=TOUCHDOWN)
    axes.plot(LAW.x, ABOVE, "o", color=BLACK, markersize=4, zorder=5)
    axes.plot(LATE, UPDATE.y, "o", color=VERMILLION, markersize=4, zorder=5)
    for place, text, colour in SIGNALS:
        axes.text(*place, text, color=colour, fontsize=9.5, va="bottom", ha="left", zorder=6)
    for x, kind, text in ((0.15, ALWAYS, "at every moment"), (1.95, TOUCHDOWN, "once a step, at touchdown")):
        wire(axes, (x, 4.62), (x + 0.42, 4.62), kind=kind)
        axes.text(x + 0.5, 4.62, text, fontsize=8.5, va="center")
    return figure
