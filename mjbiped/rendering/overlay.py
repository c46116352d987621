"""Words and signs over a picture, in proportion to its height, and the strip chart of signals below it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mjbiped.engines.mujoco.scenery import CUT
from mjbiped.plotting.panels import draw_signals
from mjbiped.plotting.style import widen, zero_line
from mjbiped.records.record import Walk
from mjbiped.records.signals import lines_of
from mjbiped.rendering.marks import Sign
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

Label = tuple[str, float, float, float]
"""Words, their column, and the two columns between which they stay, pixels."""

Pixels = NDArray[np.uint8]

_HEIGHT = 1 / 36  # height of the letters, per frame height: 20 pixels at 720
_SMALLEST = 7.0  # pixels; smaller letters cannot be read
_WIDEST = 0.54  # of the lines, per frame width
_WIDEST_HEADLINE = 0.36
_PANEL = (255, 255, 255, 190)
_TEXT = (25, 25, 25, 255)
_NICE = (1.0, 2.0, 5.0, 10.0)  # digits of a scale's length
_LEAST_STEP = 5e-4  # m; lower steps are not labelled
_LEAST_SLOPE = math.radians(0.05)  # gentler slopes are labelled as level
_REMEMBERED = 256  # words of a font whose picture is kept
_APART = 0.8  # distance between two labels, in letters

_LONGEST = 20.0  # longest time on a page of the chart, s; a longer walk has several pages
_DPI = 100.0
_LETTERS = 1 / 11.5  # height of the letters, per chart height
_MARGIN = 7.2  # beside the panels, in letters: for names and numbers on the left, names of the lines on the right
_WIDEST_MARGIN = 0.3  # per chart width
_MOST_NAMES = 4  # beside a panel, in letters of the usual size
_PANELS = ((0.59, 0.94), (0.19, 0.52))  # lower and upper end of each, per chart height
_CURSOR = (200, 30, 30)


@lru_cache(maxsize=16)
def _font(size: float, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Load DejaVu Sans, which comes with matplotlib; it remembers words, most of which stand in many frames."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    font = ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)
    for method in ("getlength", "getmask2"):
        setattr(font, method, lru_cache(_REMEMBERED)(getattr(font, method)))
    return font


class View(NamedTuple):
    """Projection of places to pixels by a camera of a scene.

    Attributes:
        size: Width and height of the picture, pixels.
        place: Place of the camera, m.
        axes: Right, up and backward directions of the camera, as rows.
        half: Half height of the visible region at distance 1; in m for an orthographic camera.
        orthographic: Whether sizes are the same at all distances.
    """

    size: tuple[int, int]
    place: NDArray[np.float64]
    axes: NDArray[np.float64]
    half: float
    orthographic: bool

    @classmethod
    def of(cls, model: mujoco.MjModel, data: mujoco.MjData, camera: int, size: tuple[int, int]) -> View:
        """Return the view of the camera with this number in a picture of the given width and height in pixels."""
        orthographic = bool(model.cam_projection[camera] == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC)
        angle = float(model.cam_fovy[camera])
        half = 0.5 * angle if orthographic else math.tan(math.radians(0.5 * angle))
        return cls(size, data.cam_xpos[camera].copy(), data.cam_xmat[camera].reshape(3, 3).T.copy(), half, orthographic)

    def pixel(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Return column and row of a place (m)."""
        right, up, behind = (self.axes @ (np.array((x, y, z)) - self.place)).tolist()
        width, height = self.size
        share = 0.5 * height / self.half / (1.0 if self.orthographic else -behind)
        return 0.5 * width + share * right, 0.5 * height - share * up


