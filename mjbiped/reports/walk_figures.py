"""The interactive figures of a walk: over time, over the ground, and the phase portraits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.analysis.replay import drawn_gait, drawn_transitions
from mjbiped.gaits.gait import Gait
from mjbiped.plotting.style import GROUND, PLANNED, SHADE
from mjbiped.plotting.timelapse import outline
from mjbiped.records import measures
from mjbiped.records.frames import flat_samples
from mjbiped.records.pressure import centre_of_pressure
from mjbiped.records.record import Walk
from mjbiped.reports.figures import AXIS, COLOURS, HEADING, Shown, layout, line, small
from mjbiped.robots.robot import Array, Robot
from mjbiped.utils.extras import needed

MOST_SAMPLES = 6000
"""Drawn of a walk: of a longer one every second, third ... sample, and those at the steps' ends."""

_PANELS = (
    "Slope of the ground",
    "Torque",
    "Centre of pressure from the ankle",
    "Angle from the ground's normal",
    "Rate",
    "Mechanical power",
)
_UNITS = ("°", "N m", "cm", "rad", "rad/s", "W")
_GAP = 0.045  # between panels, of the figure's height
_FIRST_VIEW = 5.0  # ground that is in view at first, m
_POINTS = 200  # of a limit cycle
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
    """Six panels over one axis of time."""
    samples = walk.samples
    step = flat_samples(walk)["step"][keep]
    time = samples["time"][keep]
    power = measures.powers(walk)[keep]
    q, dq, torque = (samples[name][keep] for name in ("q", "dq", "torque"))
    estimate = np.degrees(samples["slope_estimate"][keep])
    lines: list[tuple[int, str, str, Array, bool]] = [
        (0, "estimate", "estimate", estimate, False),
        (0, "truth", "true slope", np.degrees(samples["slope"][keep]), False),
        (1, "ankle", "ankle", torque[:, 0], False),
        (1, "hip", "hip", torque[:, 1], False),
        (2, "ankle", "ankle", 100.0 * centre_of_pressure(walk)[keep], False),
        (3, "stance", "stance leg", q[:, 0], True),
        (3, "swing", "swing leg", q[:, 1], True),
        (4, "stance", "stance leg", dq[:, 0], True),
        (4, "swing", "swing leg", dq[:, 1], True),
        (5, "ankle", "ankle", power[:, 0], False),
        (5, "hip", "hip", power[:, 1], False),
    ]
    figure = graphs.Figure()
    named: set[str] = set()
    breaks = np.flatnonzero(np.diff(step)) + 1
    for panel, colour, name, values, broken in lines:
        if not np.isfinite(values).any():  # a controller without an estimate
            continue
        x, y = (np.insert(time, breaks, time[breaks]), np.insert(values, breaks, np.nan)) if broken else (time, values)
        look = line(colour)
        figure.add_scatter(
            x=small(x),
            y=small(y),
            name=name,
            legendgroup=name,
            showlegend=name not in named,
            mode="lines",
            line=look,
            yaxis=f"y{panel + 1}" if panel else "y",
            hovertemplate=f"%{{y:.4f}} {_UNITS[panel]}",
        )
        named.add(name)
    height = (1.0 - _GAP * (len(_PANELS) - 1)) / len(_PANELS)
    axes = {}
    for panel, (title, unit) in enumerate(zip(_PANELS, _UNITS, strict=True)):
        top = 1.0 - panel * (height + _GAP)
        axes[f"yaxis{panel + 1}" if panel else "yaxis"] = {
            **AXIS,
            "domain": [max(0.0, top - height), top],
            "title": {"text": unit},
            "anchor": "x",
        }
        figure.add_annotation(text=f"<b>{title}</b>", x=0.0, y=top, xref="paper", yref="paper", **HEADING)
    figure.update_layout(
        layout(
            **axes,
            xaxis={**AXIS, "title": {"text": "time (s)"}, "anchor": f"y{len(_PANELS)}", "unifiedhovertitle": _MOMENT},
            hovermode="x unified",
            hoversubplots="axis",
            legend={"orientation": "h", "yanchor": "bottom", "y": 1.03, "xanchor": "left", "x": 0.0},
            margin={"l": 70, "r": 20, "t": 60, "b": 50},
        )
    )
    every = math.ceil(len(samples["time"]) / MOST_SAMPLES)
    thinned = f" Of the {len(samples['time'])} samples every {every}th is drawn." if every > 1 else ""
    click = " Click to take the video there." if video else ""
    note = (
        "Point at a moment: the line is the same moment in every panel, on the ground and in the phase portraits."
        f"{click} Drag to zoom, double-click to see all.{thinned}"
    )
    return Shown("time", "Over time", note, figure, 1250)


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
        feet_x, feet_z = _sticks(walk.robot, starts, side)
        figure.add_scatter(
            x=feet_x, y=feet_z, mode="lines", line=line(leg, width=1), opacity=0.45, name=f"{leg} leg at touchdowns",
            hoverinfo="skip",
        )  # fmt: skip
    for leg in ("swing", "stance"):  # the page moves these two
        side = stance[:1] if leg == "stance" else 1 - stance[:1]
        now_x, now_z = _sticks(walk.robot, qpos[:1], side)
        figure.add_scatter(
            x=now_x[:2], y=now_z[:2], mode="lines+markers", line={"color": COLOURS[leg], "width": 5},
            marker={"size": 7, "color": COLOURS[leg]}, name=f"{leg} leg now", hoverinfo="skip",
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
    """One leg of several postures, each hip, foot and a gap: x and z, m."""
    legs = robot.limbs(qpos)[np.arange(len(qpos)), np.asarray(side, dtype=np.int64)]
    x, z = np.insert(legs, legs.shape[1], np.nan, axis=1).reshape(-1, 2).T
    return x, z


def _phases(graphs: Any, walk: Walk, keep: NDArray[np.int64]) -> Shown:
    """Rate over angle of each leg, with the gait that is imitated and the transitions that were planned to it."""
    step = flat_samples(walk)["step"][keep]
    breaks = np.flatnonzero(np.diff(step)) + 1
    cycle, planned = _imitated(walk), drawn_transitions(walk)
    figure = graphs.Figure()
    for leg, name in enumerate(("stance", "swing")):
        place = {"xaxis": f"x{leg + 1}" if leg else "x", "yaxis": f"y{leg + 1}" if leg else "y"}
        if planned:
            gap = np.full((1, 2 * len(walk.robot.angles)), np.nan)
            curves = np.concatenate([part for curve in planned for part in (curve, gap)])
            figure.add_scatter(
                x=small(curves[:, leg]), y=small(curves[:, len(walk.robot.angles) + leg]), mode="lines",
                name="re-planned reference",
                line={"color": PLANNED["color"], "width": 5}, legendgroup="planned", showlegend=not leg,
                hoverinfo="skip", **place,
            )  # fmt: skip
        q, dq = (np.insert(walk.samples[key][keep][:, leg], breaks, np.nan) for key in ("q", "dq"))
        figure.add_scatter(
            x=small(q), y=small(dq), mode="lines", name=f"{name} leg", line=line(name, dash="solid", width=1),
            hovertemplate="%{x:.4f} rad, %{y:.4f} rad/s<extra></extra>", **place,
        )  # fmt: skip
        if cycle is not None:
            figure.add_scatter(
                x=small(cycle[:, leg]), y=small(cycle[:, 2 + leg]), mode="lines", name="imitated gait",
                line=line("truth", width=2), legendgroup="gait", showlegend=not leg, hoverinfo="skip", **place,
            )  # fmt: skip
        figure.add_scatter(  # the page moves it
            x=q[:1], y=dq[:1], mode="markers", marker={"size": 12, "color": "white", "line": {"width": 3, "color":
            COLOURS[name]}}, name="now", meta="now", showlegend=False, hoverinfo="skip", **place,
        )  # fmt: skip
        figure.add_annotation(
            text=f"<b>{name.capitalize()} leg</b>", x=0.55 * leg, y=1.0, xref="paper", yref="paper", **HEADING
        )
    angle, rate = ({**AXIS, "title": {"text": words}} for words in ("angle (rad)", "rate (rad/s)"))
    angles, rates = (_ends_with_room(walk.samples[name][keep]) for name in ("q", "dq"))
    figure.update_layout(
        layout(
            xaxis={**angle, "domain": [0.0, 0.45], "autorangeoptions": {"include": angles[0]}},
            xaxis2={**angle, "domain": [0.55, 1.0], "anchor": "y2", "autorangeoptions": {"include": angles[1]}},
            yaxis={**rate, "autorangeoptions": {"include": rates[0]}},
            yaxis2={**rate, "anchor": "x2", "autorangeoptions": {"include": rates[1]}},
            legend={"orientation": "h", "yanchor": "bottom", "y": 1.07, "xanchor": "left", "x": 0.0},
            margin={"l": 70, "r": 20, "t": 70, "b": 50},
        )
    )
    return Shown("phases", "Phase portraits", "The ring is the moment that the other figures point at.", figure, 520)


def _ends_with_room(values: Array) -> list[list[float]]:
    """For each leg what its axis shows at least: its values and a twentieth of their span on both sides."""
    low, high = values.min(axis=0), values.max(axis=0)
    room = 0.05 * (high - low)
    ends: list[list[float]] = np.stack([low - room, high + room], axis=1).tolist()
    return ends


def _imitated(walk: Walk) -> Array | None:
    """The limit cycle of the gait that was imitated: angles and rates, shape (points, 4); None where there is none."""
    gait = drawn_gait(walk)
    if not isinstance(gait, Gait):
        return None
    q, dq, _ = gait.reference(np.linspace(0.0, gait.period, _POINTS))
    return np.concatenate([q, dq], axis=1)
