"""Report of a walk: a page with video, linked figures, measures, touchdowns and parameters."""

from __future__ import annotations

import math
import tempfile
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import RenderError
from mjbiped.plotting.panels import curves_over_time, paths_from_above, portraits
from mjbiped.plotting.style import BLACK, GROUND, PLANNED, SHADE
from mjbiped.records import measures
from mjbiped.records.columns import flat_samples
from mjbiped.records.record import Walk
from mjbiped.records.signals import PANELS, SIGNALS, lines_of, signals_of, values_of, without_zeros
from mjbiped.reports import page
from mjbiped.reports.page import Panel, Shown, curve, include, line, plotted, small
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.robot import Array, Robot

MOST_SAMPLES = 6000
"""Greatest number of drawn samples; of a longer walk every second, third ... sample and the ends of steps are drawn."""

_PANEL = 210  # height of a panel over time with its title, pixels
_FIRST_VIEW = 5.0  # length of ground in the first view, m
_ROOM = 0.05  # margin around a phase portrait, per its span
_BEYOND = 3.0  # length of ground drawn behind and ahead of the walk, m


def report_walk(walk: Walk, path: Path, *, video: bool = True, progress: bool = False) -> None:
    """Write the report of a walk: one HTML page with video, linked figures, measures, touchdowns and parameters.

    Args:
        walk: The record.
        path: The page.
        video: Whether a video is made; if no OpenGL platform works, the page has none, and says so.
        progress: Show the progress of the video (never where the output is not a terminal).

    Raises:
        InputError: Plotly or Jinja is not installed; nothing has been made then.
        RecordError: The page cannot be written.
    """
    page.check_installed()
    sampled = bool(len(walk.samples["time"]))
    film, why_none = (None, "No video was requested.")
    if video:
        film, why_none = _video(walk, progress=progress)
    summary, touchdowns = walk.summary(), _touchdowns(walk)
    page.write_page(
        path,
        "walk.html",
        walk_figures(walk, video=film is not None) if sampled else [],
        _data(walk) if sampled else {},
        title=f"{walk.settings['controller']['name']} on {walk.terrain.caption}",
        outcome=f"{walk.outcome} after {walk.steps} step{'' if walk.steps == 1 else 's'}, {walk.end[0]:.2f} s and "
        f"{walk.distance:.2f} m, {walk.settings['engine']} engine",
        warnings=[f"{text} ({count} times)" if count > 1 else text for text, count in walk.warnings.items()],
        video=film,
        no_video=why_none,
        no_figures="" if sampled else "The record holds no samples: there is nothing to draw.",
        measures=[row for row in summary.rows if row[0] != "warning"],
        headings=list(touchdowns),
        rows=list(zip(*touchdowns.values(), strict=True)),
        parameters=list(page.flattened(walk.settings)),
        command=walk.settings.get("command"),
    )


def _video(walk: Walk, *, progress: bool) -> tuple[str | None, str]:
    """Return a video encoded as text, or the reason why there is none."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walk.mp4"
        try:
            walk.video(path, progress=progress)
        except RenderError as error:
            return None, f"There is no video: {error}."
        return b64encode(path.read_bytes()).decode(), ""


def _touchdowns(walk: Walk) -> dict[str, list[str]]:
    """Columns of the table of touchdowns by their headings."""
    rows = walk.touchdowns
    columns = {
        "time (s)": rows["time"],
        "x (m)": rows["x"],
        "z (m)": rows["z"],
        "slope (°)": np.degrees(rows["slope"]),
        "estimate before (°)": np.degrees(rows["slope_estimate_before"]),
        "estimate after (°)": np.degrees(rows["slope_estimate"]),
        "length (m)": measures.step_lengths(walk),
        "period (s)": measures.step_periods(walk),
        "slip (mm)": 1e3 * rows["slip"],
        "penetration (mm)": 1e3 * rows["penetration"],
        "friction used": measures.friction_asked(rows),
        "least force (N)": rows["normal_force"],
    }
    if "y" in rows:
        columns |= {
            "y (m)": rows["y"],
            "slope to the left (°)": np.degrees(rows["lateral_slope"]),
            "its estimate after (°)": np.degrees(rows["lateral_estimate"]),
        }
    if "knee_strike" in rows:
        columns |= {"knee strike (s)": rows["knee_strike"], "greatest flexion (°)": np.degrees(rows["flexion"])}
    texts = {name: [_number(value) for value in column.tolist()] for name, column in columns.items()}
    struck = ["yes" if struck else "no" for struck in rows["strikes"]]
    return {"step": [str(step + 1) for step in range(walk.steps)], **texts, "struck a face": struck}


def _number(value: float) -> str:
    return "" if math.isnan(value) else "∞" if value == math.inf else f"{round(value, 4) + 0.0:.4f}".replace("-", "−")


def _data(walk: Walk) -> dict[str, Any]:
    """Data by name, at the drawn samples, with which the page's program shows a moment."""
    keep, samples, robot = shown_samples(walk), walk.samples, type(walk.robot)
    told = [
        [signal.name, _digits(values_of(walk, name)[keep], 2), PANELS[signal.panel].unit]
        for name, signal in signals_of(robot).items()
        if PANELS[signal.panel].in_words and not (signal.optional and walk.robot.sole is None)
    ]
    legs = walk.robot.outline(samples["qpos"][keep])
    rows, stance = np.arange(len(keep)), samples["stance"][keep]
    return {
        "time": _digits(samples["time"][keep]),
        "step": flat_samples(walk)["step"][keep].tolist(),
        "told": told,
        "legs": {
            f"{role} leg now": [[_digits(axis, 4) for axis in point.T] for point in np.moveaxis(legs[rows, side], 1, 0)]
            for role, side in (("stance", stance), ("swing", (stance + 1) % legs.shape[1]))
        },
        **{name: [_digits(column) for column in samples[name][keep].T] for name in ("q", "dq")},
    }


