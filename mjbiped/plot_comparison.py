"""The figure of a comparison: both engines' curves over each other, and their difference under them."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mjbiped import measures
from mjbiped.compare import torque_differences
from mjbiped.errors import RenderError
from mjbiped.plot_style import (
    ANKLE,
    BLUE,
    GUIDE,
    HIP,
    ORANGE,
    TRUTH,
    VERMILLION,
    check_path,
    new_figure,
    save_figure,
    styled,
)

if TYPE_CHECKING:
    from mjbiped.compare import Comparison

_MUJOCO: dict[str, Any] = {"color": BLUE, "linestyle": "-", "linewidth": 2.4, "alpha": 0.75, "label": "MuJoCo"}
_HYBRID: dict[str, Any] = {"color": ORANGE, "linestyle": (0, (3, 1.5)), "linewidth": 1.1, "label": "hybrid"}
_LETTERS_PER_LINE = 118


def plot_comparison(comparison: Comparison, path: str | Path | None = None) -> Figure:
    """Draw a comparison.

    (a) Ankle and hip torque over time, and their differences at equal times since the touchdown. (b) Step lengths and
    (c) the slope estimate with the true slope, over the distance, each with its difference. A line marks where the
    walks part.

    Args:
        comparison: As `mjbiped.compare` makes it; a fall in the first step included.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: The path has another suffix; nothing has been drawn then.
        RenderError: A record holds no samples, or the file cannot be written.
    """
    path = check_path(path)
    if not all(len(walk.samples["time"]) for walk in (comparison.mujoco, comparison.hybrid)):
        raise RenderError("a record holds no samples: there is nothing to draw")
    with styled():
        title = _title(comparison)
        figure = new_figure(10.2 + 0.17 * title.count("\n"))
        figure.suptitle(title, fontsize=9.0, x=0.01, ha="left", linespacing=1.4, parse_math=False)
        parts: Any = figure.subfigures(2, 1, height_ratios=(5.0, 5.2))
        torques = parts[0].subplots(3, 1, sharex=True, height_ratios=(1.5, 1.5, 1.0))
        _draw_torques(torques, comparison)
        grounds = parts[1].subplots(4, 1, sharex=True, height_ratios=(1.5, 1.0, 1.5, 1.0))
        _draw_step_lengths(grounds[0], grounds[1], comparison)
        _draw_slopes(grounds[2], grounds[3], comparison)
        _mark_parting(torques, grounds, comparison)
        for part in parts:
            part.align_ylabels()
    if path is not None:
        save_figure(figure, path)
    return figure


def _title(comparison: Comparison) -> str:
    """Who walked where, what it cost in either engine, and whether they agree."""
    name = comparison.mujoco.settings["controller"]["name"]
    lines = [f"{name} on {comparison.mujoco.terrain.caption}, in both engines", comparison.verdict]
    return "\n".join(part for line in lines for part in textwrap.wrap(line, _LETTERS_PER_LINE))


def _draw_torques(grid: Any, comparison: Comparison) -> None:
    for joint, (axes, name) in enumerate(zip(grid[:2], ("ankle", "hip"), strict=True)):
        for walk, style in ((comparison.mujoco, _MUJOCO), (comparison.hybrid, _HYBRID)):
            axes.plot(walk.samples["time"], walk.samples["torque"][:, joint], **style)
        axes.set(ylabel=f"{name} (N m)")
    grid[0].set_title("(a) Joint torque")
    _legend(grid[0])
    time, difference = torque_differences(comparison)
    for joint, (name, look) in enumerate((("ankle", ANKLE), ("hip", HIP))):
        grid[2].plot(time, difference[:, joint], label=name, linewidth=0.9, **look)
    grid[2].set(ylabel="Δ (N m)", xlabel="time (s);  Δ = MuJoCo − hybrid at equal times since the touchdown")
    _zero_line(grid[2])
    _legend(grid[2])
    last = max(walk.samples["time"][-1] for walk in (comparison.mujoco, comparison.hybrid))
    grid[2].set_xlim(0.0, max(float(last), 1e-3))


def _draw_step_lengths(axes: Axes, under: Axes, comparison: Comparison) -> None:
    for walk, style in ((comparison.mujoco, _MUJOCO), (comparison.hybrid, _HYBRID)):
        axes.plot(walk.touchdowns["x"], measures.step_lengths(walk), marker="o", markersize=3.0, **style)
    axes.set(ylabel="length (m)")
    axes.set_title("(b) Step length")
    _legend(axes)
    n = len(comparison.touchdowns["x"])
    lengths = [measures.step_lengths(walk)[:n] for walk in (comparison.mujoco, comparison.hybrid)]
    _draw_difference(under, comparison, 1e3 * (lengths[0] - lengths[1]), "mm")


def _draw_slopes(axes: Axes, under: Axes, comparison: Comparison) -> None:
    for walk, style in ((comparison.mujoco, _MUJOCO), (comparison.hybrid, _HYBRID)):
        x, estimate = walk.touchdowns["x"], np.degrees(walk.touchdowns["slope_estimate"])
        axes.plot(x, estimate, marker="o", markersize=3.0, **style)
    terrain = comparison.mujoco.terrain
    reached = max([0.4, *(float(x) for w in (comparison.mujoco, comparison.hybrid) for x in w.touchdowns["x"])])
    places = np.linspace(0.0, reached, 2001)
    axes.plot(places, np.degrees(terrain.slope(places)), label="ground", zorder=1, linewidth=1.0, **TRUTH)
    axes.set(ylabel="slope (°)")
    axes.set_title("(c) Slope estimate at touchdown, and slope of the ground")
    low, high = axes.get_ylim()
    if high - low < 1.0:  # rounding is no news
        axes.set_ylim((low + high) / 2 - 0.5, (low + high) / 2 + 0.5)
    _legend(axes)
    _draw_difference(under, comparison, np.degrees(comparison.touchdowns["slope_estimate"]), "°")
    under.set_xlabel("x of the touchdown (m);  Δ = MuJoCo − hybrid")
    under.set_xlim(0.0, 1.02 * reached)


def _draw_difference(axes: Axes, comparison: Comparison, difference: Any, unit: str) -> None:
    """A row of differences at the touchdowns."""
    n = len(difference)
    axes.plot(comparison.mujoco.touchdowns["x"][:n], difference, "k.-", linewidth=0.8, markersize=4.0)
    axes.set(ylabel=f"Δ ({unit})")
    _zero_line(axes)


def _zero_line(axes: Axes) -> None:
    axes.axhline(0.0, color=GUIDE, linewidth=0.5, zorder=0)


def _legend(axes: Axes) -> None:
    axes.legend(loc="lower right", ncols=3, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)


def _mark_parting(torques: Any, grounds: Any, comparison: Comparison) -> None:
    """A line where the walks part."""
    parting = comparison.parting
    if parting is None:
        return
    k = parting.touchdown - 1
    places = [walk.touchdowns["x"] for walk in (comparison.mujoco, comparison.hybrid)]
    x = next((float(column[k]) for column in places if k < len(column)), parting.x)
    for axes, place in (*((axes, parting.time) for axes in torques), *((axes, x) for axes in grounds)):
        axes.axvline(place, color=VERMILLION, linewidth=0.9, linestyle=":", zorder=0)
    torques[0].annotate(
        "they part",
        (parting.time, 1.0),
        (3, -2),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        color=VERMILLION,
        fontsize=8,
        va="top",
    )
