"""A small picture of a walk, for a notebook's page."""

from __future__ import annotations

from mjbiped.errors import RenderError
from mjbiped.plotting.style import drawn, figure_png
from mjbiped.plotting.timelapse import draw_row, rows_of
from mjbiped.records.record import Walk


def time_lapse_picture(walk: Walk) -> bytes:
    """The time lapse of a walk over its ground as a PNG file's bytes.

    Raises:
        RenderError: The record holds no samples.
    """
    if not len(walk.samples["time"]):
        raise RenderError("the record holds no samples: there is nothing to draw")
    rows = rows_of(walk)
    with drawn(None) as figure:
        figure.set_figheight(sum(row.height + 0.25 for row in rows) + 0.25)
        grid = figure.subplots(len(rows), 1, squeeze=False, height_ratios=[row.height for row in rows])
        for row, (axes,) in zip(rows, grid, strict=True):
            draw_row(axes, walk, row)
        grid[-1, 0].set_xlabel("x (m)")
    return figure_png(figure)
