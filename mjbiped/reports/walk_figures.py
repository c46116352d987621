"""Interactive figures of a walk: over time, over the ground, and phase portraits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.plotting.style import BLACK, GROUND, PLANNED, SHADE
from mjbiped.plotting.walk import portraits
from mjbiped.records.frames import flat_samples
from mjbiped.records.record import Walk
from mjbiped.records.signals import SIGNALS, lines_of, without_zeros
from mjbiped.reports.page import LEGEND, Panel, Shown, include, line, plotted, small
from mjbiped.robots.robot import Array, Robot

MOST_SAMPLES = 6000
"""Greatest number of drawn samples; of a longer walk every second, third ... sample is drawn, and the ends of steps."""

_PANEL = 210  # height of a panel over time with its title, pixels
_GAP = 0.22  # of that height, between panels
_ABOVE, _BELOW = 60, 50  # margins for the legend and for the axis of time, pixels
_FIRST_VIEW = 5.0  # ground that is in view at first, m
_PORTRAIT_GAP = 0.08  # between phase portraits, of the figure's width
_ROOM = 0.05  # around a phase portrait, of its span
_BEYOND = 3.0  # ground that is drawn behind and ahead of the walk, m


def shown_samples(walk: Walk) -> NDArray[np.int64]:
    """Return the indices of the samples that are drawn."""
    step = flat_samples(walk)["step"]
    count = len(step)
    every = math.ceil(count / MOST_SAMPLES) if count else 1
    ends = np.flatnonzero(np.diff(step))
    return np.unique(np.concatenate([np.arange(0, count, every), ends, ends + 1, [count - 1]]).astype(np.int64))


def walk_figures(walk: Walk, *, video: bool = False) -> list[Shown]:
    """Draw the figures of a walk with samples.

    Args:
        walk: The record.
        video: Whether a video stands beside them.

    Raises:
        InputError: Plotly is not installed.
    """
    keep = shown_samples(walk)
    return [_over_ground(walk), _over_time(walk, keep, video), _phases(walk, keep)]


def _over_time(walk: Walk, keep: NDArray[np.int64], video: bool) -> Shown:
    """Draw the signals in panels over each other, with one axis of time."""
    time, every, panels, named = walk.samples["time"][keep], without_zeros(lines_of(walk)), list[Panel](), set[str]()
    breaks = np.flatnonzero(np.diff(walk.samples["stance"][keep])) + 1
    for lines in every:
        panel, traces = lines.panel, list[dict[str, Any]]()
        at = breaks if panel.by_legs else breaks[:0]
        for name, signal in lines.signals.items():
            values, symbol = lines.values[name][keep], f"{signal.symbol} = " if signal.symbol else ""
            traces.append(
                {
                    "x": small(np.insert(time, at, time[at])),
                    "y": small(np.insert(values, at, np.nan)),
                    "name": signal.name,
                    "legendgroup": signal.name,
                    "showlegend": signal.name not in named,
                    "line": line(name),
                    "hovertemplate": f"{symbol}%{{y:.4f}} {panel.unit}",
                }
            )
            named.add(signal.name)
        if panel.events:
            mark = {"symbol": "line-ns", "size": 8, "line": {"width": 1.6, "color": BLACK}}
            strikes = {"x": lines.events, "y": np.zeros_like(lines.events), "name": panel.events[0]}
            traces.append({**strikes, "mode": "markers", "marker": mark, "hoverinfo": "skip"})
        reach = include(np.array([*lines.values.values()]), panel.least)
        y = {"title": {"text": f"{panel.quantity} ({panel.unit})"}, **reach}
        ends = [float(time[0]), max(float(time[-1]), float(time[0]) + 1e-3)]
        x = {"title": {"text": "time (s)"}, "range": ends, "unifiedhovertitle": {"text": "t = %{x:.3f} s"}}
        panels.append(Panel(traces, x, y, f"<b>{panel.title}</b>"))
    thin = math.ceil(len(walk.samples["time"]) / MOST_SAMPLES)
    thinned = f" Of the {len(walk.samples['time'])} samples every {thin}th is drawn." if thin > 1 else ""
    click = " Click to take the video there." if video else ""
    note = (
        "Point at a moment: the line is the same moment in every panel, on the ground and in the phase portraits."
        f"{click} Drag to zoom, double-click to see all.{thinned}"
    )
    inner = len(panels) * _PANEL
    looks: dict[str, Any] = {
        "hovermode": "x unified",
        "hoversubplots": "axis",
        "margin": {"l": 70, "r": 20, "t": _ABOVE, "b": _BELOW},
    }
    legend = {**LEGEND, "y": 1.0 + 30 / inner}
    plot = plotted(panels, shared=True, grid={"ygap": _GAP}, legend=legend, **looks)
    return Shown("time", "Over time", note, plot, inner + _ABOVE + _BELOW)


def _over_ground(walk: Walk) -> Shown:
    """Draw the ground, the posture at each touchdown, and the posture of the current moment."""
    qpos, rows = walk.samples["qpos"], walk.touchdowns
    low, high = float(qpos[:, 0].min()) - _BEYOND, float(qpos[:, 0].max()) + _BEYOND
    x, z = walk.terrain.outline(low, high)
    bottom, start = float(z.min()) - 0.25, float(qpos[0, 0]) - 0.8
    area: dict[str, Any] = {"x": [x[0], *x, x[-1]], "y": [bottom, *z, bottom], "fill": "toself", "fillcolor": GROUND}
    silent = {"hoverinfo": "skip"}
    traces = [{**area, **silent, "line": {"color": SHADE, "width": 1}, "name": "ground"}]
    starts = np.concatenate([qpos[:1], rows["qpos"]])
    stance = np.concatenate([walk.samples["stance"][:1], rows["stance"]]).astype(np.int64)
    legs = ("swing", (stance + 1) % len(walk.robot.bodies.limbs)), ("stance", stance)
    for leg, side in legs:
        points_x, points_z = _sticks(walk.robot, starts, side)
        name, look = f"{leg} leg at touchdowns", line(f"q_{leg}", width=1)
        traces.append({"x": points_x, "y": points_z, "line": look, "opacity": 0.45, "name": name, **silent})
    for leg, side in legs:  # the page moves these two
        now_x, now_z = _sticks(walk.robot, qpos[:1], side[:1])
        colour = SIGNALS[f"q_{leg}"].colour
        look = {"mode": "lines+markers", "line": {"color": colour, "width": 5}, "marker": {"size": 7, "color": colour}}
        traces.append({"x": now_x[:-1], "y": now_z[:-1], "name": f"{leg} leg now", **look, **silent})
    step, place = "step %{customdata[0]}, %{customdata[1]:.3f} s", "x %{x:.3f} m, z %{y:.4f} m"
    footholds: dict[str, Any] = {
        "x": rows["x"],
        "y": rows["z"],
        "name": "footholds",
        "mode": "markers",
        "marker": {"size": 9, "color": SHADE, "symbol": "triangle-up"},
        "customdata": np.stack([np.arange(1, walk.steps + 1), rows["time"], np.degrees(rows["slope"])], axis=1),
        "hovertemplate": f"{step}<br>{place}<br>slope %{{customdata[2]:.2f}}°<extra></extra>",
    }
    x_axis = {"title": {"text": "x (m)"}, "range": [start, start + _FIRST_VIEW]}
    y_axis = {"title": {"text": "z (m)"}, "scaleanchor": "x", "range": [bottom, float(z.max()) + 1.2]}
    note = (
        "Thin: the legs at each touchdown. Thick: the legs at the moment that the other figures point at; the view "
        "follows them. Drag to move along, scroll to zoom, double-click to see all."
    )
    plot = plotted([Panel([*traces, footholds], x_axis, y_axis)], legend=LEGEND, dragmode="pan")
    return Shown("ground", "Over the ground", note, plot, 420)


def _sticks(robot: Robot, qpos: Array, side: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return one leg of several postures, each from hip to foot and a gap: x and z, m."""
    legs = robot.outline(qpos)[np.arange(len(qpos)), side]
    x, z = np.insert(legs, legs.shape[1], np.nan, axis=1).reshape(-1, 2).T
    return x, z