def _digits(values: NDArray[np.float64], digits: int = 5) -> list[float | None]:
    """Round numbers to visible digits; None stands for numbers that are not finite, which JSON lacks."""
    return [value if math.isfinite(value) else None for value in np.round(values, digits).tolist()]


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
    above = [_from_above(walk, keep)] if isinstance(walk.robot, InSpace) else []
    return [_over_ground(walk), *above, _over_time(walk, keep, video), _phases(walk, keep)]


def _over_time(walk: Walk, keep: NDArray[np.int64], video: bool) -> Shown:
    """Draw the signals in panels over each other, with one axis of time."""
    time, panels = walk.samples["time"][keep], list[Panel]()
    ends = [float(time[0]), max(float(time[-1]), float(time[0]) + 1e-3)]
    x = {"title": {"text": "time (s)"}, "range": ends, "unifiedhovertitle": {"text": "t = %{x:.3f} s"}}
    for lines in without_zeros(lines_of(walk)):
        panel, traces = lines.panel, []
        for name, signal, times, values in curves_over_time(walk, lines, keep):
            told = f"{signal.symbol} = %{{y:.4f}} {panel.unit}".removeprefix(" = ")
            traces.append(curve(signal.name, small(times), small(values), told, line=line(name)))
        if panel.events:
            mark = {"symbol": "line-ns", "size": 8, "line": {"width": 1.6, "color": BLACK}}
            strikes = lines.events, np.zeros_like(lines.events)
            traces.append(curve(panel.events[0], *strikes, mode="markers", marker=mark))
        reach = include(np.array([*lines.values.values()]), panel.least)
        y = {"title": {"text": f"{panel.quantity} ({panel.unit})"}, **reach}
        panels.append(Panel(traces, x, y, f"<b>{panel.title}</b>"))
    thin = math.ceil(len(walk.samples["time"]) / MOST_SAMPLES)
    thinned = f" Of the {len(walk.samples['time'])} samples every {thin}th is drawn." if thin > 1 else ""
    click = " Click to take the video there." if video else ""
    note = (
        "Point at a moment: the line is the same moment in every panel, on the ground and in the phase portraits."
        f"{click} Drag to zoom, double-click to see all.{thinned}"
    )
    inner = len(panels) * _PANEL
    plot = plotted(panels, shared=True, legend=1.0 + 30 / inner, grid={"ygap": 0.22}, **page.UNIFIED)
    return Shown("time", "Over time", note, plot, inner + page.ABOVE + page.BELOW)