class Overlay:
    """Words and signs on a picture.

    Attributes:
        letter: Size of the letters, pixels.
    """

    def __init__(self, picture: Pixels, height: int) -> None:
        """Prepare to draw on RGB pixels, shape (rows, columns, 3), of a picture of this height in all, pixels."""
        self._picture, (self._rows, self._width, _) = picture, picture.shape
        self._edge = round(height * 0.02)
        self.letter = max(_SMALLEST, round(height * _HEIGHT, 1))

    @contextmanager
    def _part(
        self, left: float, top: float, right: float, low: float, fill: tuple[int, ...] = ()
    ) -> Iterator[ImageDraw.ImageDraw]:
        """Draw on a part of the picture, whose corner has the coordinates (0, 0); the rest need not be converted."""
        rows = slice(min(max(0, round(top)), self._rows - 1), max(1, round(low)))
        part = self._picture[rows, max(0, round(left)) : round(right)]
        image = Image.fromarray(part)
        draw = ImageDraw.Draw(image, "RGBA")
        if fill:
            draw.rectangle((0, 0, self._width, self._rows), fill=fill)
        yield draw
        part[...] = np.asarray(image)

    def caption(self, lines: Sequence[str]) -> tuple[int, int]:
        """Write lines into the upper left corner; return their right and lower end, pixels."""
        return self._panel(lines, self._edge, self._edge, self.letter, _WIDEST)

    def _panel(
        self, lines: Sequence[str], x: int, top: int, size: float, widest: float, bold: bool = False
    ) -> tuple[int, int]:
        """Write lines on a translucent panel, from x to the right, or for a negative x that far from the right edge.

        The letters are as much smaller as the longest line needs, but never too small to read. Return the panel's right
        and lower end, pixels.
        """
        font = _font(size, bold)
        longest = max(map(font.getlength, lines))
        if longest > widest * self._width:
            font = _font(max(_SMALLEST, round(size * widest * self._width / longest, 1)), bold)
        margin, pitch = max(2, round(font.size * 0.4)), 1.3 * font.size
        wide = int(max(map(font.getlength, lines))) + 2 * margin
        left = x if x >= 0 else self._width + x - wide
        right, low = left + wide + 1, top + int(pitch * len(lines)) + 2 * margin
        with self._part(left, top, right, low, _PANEL) as draw:
            for row, line in enumerate(lines):
                draw.text((margin, margin + pitch * (row + 0.42)), line, font=font, fill=_TEXT, anchor="lm")
        return right, low

    def legend(self, signs: Iterable[Sign], beside: tuple[int, int] = (0, 0), headline: str = "") -> None:
        """Draw a legend into the upper right corner, lower where the caption leaves no room there.

        Args:
            signs: Lines of the legend.
            beside: Right and lower end of the caption, pixels.
            headline: Larger words below the legend; none if empty.
        """
        signs, size = tuple(signs), round(self.letter * 0.85, 1)
        font, pitch, right, top = _font(size), 1.35 * size, self._width - self._edge, self._edge
        if signs:
            wide = int(max(font.getlength(sign.name) for sign in signs) + font.getlength("−000.0 N m") + 3.6 * size)
            top = top if right - wide > beside[0] else beside[1] + self._edge
            low = top + int(pitch * (len(signs) + 0.5))
            with self._part(right - wide, top, right, low, _PANEL) as draw:
                for row, sign in enumerate(signs):
                    middle = pitch * (row + 0.75)
                    bar = (0.5 * size, middle - 0.16 * size, 1.7 * size, middle + 0.16 * size)
                    draw.rectangle(bar, fill=sign.colour)
                    draw.text((2.2 * size, middle), sign.name, font=font, fill=_TEXT, anchor="lm")
                    draw.text((wide - 0.5 * size, middle), sign.value, font=font, fill=_TEXT, anchor="rm")
            top = low + self._edge
        if headline:
            self._panel([headline], -self._edge, top, 1.4 * self.letter, _WIDEST_HEADLINE, bold=True)

    def scale(self, pixels_per_metre: float, top: float) -> str:
        """Draw a bar of a round length under the caption, about a seventh of the frame's width, and return the length.

        Args:
            pixels_per_metre: Scale in the robot's plane.
            top: Upper end of the bar's text, pixels.
        """
        wanted = self._width / 7.0 / pixels_per_metre
        power = 10.0 ** math.floor(math.log10(wanted))
        length = max(digit * power for digit in _NICE if digit * power <= wanted * 1.01)
        text, wide = f"{length:g} m", round(length * pixels_per_metre)
        size, left, tick = self.letter, self._edge, 0.3 * self.letter
        thick, middle = max(1, round(size / 9)), 1.65 * size
        with self._part(0, round(top), left + wide + 2 * size, round(top) + 2.2 * size) as draw:
            draw.text((left + wide / 2, 0.65 * size), text, font=_font(size), fill=_TEXT, anchor="mm")
            draw.line((left, middle, left + wide, middle), fill=_TEXT, width=thick)
            for x in (left + thick / 2, left + wide - thick / 2):
                draw.line((x, middle - tick, x, middle + tick), fill=_TEXT, width=thick)
        return text

    def ground_labels(self, terrain: Terrain, view: View, leg_length: float) -> list[str]:
        """Label each step's height and each segment's slope along the lower edge, as far as there is room.

        Args:
            terrain: The ground.
            view: View of a camera that looks across the walking direction.
            leg_length: Length of the robot's leg, m.

        Returns:
            The labels that found room.
        """
        font, width = _font(round(0.8 * self.letter, 1)), float(self._width)
        here, cut = float(view.place[0]), -CUT * leg_length
        origin, ahead = (view.pixel(x, cut, 0.0)[0] for x in (here, here + 1.0))
        first, last = (terrain.segment_at(here + (edge - origin) / (ahead - origin)) for edge in (0.0, width))
        columns = [origin + (ahead - origin) * (x - here) for x in terrain.x[first : last + 1]]
        wanted: list[
            tuple[str, float, float, float]
        ] = []  # words, their column, and two columns that they keep between
        slopes = list(wanted)
        for number, (column, index) in enumerate(zip(columns, range(first, last + 1), strict=True)):
            rise, slope = terrain.rises[index], terrain.angle[index]
            if abs(rise) >= _LEAST_STEP and 0.0 < column < width:
                wanted.append(
                    (f"{round(abs(rise) * 1e3, 1):g} mm {'up' if rise > 0.0 else 'down'}", column, 0.0, width)
                )
            start, stop = 0.0 if number == 0 else column, [*columns[1:], width][number]
            words = f"{math.degrees(abs(slope)):.1f}° {'down' if slope > 0.0 else 'up'}"
            slopes.append((words if abs(slope) >= _LEAST_SLOPE else "level", 0.5 * (start + stop), start, stop))
        written: list[str] = []
        taken: list[tuple[float, float]] = []
        with self._part(0, self._rows - 2.0 * font.size, self._width, self._rows) as draw:
            for text, column, low, high in wanted + slopes:
                half = 0.5 * font.getlength(text) + 0.5 * _APART * font.size
                middle = min(max(column, low + half), high - half)
                free = all(middle + half < start or middle - half > stop for start, stop in taken)
                if low + half <= high - half and free:
                    taken.append((middle - half, middle + half))
                    written.append(text)
                    draw.text((middle, 1.1 * font.size), text, font=font, fill=_TEXT, anchor="mm")
        return written


