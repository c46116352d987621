"""Interactive figures of a walk: over time, over the ground, and phase portraits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mjbiped.analysis.replay import drawn_gait, drawn_transitions
from mjbiped.plotting.style import BLACK, GROUND, PLANNED, SHADE
from mjbiped.records.columns import flat_samples
from mjbiped.records.record import Walk
from mjbiped.records.signals import SIGNALS, lines_of, signals_of
from mjbiped.reports.page import Panels, Shown, include, line, shares, small
from mjbiped.robots.robot import Array, Robot

MOST_SAMPLES = 6000
"""Greatest number of drawn samples; of a longer walk every second, third ... sample is drawn, and the ends of steps."""

_PANEL_HEIGHT = 165  # pixels
_PANEL_GAP = 45  # below a panel, for the next one's title, pixels
_ABOVE, _BELOW = 60, 50  # margins for the legend and for the axis of time, pixels
_FIRST_VIEW = 5.0  # ground that is in view at first, m
_POINTS = 200  # of a limit cycle
_PORTRAIT_GAP = 0.08  # between phase portraits, of the figure's width
_ROOM = 0.05  # around a phase portrait, of its span
_BEYOND = 3.0  # ground that is drawn behind and ahead of the walk, m
_MOMENT = {"text": "t = %{x:.3f} s"}


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
    samples = walk.samples
    breaks = np.flatnonzero(np.diff(flat_samples(walk)["step"][keep])) + 1
    time, every = samples["time"][keep], list(lines_of(walk))
    height = len(every) * (_PANEL_HEIGHT + _PANEL_GAP) - _PANEL_GAP
    panels, named = Panels(), set[str]()
    ends = [float(time[0]), max(float(time[-1]), float(time[0]) + 1e-3)]
    x_axis = {"title": {"text": "time (s)"}, "range": ends, "unifiedhovertitle": _MOMENT}
    for number, lines in enumerate(every):
        panel, top = lines.panel, 1.0 - number * (_PANEL_HEIGHT + _PANEL_GAP) / height
        shown = {name: values[keep] for name, values in lines.values.items()}
        down, reach = (max(0.0, top - _PANEL_HEIGHT / height), top), include(np.array([*shown.values()]), panel.least)
        y = {"title": {"text": f"{panel.quantity} ({panel.unit})"}, **reach}
        place = panels.add(down=down, x=None if number else x_axis, y=y, heading=f"<b>{panel.title}</b>")
        at = breaks if panel.by_legs else breaks[:0]
        for name, values in shown.items():
            signal = lines.signals[name]
            symbol = f"{signal.symbol} = " if signal.symbol else ""
            panels.figure.add_scatter(
                x=small(np.insert(time, at, time[at])), y=small(np.insert(values, at, np.nan)), name=signal.name,
                legendgroup=signal.name, showlegend=signal.name not in named, mode="lines", line=line(name),
                hovertemplate=f"{symbol}%{{y:.4f}} {panel.unit}", **place,
            )  # fmt: skip
            named.add(signal.name)
        if panel.events:
            panels.figure.add_scatter(
                x=lines.events, y=np.zeros_like(lines.events), name=panel.events[0], mode="markers", hoverinfo="skip",
                marker={"symbol": "line-ns", "size": 8, "line": {"width": 1.6, "color": BLACK}}, **place,
            )  # fmt: skip
    thin = math.ceil(len(samples["time"]) / MOST_SAMPLES)
    thinned = f" Of the {len(samples['time'])} samples every {thin}th is drawn." if thin > 1 else ""
    click = " Click to take the video there." if video else ""
    note = (
        "Point at a moment: the line is the same moment in every panel, on the ground and in the phase portraits."
        f"{click} Drag to zoom, double-click to see all.{thinned}"
    )
    looks = {"hovermode": "x unified", "hoversubplots": "axis", "margin": {"l": 70, "r": 20, "t": _ABOVE, "b": _BELOW}}
    return panels.shown("time", "Over time", note, height + _ABOVE + _BELOW, legend=1.0 + 30 / height, **looks)


def _over_ground(walk: Walk) -> Shown:
    """Draw the ground, the posture at each touchdown, and the posture of the current moment."""
    qpos, rows, panels = walk.samples["qpos"], walk.touchdowns, Panels()
    low, high = float(qpos[:, 0].min()) - _BEYOND, float(qpos[:, 0].max()) + _BEYOND
    x, z = walk.terrain.outline(low, high)
    bottom, start = float(z.min()) - 0.25, float(qpos[0, 0]) - 0.8
    panels.add(
        x={"title": {"text": "x (m)"}, "range": [start, start + _FIRST_VIEW]},
        y={"title": {"text": "z (m)"}, "scaleanchor": "x", "range": [bottom, float(z.max()) + 1.2]},
    )
    figure = panels.figure
    figure.add_scatter(
        x=np.concatenate([[x[0]], x, [x[-1]]]), y=np.concatenate([[bottom], z, [bottom]]), fill="toself",
        fillcolor=GROUND, mode="lines", line={"color": SHADE, "width": 1}, name="ground", hoverinfo="skip",
    )  # fmt: skip
    starts = np.concatenate([qpos[:1], rows["qpos"]])
    stance = np.concatenate([walk.samples["stance"][:1], rows["stance"]])
    legs = ("swing", (stance + 1) % len(walk.robot.bodies.limbs)), ("stance", stance)
    for leg, side in legs:
        points_x, points_z = _sticks(walk.robot, starts, side)
        figure.add_scatter(
            x=points_x, y=points_z, mode="lines", line=line(f"q_{leg}", width=1), opacity=0.45,
            name=f"{leg} leg at touchdowns", hoverinfo="skip",
        )  # fmt: skip
    for leg, side in legs:  # the page moves these two
        now_x, now_z = _sticks(walk.robot, qpos[:1], side[:1])
        colour = SIGNALS[f"q_{leg}"].colour
        figure.add_scatter(
            x=now_x[:-1], y=now_z[:-1], mode="lines+markers", line={"color": colour, "width": 5},
            marker={"size": 7, "color": colour}, name=f"{leg} leg now", hoverinfo="skip",
        )  # fmt: skip
    told = np.stack([np.arange(1, walk.steps + 1), rows["time"], np.degrees(rows["slope"])], axis=1)
    step, place = "step %{customdata[0]}, %{customdata[1]:.3f} s", "x %{x:.3f} m, z %{y:.4f} m"
    figure.add_scatter(
        x=rows["x"], y=rows["z"], mode="markers", marker={"size": 9, "color": SHADE, "symbol": "triangle-up"},
        name="footholds", customdata=told,
        hovertemplate=f"{step}<br>{place}<br>slope %{{customdata[2]:.2f}}°<extra></extra>",
    )  # fmt: skip
    note = (
        "Thin: the legs at each touchdown. Thick: the legs at the moment that the other figures point at; the view "
        "follows them. Drag to move along, scroll to zoom, double-click to see all."
    )
    return panels.shown("ground", "Over the ground", note, 420, dragmode="pan")


def _sticks(robot: Robot, qpos: Array, side: NDArray[np.floating]) -> tuple[Array, Array]:
    """Return one leg of several postures, each from hip to foot and a gap: x and z, m."""
    legs = robot.outline(qpos)[np.arange(len(qpos)), np.asarray(side, dtype=np.int64)]
    x, z = np.insert(legs, legs.shape[1], np.nan, axis=1).reshape(-1, 2).T
    return x, z


def _phases(walk: Walk, keep: NDArray[np.int64]) -> Shown:
    """Draw rate over angle of each leg, with the imitated gait and the planned transitions to it."""
    breaks = np.flatnonzero(np.diff(flat_samples(walk)["step"][keep])) + 1
    gait, planned, signals = drawn_gait(walk), drawn_transitions(walk), signals_of(type(walk.robot))
    angles, panels = walk.robot.angles, Panels()
    for k, (part, across) in enumerate(zip(angles, shares(len(angles), _PORTRAIT_GAP), strict=True)):
        angle, rate = signals[f"q_{part}"], signals[f"dq_{part}"]
        q, dq = (walk.samples[name][keep][:, k] for name in ("q", "dq"))
        x = {"title": {"text": f"angle {angle.symbol} (rad)"}, **include(q, room=_ROOM)}
        y = {"title": {"text": f"rate {rate.symbol} (rad/s)"}, **include(dq, room=_ROOM)}
        place = panels.add(across, x=x, y=y, heading=f"<b>{angle.name.capitalize()}</b>")

        def add(
            name: str, x: Array, y: Array, place: dict[str, str] = place, first: bool = not k, **looks: object
        ) -> None:
            usual = {"mode": "lines", "legendgroup": name, "showlegend": first, "hoverinfo": "skip", **place}
            panels.figure.add_scatter(x=small(x), y=small(y), name=name, **{**usual, **looks})

        if planned:
            gap = np.full((1, 2 * len(angles)), np.nan)
            curves = np.concatenate([part for curve in planned for part in (curve, gap)])
            band = {"color": PLANNED["color"], "width": 5}
            add("re-planned reference", curves[:, k], curves[:, len(angles) + k], line=band)
        told = "%{x:.4f} rad, %{y:.4f} rad/s<extra></extra>"
        look = line(f"q_{part}", dash="solid", width=1)
        path, rates = (np.insert(values, breaks, np.nan) for values in (q, dq))
        add(angle.name, path, rates, line=look, showlegend=True, hoverinfo="all", hovertemplate=told)
        if gait is not None:
            cycle = gait.reference(np.linspace(0.0, gait.period, _POINTS))
            add("imitated gait", cycle[0][:, k], cycle[1][:, k], line=line("slope", width=2))
        ring = {"size": 12, "color": "white", "line": {"width": 3, "color": angle.colour}}
        add("now", q[:1], dq[:1], mode="markers", meta="now", showlegend=False, marker=ring)  # the page moves it
    note, margin = "The ring is the moment that the other figures point at.", {"l": 70, "r": 20, "t": 70, "b": 50}
    return panels.shown("phases", "Phase portraits", note, 520, legend=1.07, margin=margin)