def _over_ground(walk: Walk) -> Shown:
    """Draw the ground, the posture at each touchdown, and the posture of the current moment."""
    qpos, rows = walk.samples["qpos"], walk.touchdowns
    low, high = float(qpos[:, 0].min()) - _BEYOND, float(qpos[:, 0].max()) + _BEYOND
    x, z = walk.terrain.outline(low, high)
    bottom, start = float(z.min()) - 0.25, float(qpos[0, 0]) - 0.8
    area = {"fill": "toself", "fillcolor": GROUND, "line": {"color": SHADE, "width": 1}}
    traces = [curve("ground", [x[0], *x, x[-1]], [bottom, *z, bottom], **area)]
    starts = np.concatenate([qpos[:1], rows["qpos"]])
    stance = np.concatenate([walk.samples["stance"][:1], rows["stance"]]).astype(np.int64)
    legs = ("swing", (stance + 1) % len(walk.robot.bodies.limbs)), ("stance", stance)
    for leg, side in legs:
        faint = {"line": line(f"q_{leg}", width=1), "opacity": 0.45}
        traces.append(curve(f"{leg} leg at touchdowns", *_sticks(walk.robot, starts, side), **faint))
    for leg, side in legs:  # the page moves these two
        now_x, now_z = _sticks(walk.robot, qpos[:1], side[:1])
        colour = SIGNALS[f"q_{leg}"].colour
        look = {"mode": "lines+markers", "line": {"color": colour, "width": 5}, "marker": {"size": 7, "color": colour}}
        traces.append(curve(f"{leg} leg now", now_x[:-1], now_z[:-1], **look))
    words = "step %{customdata[0]}, %{customdata[1]:.3f} s<br>x %{x:.3f} m, z %{y:.4f} m<br>slope %{customdata[2]:.2f}°"
    mark = {"mode": "markers", "marker": {"size": 9, "color": SHADE, "symbol": "triangle-up"}}
    data = np.stack([np.arange(1, walk.steps + 1), rows["time"], np.degrees(rows["slope"])], axis=1)
    traces.append(curve("footholds", rows["x"], rows["z"], f"{words}<extra></extra>", customdata=data, **mark))
    x_axis = {"title": {"text": "x (m)"}, "range": [start, start + _FIRST_VIEW]}
    y_axis = {"title": {"text": "z (m)"}, "scaleanchor": "x", "range": [bottom, float(z.max()) + 1.2]}
    note = (
        "Thin: the legs at each touchdown. Thick: the legs at the moment that the other figures point at; the view "
        "follows them. Drag to move along, scroll to zoom, double-click to see all."
    )
    return Shown("ground", "Over the ground", note, plotted([Panel(traces, x_axis, y_axis)], dragmode="pan"), 420)


def _from_above(walk: Walk, keep: NDArray[np.int64]) -> Shown:
    """Draw the paths of hip and swing foot of a robot in space, and the places of its stance feet, seen from above."""
    swing, hip, stood = (small(path.T) for path in paths_from_above(walk, keep))
    place = "x %{x:.3f} m, y %{y:.4f} m<extra></extra>"
    mark = {"mode": "markers", "marker": {"size": 8, "color": SIGNALS["q_stance"].colour}}
    traces = [
        curve("swing foot", swing[0], swing[1], place, line={"color": SIGNALS["q_swing"].colour, "width": 1.5}),
        curve("middle of the hip", hip[0], hip[1], place, line={"color": SHADE, "width": 2}),
        curve("stance foot", stood[0], stood[1], place, **mark),
    ]
    start = float(walk.samples["qpos"][0, 0]) - 0.8
    x = {"title": {"text": "x (m)"}, "range": [start, start + _FIRST_VIEW]}
    note = "The left side is up, and y is drawn larger than x. Drag to move along, scroll to zoom."
    plot = plotted([Panel(traces, x, {"title": {"text": "y (m)"}})], dragmode="pan")
    return Shown("above", "From above", note, plot, 320)


def _sticks(robot: Robot, qpos: Array, side: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return one leg of several postures, each from hip to foot and a gap: x and z, m."""
    legs = robot.outline(qpos)[np.arange(len(qpos)), side]
    x, z = np.insert(legs, legs.shape[1], np.nan, axis=1).reshape(-1, 2).T
    return x, z


def _phases(walk: Walk, keep: NDArray[np.int64]) -> Shown:
    """Draw rate over angle of each leg, with the imitated gait and the planned transitions to it."""
    panels = list[Panel]()
    for part, (angle, rate, motion, planned, gait) in zip(walk.robot.angles, portraits(walk, keep), strict=True):
        traces, gap = [], np.full((1, 2), np.nan)
        if planned:
            plans = small(np.vstack([piece for each in planned for piece in (each, gap)]).T)
            traces.append(curve("re-planned reference", *plans, line={"color": PLANNED["color"], "width": 5}))
        told, look = "%{x:.4f} rad, %{y:.4f} rad/s<extra></extra>", line(f"q_{part}", dash="solid", width=1)
        traces.append(curve(angle.name, small(motion[:, 0]), small(motion[:, 1]), told, line=look))
        if gait is not None:
            traces.append(curve("imitated gait", *small(gait.T), line=line("slope", width=2)))
        ring = {"size": 12, "color": "white", "line": {"width": 3, "color": angle.colour}}
        now = {"mode": "markers", "meta": "now", "showlegend": False, "marker": ring}  # the page moves it
        traces.append(curve("now", *small(motion[:1].T), **now))
        x = {"title": {"text": f"angle {angle.symbol} (rad)"}, **include(motion[:, 0], room=_ROOM)}
        y = {"title": {"text": f"rate {rate.symbol} (rad/s)"}, **include(motion[:, 1], room=_ROOM)}
        panels.append(Panel(traces, x, y, f"<b>{angle.name.capitalize()}</b>"))
    plot = plotted(panels, columns=len(panels), legend=1.07, grid={"xgap": 0.08 * len(panels)})
    return Shown("phases", "Phase portraits", "The ring is the moment that the other figures point at.", plot, 520)
