"""Time lapse of a walk: stick figures over the profile of the ground, as in the paper's Fig. 4(a)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from mjbiped.errors import RenderError
from mjbiped.plotting.style import BLUE, GROUND, GUIDE, ORANGE, SHADE, VERMILLION, note_at
from mjbiped.plotting.width import DEFAULT_WIDTH, WIDTHS, width
from mjbiped.records.record import Walk
from mjbiped.robots.robot import Array, Robot
from mjbiped.terrain.terrain import Terrain

_ROW = 8.0  # length of ground in a row as wide as a page, m, unless there are too many rows
_MOST_ROWS = 6
_SMALLEST_ROW = 0.5  # least share of that length, for walks of few steps
_BESIDE = 0.75  # room beside a row for the labels of its axis, inches
_BELOW = 0.24  # room for texts under the lowest ground of a row, per inch of paper
_ABOVE = 0.08  # room over the highest hip, m
_LETTER = 0.055  # width of a small letter, inches


@dataclass(frozen=True)
class Row:
    """Piece of the ground on one line of the figure.

    Attributes:
        start: First place, m.
        stop: Last place, m.
        low: Lower end of the picture, m.
        high: Upper end of the picture, m.
        height: Height on paper, inches, with one scale for x and z.
    """

    start: float
    stop: float
    low: float
    high: float
    height: float


def _axis_width() -> float:
    """Width of the axes of a row, inches."""
    return width().inches - _BESIDE


def rows_of(walk: Walk) -> list[Row]:
    """Split the ground that a walk covered into rows of equal length.

    Raises:
        RenderError: The record holds no samples.
    """
    if not len(walk.samples["time"]):
        raise RenderError("the record holds no samples: there is nothing to draw")
    qpos, leg = walk.samples["qpos"], walk.robot.leg_length
    limbs = walk.robot.limbs(qpos)
    reached, tops = limbs[..., 0], limbs[..., 1].max(axis=(1, 2))
    start, stop = float(reached.min()) - 0.15, float(reached.max()) + 0.15
    # half as wide, a row holds 0.7 times the ground, so that the robot is 0.7 times as large
    usual = _ROW * math.sqrt(_axis_width() / (WIDTHS[DEFAULT_WIDTH].inches - _BESIDE))
    count = min(_MOST_ROWS, max(1, math.ceil((stop - start) / usual)))
    length = max((stop - start) / count, _SMALLEST_ROW * usual)
    start -= max(0.0, length - (stop - start)) / 2  # a short walk stands in the middle
    scale = _axis_width() / length  # inches per m
    rows = []
    for index in range(count):
        first = start + index * length
        _, z = walk.terrain.outline(first, first + length)
        inside = (qpos[:, 0] >= first) & (qpos[:, 0] <= first + length)
        highest = float(z.max())
        if inside.any():  # at most two legs over the ground: where a robot that diverges gets to, nothing is drawn
            highest = max(highest, min(float(tops[inside].max()), highest + 2.0 * leg))
        high = highest + _ABOVE
        low = float(z.min()) - _BELOW / scale
        rows.append(Row(first, first + length, low, high, (high - low) * scale))
    return rows


def draw_row(axes: Axes, walk: Walk, row: Row) -> None:
    """Draw the ground of a row and the stick figures whose hip is over it.

    Stance legs are solid, dark and thick, swing legs lighter and thin; the postures of touchdowns are strong, those
    between them faint.
    """
    axes.set(xlim=(row.start, row.stop), ylim=(row.low, row.high), ylabel="z (m)")
    axes.set_aspect("equal", adjustable="box")
    axes.xaxis.set_major_locator(MaxNLocator(min(9, int(2.0 * _axis_width())), steps=[1, 2, 5, 10]))
    scale = _axis_width() / (row.stop - row.start)
    _draw_ground(axes, walk.terrain, row, scale)
    samples, touchdowns = walk.samples, walk.touchdowns
    time, qpos = samples["time"], samples["qpos"]
    axes.plot(qpos[:, 0], qpos[:, 1], color=GUIDE, linewidth=0.6, zorder=2)
    robot = walk.robot
    thick = min(1.6, max(0.5, 1.3 * scale))
    between = _times_between(walk, scale)
    stance = samples["stance"][np.searchsorted(time, between, side="right") - 1]
    postures = np.stack([np.interp(between, time, column) for column in qpos.T], axis=1)
    _draw_sticks(axes, row, postures, stance, robot, 0.55 * thick, 0.35)
    # at a touchdown the old stance leg still is the one that stands
    standing = (touchdowns["stance"] - 1) % len(robot.bodies.limbs)
    _draw_sticks(axes, row, touchdowns["qpos"], standing, robot, thick, 1.0)
    if walk.outcome != "finished" and row.start <= qpos[-1, 0] <= row.stop:
        _draw_sticks(axes, row, qpos[-1:], samples["stance"][-1:], robot, 1.3 * thick, 1.0, VERMILLION)
        x, z, *_ = qpos[-1].tolist()
        shift, side = (-5, "right") if x > row.start + 0.8 * (row.stop - row.start) else (5, "left")
        look = {"fontsize": width().font, "color": VERMILLION, "weight": "bold", "zorder": 8}
        note_at(axes, walk.outcome, x, z, (shift, 0), xycoords="data", ha=side, va="center", **look)


def _times_between(walk: Walk, scale: float) -> Array:
    """Times of the faint postures within steps, s; fewer where the figure would get too dense."""
    bounds = np.unique([walk.samples["time"][0], *walk.touchdowns["time"], walk.samples["time"][-1]])
    parts = 4 if scale > 1.0 else 2 if scale > 0.6 else 1
    inner = [bounds[:1], *(bounds[:-1] + np.diff(bounds) * part / parts for part in range(1, parts))]
    return np.sort(np.concatenate(inner))


def _draw_sticks(
    axes: Axes, row: Row, qpos: Array, stance: NDArray[Any], robot: Robot, width: float, alpha: float, color: str = ""
) -> None:
    """Draw postures as lines from the hip to the feet, the swing legs under the stance legs."""
    inside = (qpos[:, 0] >= row.start) & (qpos[:, 0] < row.stop)
    qpos, stance = qpos[inside], stance[inside].astype(np.int64)
    if not len(qpos):
        return
    hip, limbs = qpos[:, :2], robot.outline(qpos)
    stands = np.arange(limbs.shape[1]) == stance[:, None]
    for is_stance in (False, True):
        leg, thick = (BLUE, width) if is_stance else (ORANGE, 0.7 * width)
        look: dict[str, Any] = {"colors": color or leg, "linewidths": thick, "alpha": alpha, "capstyle": "round"}
        lines = LineCollection(list(limbs[stands == is_stance]), zorder=4 + 2 * (alpha == 1.0) + is_stance, **look)
        axes.add_collection(lines, autolim=False)
    axes.plot(*hip.T, "o", color=color or SHADE, markersize=1.8 * width, markeredgewidth=0, alpha=alpha, zorder=8)


def _draw_ground(axes: Axes, terrain: Terrain, row: Row, scale: float) -> None:
    """Fill the ground, mark changes of slope and steps, and label both where there is room."""
    x, z = terrain.outline(row.start, row.stop)
    axes.fill_between(x, z, row.low, color=GROUND, linewidth=0, zorder=1)
    axes.plot(x, z, color=SHADE, linewidth=0.9, zorder=3)
    if math.isfinite(terrain.end) and row.start < terrain.end < row.stop:
        axes.axvline(terrain.end, color=VERMILLION, linestyle=":", linewidth=1.0)
    first, last = terrain.segment_at(row.start), terrain.segment_at(row.stop)
    text_free = row.start
    for index in range(first, last + 1):
        start = max(terrain.x[index], row.start) if index else row.start
        stop = min(terrain.x[index + 1], row.stop) if index + 1 < len(terrain.x) else row.stop
        slope = f"{math.degrees(terrain.angle[index]) + 0.0:.1f}°".replace("-", "−")
        labels = [slope]
        rise, height = terrain.rises[index], terrain.z[index]
        begins_here = index > 0 and terrain.x[index] > row.start
        if begins_here:
            axes.plot([start] * 2, [row.low, height], color=SHADE, linewidth=0.5, linestyle=":", zorder=2)
        if rise and begins_here:
            step: dict[str, Any] = {"color": VERMILLION, "markersize": 4.5}
            axes.plot([start] * 2, [height - rise, height], linewidth=2.2, solid_capstyle="butt", zorder=3.5, **step)
            below = min(height - rise, height) - 0.045 / scale
            axes.plot(start, below, "^" if rise > 0 else "v", zorder=5, **step)
            labels.insert(0, f"{1000 * rise:+.3g} mm  {slope}".replace("-", "−"))
        for label in labels:
            room = _LETTER * (len(label) + 1) / scale
            if start >= text_free and stop - start >= room:
                axes.text(start + 0.04 / scale, row.low + 0.03 / scale, label, fontsize=7, color=SHADE, zorder=5)
                text_free = start + room
                break
