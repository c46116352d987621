"""The interactive figures of a walk: over time, over the ground, and the phase portraits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.analysis.replay import drawn_gait, drawn_transitions
from mjbiped.plotting.style import BLACK, GROUND, PLANNED, SHADE
from mjbiped.plotting.timelapse import outline
from mjbiped.records.frames import flat_samples
from mjbiped.records.record import Walk
from mjbiped.records.signals import PANELS, SIGNALS, knee_strikes, panels_of, signals_of, values_of
from mjbiped.reports.figures import AXIS, HEADING, Shown, layout, line, small
from mjbiped.robots.robot import Array, Robot
from mjbiped.utils.extras import needed

MOST_SAMPLES = 6000
"""Drawn of a walk: of a longer one every second, third ... sample, and those at the steps' ends."""

_PANEL_HEIGHT = 165  # pixels
_PANEL_GAP = 45  # below a panel, for the next one's title, pixels
_ABOVE, _BELOW = 60, 50  # margins for the legend and for the axis of time, pixels
_FIRST_VIEW = 5.0  # ground that is in view at first, m
_POINTS = 200  # of a limit cycle
_PORTRAIT_GAP = 0.08  # between phase portraits, of the figure's width
_BEYOND = 3.0  # ground that is drawn behind and ahead of the walk, m
_MOMENT = {"text": "t = %{x:.3f} s"}


def shown_samples(walk: Walk) -> NDArray[np.int64]:
    """Indices of the samples that are drawn."""
    step = flat_samples(walk)["step"]
    count = len(step)
    every = math.ceil(count / MOST_SAMPLES) if count else 1
    ends = np.flatnonzero(np.diff(step))
    return np.unique(np.concatenate([np.arange(0, count, every), ends, ends + 1, [count - 1]]).astype(np.int64))


def walk_figures(walk: Walk, *, video: bool = False) -> list[Shown]:
    """The figures of a walk with samples.

    Args:
        walk: The record.
        video: Whether a video stands beside them.

    Raises:
        InputError: Plotly is not installed.
    """
    graphs = needed("plotly.graph_objects", "report", "a report")
    keep = shown_samples(walk)
    return [_over_ground(graphs, walk), _over_time(graphs, walk, keep, video), _phases(graphs, walk, keep)]


def _over_time(graphs: Any, walk: Walk, keep: NDArray[np.int64], video: bool) -> Shown:
    """A panel over the other, with one axis of time."""
    samples = walk.samples
    breaks = np.flatnonzero(np.diff(flat_samples(walk)["step"][keep])) + 1
    time = samples["time"][keep]
    panels = dict(panels_of(type(walk.robot)))
    height = len(panels) * (_PANEL_HEIGHT + _PANEL_GAP) - _PANEL_GAP
    figure = graphs.Figure()
    axes: dict[str, Any] = {}
    named: set[str] = set()
    for number, (panel, signals) in enumerate(panels.items()):
        about, place = PANELS[panel], str(number + 1) if number else ""
        shown = {name: values_of(walk, name)[keep] for name in signals}
        shown = {name: values for name, values in shown.items() if np.isfinite(values).any()}  # some make no estimate
        for name, values in shown.items():
            signal, x, y = signals[name], time, values
            if about.by_legs:
                x, y = np.insert(time, breaks, time[breaks]), np.insert(values, breaks, np.nan)
            symbol = f"{signal.symbol} = " if signal.symbol else ""
            figure.add_scatter(
                x=small(x),
                y=small(y),
                name=signal.name,
                legendgroup=signal.name,
                showlegend=signal.name not in named,
                mode="lines",
                line=line(name),
                yaxis=f"y{place}",
                hovertemplate=f"{symbol}%{{y:.4f}} {about.unit}",
            )
            named.add(signal.name)
        if panel == "flexion":
            strikes = knee_strikes(walk)
            figure.add_scatter(
                x=strikes, y=np.zeros_like(strikes), name="knee strike", mode="markers", yaxis=f"y{place}",
                marker={"symbol": "line-ns", "size": 8, "line": {"width": 1.6, "color": BLACK}}, hoverinfo="skip",
            )  # fmt: skip
        top = 1.0 - number * (_PANEL_HEIGHT + _PANEL_GAP) / height
        axes[f"yaxis{place}"] = {
            **AXIS,
            "domain": [max(0.0, top - _PANEL_HEIGHT / height), top],
            "title": {"text": f"{about.quantity} ({about.unit})"},
            "autorangeoptions": {"include": _widened([*shown.values()], about.least)},
            "anchor": "x",
        }
        figure.add_annotation(text=f"<b>{about.title}</b>", x=0.0, y=top, xref="paper", yref="paper", **HEADING)
    figure.update_layout(
        layout(
            **axes,
            xaxis={
                **AXIS,
                "title": {"text": "time (s)"},
                "range": [float(time[0]), max(float(time[-1]), float(time[0]) + 1e-3)],
                "anchor": f"y{len(panels)}",
                "unifiedhovertitle": _MOMENT,
            },
            hovermode="x unified",
            hoversubplots="axis",
            legend={"orientation": "h", "yanchor": "bottom", "y": 1.0 + 30 / height, "xanchor": "left", "x": 0.0},
            margin={"l": 70, "r": 20, "t": _ABOVE, "b": _BELOW},
        )
    )
    every = math.ceil(len(samples["time"]) / MOST_SAMPLES)
    thinned = f" Of the {len(samples['time'])} samples every {every}th is drawn." if every > 1 else ""
    click = " Click to take the video there." if video else ""
    note = (
        "Point at a moment: the line is the same moment in every panel, on the ground and in the phase portraits."
        f"{click} Drag to zoom, double-click to see all.{thinned}"
    )
    return Shown("time", "Over time", note, figure, height + _ABOVE + _BELOW)


