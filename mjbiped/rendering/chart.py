"""Strip chart below a picture: slope, estimate and torques over time, drawn once, with a moving cursor."""

from __future__ import annotations

import math
from itertools import islice
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjbiped.plotting.panels import draw_signals
from mjbiped.plotting.style import widen, zero_line
from mjbiped.records.record import Walk
from mjbiped.records.signals import lines_of
from mjbiped.rendering.overlay import Pixels

_LONGEST = 20.0  # longest time on a page, s; a longer walk has several pages
_DPI = 100.0
_LETTERS = 1 / 11.5  # height of the letters, per chart height
_MARGIN = 7.2  # beside the panels, in letters: for names and numbers on the left, names of the lines on the right
_WIDEST_MARGIN = 0.3  # per chart width
_PANELS = ((0.59, 0.94), (0.19, 0.52))  # lower and upper end of each, per chart height
_CURSOR = (200, 30, 30)


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
        self._size, self._start = (width, height), start
        self._letters = max(7.0, height * _LETTERS)
        self._margin = min(_WIDEST_MARGIN, _MARGIN * self._letters / width)
        self._pages = max(1, math.ceil((stop - start) / _LONGEST - 1e-9))
        self._long = (stop - start) / self._pages or 1.0
        self._page, self._drawn = -1, np.empty((height, width, 3), dtype=np.uint8)
        first, after = np.searchsorted(walk.samples["time"], (start, stop), side="right").tolist()
        self._inside, self._walk = slice(max(0, first - 1), after), walk
        self._lines = list(islice(lines_of(walk), len(_PANELS)))  # slope and torque
        self._least = 0.01 * walk.robot.weight * walk.robot.leg_length

    def draw(self, frame: Pixels, time: float) -> None:
        """Draw the chart, with the cursor at a time (s).

        Args:
            frame: RGB pixels to fill, the lower rows of a picture.
            time: Time since the start of the walk, s.
        """
        page = min(self._pages - 1, max(0, int((time - self._start) / self._long)))
        begin = self._start + page * self._long
        if page != self._page:
            self._page, self._drawn = page, self._draw_page(begin)
        frame[...] = self._drawn
        width, height = self._size
        share = min(1.0, max(0.0, (time - begin) / self._long))
        column = width * (self._margin + (1.0 - 2.0 * self._margin) * share)
        thick = max(1, round(width / 640))
        left = min(width - thick, round(column - thick / 2))
        low, high = _PANELS[1][0], _PANELS[0][1]
        frame[round(height * (1.0 - high)) : round(height * (1.0 - low)), left : left + thick] = _CURSOR

    def _draw_page(self, begin: float) -> Pixels:
        """Draw the page from a time (s) on."""
        width, height = self._size
        sizes = {"font.size": self._letters * 72.0 / _DPI, "lines.linewidth": 1.5, "legend.fontsize": "small"}
        bare = {"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False}
        settings: Any = {**sizes, **bare}
        with matplotlib.rc_context(settings):
            figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, facecolor="white")
            canvas = FigureCanvasAgg(figure)
            for lines, (low, high) in zip(self._lines, _PANELS, strict=True):
                axes = figure.add_axes((self._margin, low, 1.0 - 2.0 * self._margin, high - low))
                draw_signals(axes, self._walk, lines, self._inside)
                zero_line(axes)
                widen(axes, lines.panel.least or self._least)
                axes.set_xlim(begin, begin + self._long)
                axes.tick_params(labelsize="small", length=2.5, pad=2, labelbottom=low != _PANELS[0][0])
                axes.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
                heading = f"{lines.panel.quantity}\n({lines.panel.unit})"
                axes.text(0.004, 0.5 * (low + high), heading, transform=figure.transFigure, va="center")
                if lines.signals:
                    beside: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "borderaxespad": 0.0}
                    axes.legend(labelcolor="linecolor", handlelength=0.0, handletextpad=0.5, labelspacing=0.2, **beside)
            axes.text(1.03, -0.26, "time (s)", transform=axes.transAxes, va="center")
            canvas.draw()  # type: ignore[no-untyped-call]
        return np.asarray(canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()  # type: ignore[no-untyped-call]
