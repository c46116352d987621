"""Report of a walk."""

from __future__ import annotations

import math
import tempfile
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import RenderError
from mjbiped.records import measures
from mjbiped.records.columns import flat_samples
from mjbiped.records.record import Walk
from mjbiped.records.signals import PANELS, signals_of, values_of
from mjbiped.reports.page import check_installed, write_page
from mjbiped.reports.walk_figures import shown_samples, walk_figures

_MOST_LISTED = 12  # greatest number of listed numbers of a parameter; a ground may have thousands


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
    check_installed()
    sampled = bool(len(walk.samples["time"]))
    film, why_none = (None, "No video was requested.")
    if video:
        film, why_none = _video(walk, progress=progress)
    summary, touchdowns = walk.summary(), _touchdowns(walk)
    write_page(
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
        headings=["step", *touchdowns, "struck a face"],
        rows=list(_rows(touchdowns.values(), walk.touchdowns["strikes"])),
        parameters=list(flattened(walk.settings)),
        command=walk.settings.get("command"),
    )


def flattened(settings: Mapping[str, object], beginning: str = "") -> Iterator[tuple[str, str, str]]:
    """Flatten nested settings into lines: name with dots, value, no unit."""
    for key, value in settings.items():
        name = f"{beginning}{key}"
        if isinstance(value, Mapping) and value:
            yield from flattened(value, f"{name}.")
            continue
        if isinstance(value, list | tuple) and len(value) > _MOST_LISTED:
            yield name, f"{', '.join(map(str, value[:_MOST_LISTED]))}, ... ({len(value)} in all)", ""
        else:
            yield name, ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value), ""


def _video(walk: Walk, *, progress: bool) -> tuple[str | None, str]:
    """Return a video encoded as text, or the reason why there is none."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walk.mp4"
        try:
            walk.video(path, progress=progress)
        except RenderError as error:
            return None, f"There is no video: {error}."
        return b64encode(path.read_bytes()).decode(), ""


def _touchdowns(walk: Walk) -> dict[str, NDArray[np.float64]]:
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
        "least normal force (N)": rows["normal_force"],
    }
    if "knee_strike" in rows:
        columns |= {"knee strike after (s)": rows["knee_strike"], "greatest flexion (°)": np.degrees(rows["flexion"])}
    return columns


def _rows(columns: Iterable[NDArray[np.float64]], strikes: NDArray[np.int64]) -> Iterator[list[str]]:
    """Rows of the table: number of the step, its values, and whether its swing foot struck a face."""
    for step, (*values, struck) in enumerate(zip(*columns, strikes, strict=True), start=1):
        yield [str(step), *(_number(float(value)) for value in values), "yes" if struck else "no"]


def _number(value: float) -> str:
    return "" if math.isnan(value) else "∞" if value == math.inf else f"{value:.4f}".replace("-", "−")


def _data(walk: Walk) -> dict[str, Any]:
    """Data by name that the page's program needs to show a moment, at the samples that are drawn."""
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
