"""Strip chart below a picture: slope, estimate and torques over time, drawn once, with a moving cursor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjbiped.records.record import Walk
from mjbiped.records.signals import PANELS, SIGNALS, Panel, Signal, Values, panels_of, values_of
from mjbiped.rendering.overlay import Pixels

_LONGEST = 20.0  # longest time on a page, s; a longer walk has several pages
_DPI = 100.0
_LETTERS = 1 / 11.5  # height of the letters, per chart height
_MARGIN = 7.2  # beside the panels, in letters: for names and numbers on the left, names of the lines on the right
_WIDEST_MARGIN = 0.3  # per chart width
_PANELS = ((0.59, 0.94), (0.19, 0.52))  # lower and upper end of each, per chart height
_CURSOR = (200, 30, 30)
_LINE = 1.5  # width, points
_MOST_POINTS = 4000  # of a line on a page


class Chart:
    """Strip chart of a part of a walk."""

    def __init__(self, walk: Walk, start: float, stop: float, width: int, height: int) -> None:
        """Prepare the values; pages are drawn when they are first shown.

        Args:
            walk: A record with samples.
            start: Start of the part that is shown, s.
            stop: End of the part that is shown, s.
            width: Width, pixels.
            height: Height, pixels.
        """
        self._size = width, height
        self._letters = max(7.0, height * _LETTERS)
        margin = min(_WIDEST_MARGIN, _MARGIN * self._letters / width)
        self._left, self._right = margin, 1.0 - margin
        self._start, self._stop = start, stop
        self._pages = max(1, math.ceil((stop - start) / _LONGEST - 1e-9))
        self._page, self._drawn = -1, np.empty((height, width, 3), dtype=np.uint8)
        inside = _slice(walk.samples["time"], start, stop)
        self._time: Values = walk.samples["time"][inside]
        slopes = dict(panels_of(type(walk.robot)))["slope"]
        torques = [f"torque_{joint}" for joint in walk.robot.joints]
        least = 0.01 * walk.robot.weight * walk.robot.leg_length
        self._panels: list[tuple[Panel, list[tuple[Signal, Values]], tuple[float, float]]] = []
        for panel, names in ((PANELS["slope"], slopes), (PANELS["torque"], torques)):
            lines = [(SIGNALS[name], values_of(walk, name)[inside]) for name in names]
            known = [line for line in lines if np.isfinite(line[1]).any()]
            self._panels.append((panel, known, _limits([values for _, values in known], panel.least or least)))

    def draw(self, frame: Pixels, time: float) -> None:
        """Draw the chart, with the cursor at a time (s).

        Args:
            frame: RGB pixels to fill, the lower rows of a picture.
            time: Time since the start of the walk, s.
        """
        long = (self._stop - self._start) / self._pages
        page = min(self._pages - 1, max(0, int((time - self._start) / long))) if long > 0.0 else 0
        begin = self._start + page * long
        end = begin + (long if long > 0.0 else 1.0)
        if page != self._page:
            self._page, self._drawn = page, self._draw_page(begin, end)
        frame[...] = self._drawn
        width, height = self._size
        column = width * (self._left + (self._right - self._left) * min(1.0, max(0.0, (time - begin) / (end - begin))))
        thick = max(1, round(width / 640))
        left = min(width - thick, round(column - thick / 2))
        low, high = _PANELS[1][0], _PANELS[0][1]
        frame[round(height * (1.0 - high)) : round(height * (1.0 - low)), left : left + thick] = _CURSOR

    def _draw_page(self, begin: float, end: float) -> Pixels:
        """Draw a page from one time to another, s."""
        width, height = self._size
        letters = self._letters * 72.0 / _DPI
        words: dict[str, Any] = {"fontsize": letters, "va": "center"}
        figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        inside = _slice(self._time, begin, end)
        inside = slice(inside.start, inside.stop + 1, max(1, (inside.stop + 1 - inside.start) // _MOST_POINTS))
        for (panel, lines, limits), (low, high) in zip(self._panels, _PANELS, strict=True):
            place = (self._left, low, self._right - self._left, high - low)
            axes = figure.add_axes(place, xlim=(begin, end), ylim=limits)
            axes.spines[["top", "right"]].set_visible(False)
            axes.tick_params(labelsize=letters * 0.9, length=2.5, pad=2, labelbottom=low != _PANELS[0][0])
            axes.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
            axes.grid(axis="y", color="0.88", linewidth=0.8)
            axes.set_axisbelow(True)
            middle, heading = 0.5 * (low + high), f"{panel.quantity}\n({panel.unit})"
            axes.text(0.004, middle, heading, transform=figure.transFigure, **words)
            first, apart = (0.72, 0.44) if len(lines) < 3 else (0.98, 0.42)
            for row, (signal, values) in enumerate(lines):
                look: dict[str, Any] = {"color": signal.colour, "linewidth": _LINE, "linestyle": signal.line}
                axes.plot(self._time[inside], values[inside], **look)
                right = (1.012, first - apart * row, signal.name)
                axes.text(*right, transform=axes.transAxes, color=signal.colour, **words)
        axes.text(1.03, -0.26, "time (s)", transform=axes.transAxes, **words)
        canvas.draw()  # type: ignore[no-untyped-call]
        return np.asarray(canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()  # type: ignore[no-untyped-call]


def _slice(time: Values, start: float, stop: float) -> slice:
    """Samples from the last one at or before a time to the last one at or before another, s."""
    first, after = np.searchsorted(time, (start, stop), side="right").tolist()
    return slice(max(0, first - 1), after)


def _limits(columns: Sequence[Values], least: float) -> tuple[float, float]:
    """Ends of an axis that shows zero, all finite values, and at least a span of `least`."""
    values = np.concatenate([np.zeros(1), *(column[np.isfinite(column)] for column in columns)])
    low, high = float(values.min()), float(values.max())
    room = max(0.0, least - (high - low)) / 2.0 + 0.06 * max(high - low, least)
    return low - room, high + room