def _phases(walk: Walk, keep: NDArray[np.int64]) -> Shown:
    """Draw rate over angle of each leg, with the imitated gait and the planned transitions to it."""
    panels = list[Panel]()
    for part, (angle, rate, motion, planned, gait) in zip(walk.robot.angles, portraits(walk, keep), strict=True):
        gap = np.full((1, 2), np.nan)
        plans = [piece for curve in planned for piece in (curve, gap)]
        ring = {"size": 12, "color": "white", "line": {"width": 3, "color": angle.colour}}
        told = {"hoverinfo": "all", "hovertemplate": "%{x:.4f} rad, %{y:.4f} rad/s<extra></extra>"}
        curves: list[tuple[str, Array | None, dict[str, Any]]] = [
            (
                "re-planned reference",
                np.vstack(plans) if plans else None,
                {"line": {"color": PLANNED["color"], "width": 5}},
            ),
            (angle.name, motion, {"line": line(f"q_{part}", dash="solid", width=1), "showlegend": True, **told}),
            ("imitated gait", gait, {"line": line("slope", width=2)}),
            ("now", motion[:1], {"mode": "markers", "meta": "now", "showlegend": False, "marker": ring}),
        ]  # the page moves the last one
        usual = {"hoverinfo": "skip", "showlegend": not panels}
        traces = [
            {**usual, "x": small(curve[:, 0]), "y": small(curve[:, 1]), "name": name, "legendgroup": name, **look}
            for name, curve, look in curves
            if curve is not None
        ]
        x = {"title": {"text": f"angle {angle.symbol} (rad)"}, **include(motion[:, 0], room=_ROOM)}
        y = {"title": {"text": f"rate {rate.symbol} (rad/s)"}, **include(motion[:, 1], room=_ROOM)}
        panels.append(Panel(traces, x, y, f"<b>{angle.name.capitalize()}</b>"))
    looks: dict[str, Any] = {"margin": {"l": 70, "r": 20, "t": 70, "b": 50}, "legend": {**LEGEND, "y": 1.07}}
    plot = plotted(panels, columns=len(panels), grid={"xgap": _PORTRAIT_GAP * len(panels)}, **looks)
    return Shown("phases", "Phase portraits", "The ring is the moment that the other figures point at.", plot, 520)
