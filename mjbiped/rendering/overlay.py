"""Text and signs on frames: dark letters on pale panels, in a size that follows the frame's height."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mjbiped.engines.mujoco.scenery import CUT
from mjbiped.rendering.marks import Sign
from mjbiped.rendering.scene import View
from mjbiped.terrain.terrain import Terrain

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


@lru_cache(maxsize=16)
def _font(size: float, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Load DejaVu Sans, which comes with matplotlib; it remembers words, most of which stand in many frames."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    font = ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)
    for method in ("getlength", "getmask2"):
        setattr(font, method, lru_cache(_REMEMBERED)(getattr(font, method)))
    return font


@contextmanager
def overlay(frame: Pixels, height: int) -> Iterator[Overlay]:
    """Draw text and signs on a frame, which is changed when the block ends.

    Args:
        frame: RGB, shape (rows, columns, 3).
        height: Height of the whole picture, of which the frame may be a part, pixels; the font's size follows it.
    """
    image = Image.fromarray(frame)
    yield Overlay(image, height)
    frame[...] = np.asarray(image)


class Overlay:
    """Text and signs on a picture.

    Attributes:
        letter: Size of the letters, pixels.
    """

    def __init__(self, image: Image.Image, height: int) -> None:
        """Prepare to draw on an image that is part of a picture of this height, pixels."""
        self._draw, (self._width, self._rows) = ImageDraw.Draw(image, "RGBA"), image.size
        self._edge = round(height * 0.02)
        self.letter = max(_SMALLEST, round(height * _HEIGHT, 1))

    def caption(self, lines: Sequence[str]) -> tuple[int, int]:
        """Write lines into the upper left corner; return their right and lower end, pixels."""
        return self._panel(lines, self._edge, self._edge, self.letter, _WIDEST)

    def _panel(
        self, lines: Sequence[str], x: float, y: float, size: float, widest: float, bold: bool = False
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
        left = round(x if x >= 0 else self._width + x - wide)
        right, low = left + wide, round(y) + int(pitch * len(lines)) + 2 * margin - 1
        self._draw.rectangle((left, round(y), right, low), fill=_PANEL)
        for row, line in enumerate(lines):
            place = (left + margin, round(y) + margin + pitch * (row + 0.42))
            self._draw.text(place, line, font=font, fill=_TEXT, anchor="lm")
        return right + 1, low + 1

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
            names = max(font.getlength(sign.name) for sign in signs)
            left = right - int(names + font.getlength("−000.0 N m") + 3.6 * size)
            top = top if left > beside[0] else beside[1] + self._edge
            low = top + int(pitch * (len(signs) + 0.5))
            self._draw.rectangle((left, top, right - 1, low - 1), fill=_PANEL)
            for row, sign in enumerate(signs):
                middle = top + pitch * (row + 0.75)
                bar = (left + 0.5 * size, middle - 0.16 * size, left + 1.7 * size, middle + 0.16 * size)
                self._draw.rectangle(bar, fill=sign.colour)
                self._draw.text((left + 2.2 * size, middle), sign.name, font=font, fill=_TEXT, anchor="lm")
                self._draw.text((right - 0.5 * size, middle), sign.value, font=font, fill=_TEXT, anchor="rm")
            top = low + self._edge
        if headline:
            self._panel([headline], -self._edge, top, 1.4 * self.letter, _WIDEST_HEADLINE, bold=True)

    def scale(self, pixels_per_metre: float, top: float) -> tuple[str, int]:
        """Draw a bar of a round length under the caption, about a seventh of the frame's width.

        Args:
            pixels_per_metre: Scale in the robot's plane.
            top: Upper end of the bar's text, pixels.

        Returns:
            The text, and the length of the bar, pixels.
        """
        wanted = self._width / 7.0 / pixels_per_metre
        power = 10.0 ** math.floor(math.log10(wanted))
        length = max(digit * power for digit in _NICE if digit * power <= wanted * 1.01)
        text, wide = f"{length:g} m", round(length * pixels_per_metre)
        size, left, tick = self.letter, self._edge, 0.3 * self.letter
        thick, middle = max(1, round(size / 9)), round(top) + 1.65 * size
        self._draw.text((left + wide / 2, round(top) + 0.65 * size), text, font=_font(size), fill=_TEXT, anchor="mm")
        self._draw.line((left, middle, left + wide, middle), fill=_TEXT, width=thick)
        for x in (left + thick / 2, left + wide - thick / 2):
            self._draw.line((x, middle - tick, x, middle + tick), fill=_TEXT, width=thick)
        return text, wide

    def ground_labels(self, terrain: Terrain, view: View, leg_length: float) -> list[str]:
        """Label each segment's slope and each step's height along the lower edge, as far as there is room.

        Args:
            terrain: The ground.
            view: View of a camera that looks across the walking direction.
            leg_length: Length of the robot's leg, m.

        Returns:
            The labels that found room.
        """
        font = _font(round(0.8 * self.letter, 1))
        here, cut, width = float(view.place[0]), -CUT * leg_length, float(self._width)
        origin = view.pixel(here, cut, 0.0)[0]
        pitch = view.pixel(here + 1.0, cut, 0.0)[0] - origin
        first, last = (terrain.segment_at(here + (edge - origin) / pitch) for edge in (0.0, width))
        written: list[str] = []
        taken: list[tuple[float, float]] = []

        def write(text: str, middle: float, low: float, high: float) -> None:
            """Write a label about a column between two others, if there is room."""
            half = 0.5 * font.getlength(text) + 0.5 * _APART * font.size
            if low + half > high - half:
                return
            middle = min(max(middle, low + half), high - half)
            if all(middle + half < start or middle - half > stop for start, stop in taken):
                taken.append((middle - half, middle + half))
                written.append(text)
                place = (middle, self._rows - 0.9 * font.size)
                self._draw.text(place, text, font=font, fill=_TEXT, anchor="mm")

        columns = [origin + pitch * (x - here) for x in terrain.x[first : last + 1]]
        for index, column in zip(range(first, last + 1), columns, strict=True):
            rise = terrain.rises[index]
            if abs(rise) >= _LEAST_STEP and 0.0 < column < width:
                write(f"{abs(rise) * 1e3:.3g} mm {'up' if rise > 0.0 else 'down'}", column, 0.0, width)
        for index, column in zip(range(first, last + 1), columns, strict=True):
            start = 0.0 if index == first else column
            stop = width if index == last else columns[index - first + 1]
            slope = terrain.angle[index]
            words = f"{math.degrees(abs(slope)):.1f}° {'down' if slope > 0.0 else 'up'}"
            write(words if abs(slope) >= _LEAST_SLOPE else "level", 0.5 * (start + stop), start, stop)
        return written