class Chart:
    """Strip chart of a part of a walk: its first two panels over time, drawn once, with a moving cursor."""

    def __init__(self, walk: Walk, start: float, stop: float, width: int, height: int) -> None:
        """Prepare the values; pages are drawn when they are first shown.

        Args:
            walk: A record with samples.
            start: Start of the part that is shown, s.
            stop: End of the part that is shown, s.
            width: Width, pixels.
            height: Height, pixels.
        """
        self._walk, self._size, self._start = walk, (width, height), start
        self._letters = max(7.0, height * _LETTERS)
        self._margin = min(_WIDEST_MARGIN, _MARGIN * self._letters / width)
        self._pages = max(1, math.ceil((stop - start) / _LONGEST - 1e-9))
        self._long = (stop - start) / self._pages or 1.0
        self._page, self._drawn = -1, np.empty((height, width, 3), dtype=np.uint8)
        first, after = np.searchsorted(walk.samples["time"], (start, stop), side="right").tolist()
        self._inside = slice(max(0, first - 1), after)
        self._lines = list(islice(lines_of(walk), len(_PANELS)))  # slope and torque
        self._least = 0.01 * walk.robot.weight * walk.robot.leg_length

    def draw(self, frame: Pixels, time: float) -> None:
        """Draw the chart, with the cursor at a time (s) since the start of the walk, on RGB pixels of its size."""
        page = min(self._pages - 1, max(0, int((time - self._start) / self._long)))
        begin = self._start + page * self._long
        if page != self._page:
            self._page, self._drawn = page, self._draw_page(begin)
        frame[...] = self._drawn
        width, height = self._size
        share = min(1.0, max(0.0, (time - begin) / self._long))
        thick = max(1, round(width / 640))
        middle = width * (self._margin + (1.0 - 2.0 * self._margin) * share)
        left = min(width - thick, round(middle - thick / 2))
        low, high = _PANELS[1][0], _PANELS[0][1]
        frame[round(height * (1.0 - high)) : round(height * (1.0 - low)), left : left + thick] = _CURSOR

    def _draw_page(self, begin: float) -> Pixels:
        """Draw the page from a time (s) on."""
        width, height = self._size
        settings: Any = {
            **{"font.size": self._letters * 72.0 / _DPI, "lines.linewidth": 1.5, "legend.fontsize": "small"},
            **{"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False},
        }
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
                    beside: Any = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "borderaxespad": 0.0}
                    beside["fontsize"] = "small" if len(lines.signals) <= _MOST_NAMES else "x-small"
                    axes.legend(labelcolor="linecolor", handlelength=0.0, handletextpad=0.5, labelspacing=0.2, **beside)
            axes.text(1.03, -0.26, "time (s)", transform=axes.transAxes, va="center")
            canvas.draw()  # type: ignore[no-untyped-call]
        return np.asarray(canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()  # type: ignore[no-untyped-call]
