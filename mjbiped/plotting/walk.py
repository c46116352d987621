"""Figure of a walk: time lapse over the ground as in the paper's Fig. 4(a), signals over time, phase portraits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure, FigureBase
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from mjbiped.errors import RenderError
from mjbiped.plotting import DEFAULT_WIDTH, WIDTHS, style, width
from mjbiped.plotting.panels import (
    draw_over_time,
    draw_paths,
    head,
    labelled,
    legend_above,
    legend_below,
    plain,
    portraits,
    titled,
    wrapped,
)
from mjbiped.plotting.style import C_MT, GUIDE, SHADE, VERMILLION, drawn, note_at
from mjbiped.records.record import Walk
from mjbiped.records.signals import PANELS, Values, check_panels, lines_of, without_zeros
from mjbiped.robots.in_space import InSpace
from mjbiped.terrain.terrain import Terrain

_LINES = 3  # greatest number of title lines for the terrain and controller, whose names may have any length
_ROW = 8.0  # length of ground in a row as wide as a page, m, unless there are too many rows
_MOST_ROWS = 6
_SMALLEST_ROW = 0.5  # least share of that length, for walks of few steps
_BESIDE = 0.75  # room beside a row for the labels of its axis, inches
_BELOW = 0.24  # room for texts under the lowest ground of a row, inches
_ABOVE = 0.08  # room over the highest hip, m
_LETTER = 0.055  # width of a small letter, inches
_BETWEEN_ROWS = 0.25  # inches


def plot_walk(walk: Walk, path: str | Path | None = None, *, panels: Sequence[str] | None = None) -> Figure:
    """Draw a walk in the manner of the paper's Fig. 4.

    Time lapse over the ground, in rows if it is long, with x and z in one scale; slopes and steps are written under
    the ground. The paths of hip and feet of a robot in space, seen from above. Signals of `mjbiped.records.signals`
    over time, without those that are zero throughout: slope and its estimate, torques, the centre of pressure that the
    ankle's torque requires, up to half a leg; with knees also torque and flexion of the swing knee, and the torque that
    holds the stance knee, negative where its stop bears it. Phase portraits of all angles, with the limit cycle of the
    gait that the controller imitates and the re-planned transitions to it.

    For a journal's column: `with mjbiped.plotting.figure_width("single"): plot_walk(walk, "walk.pdf")`. The width
    "slide" makes a figure of 16:9, with time lapse and torques unless other panels are named.

    Args:
        walk: Any record, including a fall in the first step.
        path: File to write as well, `.png`, `.pdf` or `.svg`.
        panels: Names of its panels, of `mjbiped.records.signals.FIGURE`, as ("torque", "phase"); unless given, those
            above.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix, or there is no such panel; nothing has been drawn then.
        RenderError: The record holds no samples, or the file cannot be written.
    """
    rows, letters, size, angles = rows_of(walk), iter(ascii_lowercase), width(), len(walk.robot.angles)
    named = check_panels(size.panels if panels is None else panels)
    chosen = [PANELS.get(name) for name in named]
    lines = [each for each in lines_of(walk) if (each.panel in chosen if named else each.panel.in_figure)]
    lines = without_zeros(lines) if panels is None else lines
    across = min(angles, max(2, size.beside(angles)))
    narrow = size.beside(2) == 1  # titles stand over legends, labels take two lines, panels are smaller
    margin, history, portrait = (0.8, 1.15, 2.0) if narrow else (0.45, 1.65, 3.3)
    parts: list[tuple[float, Callable[[FigureBase], None]]] = []  # heights, inches, and what is drawn there

    def draw_lapse(part: FigureBase) -> None:
        grid = _draw_rows(part, walk, rows)
        titled(grid[0], next(letters), "Time lapse")
        labelled(grid[-1], "x (m);  under the ground: step height and slope, positive downhill")
        legs = (style.BLUE, 1.8, "stance leg"), (style.ORANGE, 1.2, "swing leg")
        legend_above(grid[0], handles=[Line2D([], [], color=c, linewidth=thick, label=leg) for c, thick, leg in legs])

    def draw_above(part: FigureBase) -> None:
        axes = part.subplots()
        draw_paths(axes, walk)
        axes.set_xlim(rows[0].start, rows[-1].stop)
        titled(axes, next(letters), "Paths seen from above, the left side up")
        labelled(axes, "x (m);  y is drawn larger than x")
        legend_above(axes)

    def draw_histories(part: FigureBase) -> None:
        grid = part.subplots(len(lines), 1, sharex=True, squeeze=False)[:, 0]
        for axes, each in zip(grid, lines, strict=True):
            draw_over_time(axes, walk, next(letters), each)
        grid[-1].set_xlabel("time (s)")

    if "lapse" in named or not named:
        parts.append((_height(rows) + margin, draw_lapse))
    if isinstance(walk.robot, InSpace) and ("above" in named or not named):
        parts.append((1.5 * history, draw_above))  # room for y beside a legend of two lines
    if lines:
        parts.append((history * len(lines), draw_histories))
    if "phase" in named or not named:
        height = portrait * math.ceil(angles / across)
        parts.append((height, lambda part: _draw_phases(part, walk, letters, across)))
    with drawn(path) as figure:
        heights = [height for height, _ in parts]
        natural = sum(heights) + 0.1 + head(figure, _title(walk))
        figure.set_figheight(size.height or natural)
        places: Any = figure.subfigures(len(parts), 1, squeeze=False, height_ratios=heights)
        for place, (_, draw) in zip(places[:, 0], parts, strict=True):
            draw(place)
    return figure


def time_lapse_picture(walk: Walk) -> bytes:
    """Draw the time lapse of a walk as a PNG file's bytes, for a notebook.

    Raises:
        RenderError: The record holds no samples.
    """
    rows = rows_of(walk)
    with drawn(None) as figure:
        figure.set_figheight(_height(rows) + _BETWEEN_ROWS)
        _draw_rows(figure, walk, rows)[-1].set_xlabel("x (m)")
    return style.figure_png(figure)


def _title(walk: Walk) -> str:
    """Controller, ground and result of a walk."""
    steps = f"{walk.steps} step{'' if walk.steps == 1 else 's'}"
    cost = f"{walk.cost_of_transport:.4f}" if math.isfinite(walk.cost_of_transport) else "none"
    who = f"{walk.settings['controller']['name']} on {walk.terrain.caption}, {walk.settings['engine']} engine"
    (peak, joint), *others = zip(walk.peak_torque, walk.robot.joints, strict=True)
    peaks = [f"{peak:.2f} ({joint})", *(f"{peak:.2f}\u00a0({joint})" for peak, joint in others)]
    what = (
        f"{walk.outcome} after {steps}, {walk.end[0]:.2f}\u00a0s and {walk.distance:.2f}\u00a0m;  {C_MT}\u00a0{cost};  "
        f"peak torque {', '.join(peaks)}\u00a0N\u00a0m"
    )
    return f"{plain(wrapped(who, lines=_LINES))}\n{wrapped(what)}"


def _draw_phases(figure: FigureBase, walk: Walk, letters: Iterator[str], across: int) -> None:
    """Draw a panel per angle: a line per step, without the jumps between steps, over the re-planned reference."""
    every = list(portraits(walk))
    grid = figure.subplots(math.ceil(len(every) / across), across, squeeze=False).ravel()
    for unused in grid[len(every) :]:
        unused.set_axis_off()
    entries: dict[str, Any] = {}
    for axes, (angle, rate, motion, plans, gait) in zip(grid, every, strict=False):
        axes.plot(*motion.T, color=angle.colour, linewidth=0.8, label=angle.name)
        for planned in plans:
            axes.plot(*planned.T, label="re-planned reference", **style.PLANNED)
        if gait is not None:
            axes.plot(*gait.T, label="imitated gait", **style.TRUTH, linewidth=1.4)
        axes.plot(*motion[0], "k.", markersize=6, label="start")
        axes.set(xlabel=f"angle {angle.symbol} (rad)", ylabel=f"rate {rate.symbol} (rad/s)")
        titled(axes, next(letters), f"Phase portrait, {angle.name}")
        handles, names = axes.get_legend_handles_labels()
        entries |= dict(zip(names, handles, strict=True))
    legs = [portrait.angle.name for portrait in every]
    order = sorted(entries, key=lambda entry: entry not in legs)
    legend_below(figure, [entries[entry] for entry in order], order)


class Row(NamedTuple):
    """Piece of the ground on one line of the figure.

    Attributes:
        start: First place, m.
        stop: Last place, m.
        low: Lower end of the picture, m.
        high: Upper end of the picture, m.
        scale: Of x and z on paper, inches per m.
    """

    start: float
    stop: float
    low: float
    high: float
    scale: float


def _height(rows: list[Row]) -> float:
    """Height of rows on paper, inches."""
    return sum((row.high - row.low) * row.scale + _BETWEEN_ROWS for row in rows)


def rows_of(walk: Walk) -> list[Row]:
    """Split the ground that a walk covered into rows of equal length.

    Raises:
        RenderError: The record holds no samples.
    """
    if not len(walk.samples["time"]):
        raise RenderError("the record holds no samples: there is nothing to draw")
    qpos, wide = walk.samples["qpos"], width().inches - _BESIDE
    limbs = walk.robot.limbs(qpos)
    reached, tops = limbs[..., 0], limbs[..., 1].max(axis=(1, 2))
    start, stop = float(reached.min()) - 0.15, float(reached.max()) + 0.15
    # half as wide, a row holds 0.7 times the ground, so that the robot is 0.7 times as large
    usual = _ROW * math.sqrt(wide / (WIDTHS[DEFAULT_WIDTH].inches - _BESIDE))
    count = min(_MOST_ROWS, max(1, math.ceil((stop - start) / usual)))
    length = max((stop - start) / count, _SMALLEST_ROW * usual)
    start -= max(0.0, length - (stop - start)) / 2  # a short walk stands in the middle
    rows, scale = [], wide / length
    for first in (start + length * np.arange(count)).tolist():
        _, z = walk.terrain.outline(first, first + length)
        inside = (qpos[:, 0] >= first) & (qpos[:, 0] <= first + length)
        # at most two legs over the ground: where a robot that diverges gets to, nothing is drawn
        most = float(z.max()) + 2.0 * walk.robot.leg_length
        high = max(float(z.max()), min(float(tops[inside].max(initial=-math.inf)), most)) + _ABOVE
        rows.append(Row(first, first + length, float(z.min()) - _BELOW / scale, high, scale))
    return rows


def _draw_rows(figure: FigureBase, walk: Walk, rows: list[Row]) -> list[Axes]:
    """Draw the time lapse, a panel for each row."""
    heights = [row.high - row.low for row in rows]
    grid: list[Axes] = figure.subplots(len(rows), 1, squeeze=False, height_ratios=heights)[:, 0].tolist()
    for row, axes in zip(rows, grid, strict=True):
        draw_row(axes, walk, row)
    return grid


def draw_row(axes: Axes, walk: Walk, row: Row) -> None:
    """Draw the ground of a row and the stick figures whose hip is over it.

    Stance legs are solid, dark and thick, swing legs lighter and thin; the postures of touchdowns are strong, those
    between them faint.
    """
    axes.set(xlim=(row.start, row.stop), ylim=(row.low, row.high), ylabel="z (m)")
    axes.set_aspect("equal", adjustable="box")
    ticks = min(9, int(2.0 * row.scale * (row.stop - row.start)))
    axes.xaxis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))
    _draw_ground(axes, walk.terrain, row)
    samples, touchdowns, qpos = walk.samples, walk.touchdowns, walk.samples["qpos"]
    axes.plot(qpos[:, 0], qpos[:, 1], color=GUIDE, linewidth=0.6, zorder=2)
    thick = min(1.6, max(0.5, 1.3 * row.scale))
    # at equal times within each step; fewer where the figure would get too dense
    bounds = np.unique([samples["time"][0], *touchdowns["time"], samples["time"][-1]])
    parts = 4 if row.scale > 1.0 else 2 if row.scale > 0.6 else 1
    inner = [bounds[:-1] + np.diff(bounds) * part / parts for part in range(1, parts)]
    between = np.sort(np.concatenate([bounds[:1], *inner]))
    stance = samples["stance"][np.searchsorted(samples["time"], between, side="right") - 1]
    postures = np.stack([np.interp(between, samples["time"], column) for column in qpos.T], axis=1)

    def draw_sticks(qpos: Values, stance: NDArray[Any], thick: float, alpha: float, color: str = "") -> None:
        """Draw postures as lines from the hip to the feet, the swing legs under the stance legs."""
        inside = (qpos[:, 0] >= row.start) & (qpos[:, 0] <= row.stop)
        limbs = walk.robot.outline(qpos[inside])
        stands = np.arange(limbs.shape[1]) == stance[inside, None]
        for is_stance, leg, share in ((False, style.ORANGE, 0.7), (True, style.BLUE, 1.0)):
            look: dict[str, Any] = {"colors": color or leg, "linewidths": share * thick, "capstyle": "round"}
            layer = 4 + 2 * (alpha == 1.0) + is_stance
            lines = LineCollection(list(limbs[stands == is_stance]), zorder=layer, alpha=alpha, **look)
            axes.add_collection(lines, autolim=False)
        hip: dict[str, Any] = {"color": color or SHADE, "markersize": 1.8 * thick, "markeredgewidth": 0, "zorder": 8}
        axes.plot(*qpos[inside, :2].T, "o", alpha=alpha, **hip)

    draw_sticks(postures, stance, 0.55 * thick, 0.35)
    # at a touchdown the old stance leg still is the one that stands
    draw_sticks(touchdowns["qpos"], (touchdowns["stance"] - 1) % len(walk.robot.bodies.limbs), thick, 1.0)
    if walk.outcome != "finished" and row.start <= qpos[-1, 0] <= row.stop:
        draw_sticks(qpos[-1:], samples["stance"][-1:], 1.3 * thick, 1.0, VERMILLION)
        x, z, *_ = qpos[-1].tolist()
        shift, side = (-5, "right") if x > row.start + 0.8 * (row.stop - row.start) else (5, "left")
        bold = {"fontsize": width().font, "color": VERMILLION, "weight": "bold", "zorder": 8}
        note_at(axes, walk.outcome, x, z, (shift, 0), xycoords="data", ha=side, va="center", **bold)


def _draw_ground(axes: Axes, terrain: Terrain, row: Row) -> None:
    """Fill the ground, mark changes of slope and steps, and label both where there is room."""
    places, heights = terrain.outline(row.start, row.stop)
    axes.fill_between(places, heights, row.low, color=style.GROUND, linewidth=0, zorder=1)
    axes.plot(places, heights, color=SHADE, linewidth=0.9, zorder=3)
    if row.start < terrain.end < row.stop:
        axes.axvline(terrain.end, color=VERMILLION, linestyle=":", linewidth=1.0)
    text_free, inch = row.start, 1.0 / row.scale
    for index in range(terrain.segment_at(row.start), terrain.segment_at(row.stop) + 1):
        begins_here = index > 0 and terrain.x[index] > row.start
        start = terrain.x[index] if begins_here else row.start
        stop = min(terrain.x[index + 1], row.stop) if index + 1 < len(terrain.x) else row.stop
        labels = [f"{math.degrees(terrain.angle[index]) + 0.0:.1f}°"] if terrain.surface is None else []
        rise, height = terrain.rises[index], terrain.z[index]
        if begins_here:
            axes.plot([start] * 2, [row.low, height], color=SHADE, linewidth=0.5, linestyle=":", zorder=2)
        if rise and begins_here:
            step: dict[str, Any] = {"color": VERMILLION, "markersize": 4.5}
            axes.plot([start] * 2, [height - rise, height], linewidth=2.2, solid_capstyle="butt", zorder=3.5, **step)
            axes.plot(start, min(height - rise, height) - 0.045 * inch, "^" if rise > 0 else "v", zorder=5, **step)
            labels.insert(0, f"{1000 * rise:+.3g} mm  {labels[0]}")
        for label in labels:
            room = _LETTER * (len(label) + 1) * inch
            if start >= text_free and stop - start >= room:
                x, low, text = start + 0.04 * inch, row.low + 0.03 * inch, label.replace("-", "−")
                axes.text(x, low, text, fontsize=7, color=SHADE, zorder=5)
                text_free = start + room
                break