def _widened(values: list[Array], least: float) -> list[float]:
    """What an axis shows at least: nothing in particular, or so much about the middle of what is drawn."""
    known = np.concatenate([array[np.isfinite(array)] for array in values]) if values and least else np.empty(0)
    if not known.size:
        return []
    middle = float(known.min() + known.max()) / 2.0
    return [middle - least / 2.0, middle + least / 2.0]


def _over_ground(graphs: Any, walk: Walk) -> Shown:
    """The ground, the posture at each touchdown, and the posture of the moment."""
    qpos = walk.samples["qpos"]
    low, high = float(qpos[:, 0].min()) - _BEYOND, float(qpos[:, 0].max()) + _BEYOND
    x, z = outline(walk.terrain, low, high)
    bottom = float(z.min()) - 0.25
    figure = graphs.Figure()
    figure.add_scatter(
        x=np.concatenate([[x[0]], x, [x[-1]]]),
        y=np.concatenate([[bottom], z, [bottom]]),
        fill="toself",
        fillcolor=GROUND,
        mode="lines",
        line={"color": SHADE, "width": 1},
        name="ground",
        hoverinfo="skip",
    )
    rows = walk.touchdowns
    starts = np.concatenate([qpos[:1], rows["qpos"]])
    stance = np.concatenate([walk.samples["stance"][:1], rows["stance"]])
    for leg, side in (("swing", 1 - stance), ("stance", stance)):
        points_x, points_z = _sticks(walk.robot, starts, side)
        figure.add_scatter(
            x=points_x, y=points_z, mode="lines", line=line(f"q_{leg}", width=1), opacity=0.45,
            name=f"{leg} leg at touchdowns", hoverinfo="skip",
        )  # fmt: skip
    for leg, side in (("swing", 1 - stance[:1]), ("stance", stance[:1])):  # the page moves these two
        now_x, now_z = _sticks(walk.robot, qpos[:1], side)
        colour = SIGNALS[f"q_{leg}"].colour
        figure.add_scatter(
            x=now_x[:-1], y=now_z[:-1], mode="lines+markers", line={"color": colour, "width": 5},
            marker={"size": 7, "color": colour}, name=f"{leg} leg now", hoverinfo="skip",
        )  # fmt: skip
    figure.add_scatter(
        x=rows["x"],
        y=rows["z"],
        mode="markers",
        marker={"size": 9, "color": SHADE, "symbol": "triangle-up"},
        name="footholds",
        customdata=np.stack([np.arange(1, walk.steps + 1), rows["time"], np.degrees(rows["slope"])], axis=1),
        hovertemplate="step %{customdata[0]}, %{customdata[1]:.3f} s<br>x %{x:.3f} m, z %{y:.4f} m<br>"
        "slope %{customdata[2]:.2f}°<extra></extra>",
    )
    start = float(qpos[0, 0]) - 0.8
    figure.update_layout(
        layout(
            xaxis={**AXIS, "title": {"text": "x (m)"}, "range": [start, start + _FIRST_VIEW]},
            yaxis={**AXIS, "title": {"text": "z (m)"}, "scaleanchor": "x", "range": [bottom, float(z.max()) + 1.2]},
            dragmode="pan",
        )
    )
    return Shown(
        "ground",
        "Over the ground",
        "Thin: the legs at each touchdown. Thick: the legs at the moment that the other figures point at; the view "
        "follows them. Drag to move along, scroll to zoom, double-click to see all.",
        figure,
        420,
    )


def _sticks(robot: Robot, qpos: Array, side: NDArray[Any]) -> tuple[Array, Array]:
    """One leg of several postures, each from hip to foot and a gap: x and z, m."""
    legs = robot.limbs(qpos)[np.arange(len(qpos)), np.asarray(side, dtype=np.int64)]
    x, z = np.insert(legs, legs.shape[1], np.nan, axis=1).reshape(-1, 2).T
    return x, z


def _phases(graphs: Any, walk: Walk, keep: NDArray[np.int64]) -> Shown:
    """Rate over each angle, with the gait that is imitated and the transitions that were planned to it."""
    breaks = np.flatnonzero(np.diff(flat_samples(walk)["step"][keep])) + 1
    cycle, planned, signals = _imitated(walk), drawn_transitions(walk), signals_of(type(walk.robot))
    angles = walk.robot.angles
    wide = (1.0 - _PORTRAIT_GAP * (len(angles) - 1)) / len(angles)
    figure = graphs.Figure()
    axes: dict[str, Any] = {}
    for k, part in enumerate(angles):
        angle, rate, number = signals[f"q_{part}"], signals[f"dq_{part}"], str(k + 1) if k else ""
        place = {"xaxis": f"x{number}", "yaxis": f"y{number}"}
        if planned:
            gap = np.full((1, 2 * len(angles)), np.nan)
            curves = np.concatenate([part for curve in planned for part in (curve, gap)])
            figure.add_scatter(
                x=small(curves[:, k]), y=small(curves[:, len(angles) + k]), mode="lines", name="re-planned reference",
                line={"color": PLANNED["color"], "width": 5}, legendgroup="planned", showlegend=not k,
                hoverinfo="skip", **place,
            )  # fmt: skip
        q, dq = (walk.samples[name][keep][:, k] for name in ("q", "dq"))
        figure.add_scatter(
            x=small(np.insert(q, breaks, np.nan)), y=small(np.insert(dq, breaks, np.nan)), mode="lines",
            name=angle.name, line=line(f"q_{part}", dash="solid", width=1),
            hovertemplate="%{x:.4f} rad, %{y:.4f} rad/s<extra></extra>", **place,
        )  # fmt: skip
        if cycle is not None:
            figure.add_scatter(
                x=small(cycle[0][:, k]), y=small(cycle[1][:, k]), mode="lines", name="imitated gait",
                line=line("slope", width=2), legendgroup="gait", showlegend=not k, hoverinfo="skip", **place,
            )  # fmt: skip
        figure.add_scatter(  # the page moves it
            x=q[:1], y=dq[:1], mode="markers", name="now", meta="now", showlegend=False, hoverinfo="skip",
            marker={"size": 12, "color": "white", "line": {"width": 3, "color": angle.colour}}, **place,
        )  # fmt: skip
        left = k * (wide + _PORTRAIT_GAP)
        figure.add_annotation(
            text=f"<b>{angle.name.capitalize()}</b>", x=left, y=1.0, xref="paper", yref="paper", **HEADING
        )
        axes[f"xaxis{number}"] = {
            **AXIS,
            "title": {"text": f"angle {angle.symbol} (rad)"},
            "domain": [left, left + wide],
            "anchor": f"y{number}",
            "autorangeoptions": {"include": _with_room(q)},
        }
        axes[f"yaxis{number}"] = {
            **AXIS,
            "title": {"text": f"rate {rate.symbol} (rad/s)"},
            "anchor": f"x{number}",
            "autorangeoptions": {"include": _with_room(dq)},
        }
    figure.update_layout(
        layout(
            **axes,
            legend={"orientation": "h", "yanchor": "bottom", "y": 1.07, "xanchor": "left", "x": 0.0},
            margin={"l": 70, "r": 20, "t": 70, "b": 50},
        )
    )
    return Shown("phases", "Phase portraits", "The ring is the moment that the other figures point at.", figure, 520)


def _with_room(values: Array) -> list[float]:
    """What an axis shows at least: these values, and a twentieth of their span on both sides."""
    low, high = float(values.min()), float(values.max())
    room = 0.05 * (high - low)
    return [low - room, high + room]


def _imitated(walk: Walk) -> tuple[Array, Array] | None:
    """The limit cycle of the gait that was imitated: angles and rates, shape (points, angles); None without one."""
    gait = drawn_gait(walk)
    if gait is None:
        return None
    q, dq, _ = gait.reference(np.linspace(0.0, gait.period, _POINTS))
    return q, dq
