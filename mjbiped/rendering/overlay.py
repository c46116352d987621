"""Text and signs on frames: dark letters on pale panels, in a font whose size follows the frame's."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Pixels = NDArray[np.uint8]

_HEIGHT = 1 / 36  # of the letters, per frame height: 20 pixels at 720
_SMALLEST = 7.0  # pixels; smaller letters cannot be read
_WIDEST = 0.54  # of the lines, per frame width
_WIDEST_HEADLINE = 0.36
_PANEL = (255, 255, 255, 190)
_TEXT = (25, 25, 25, 255)
_NICE = (1.0, 2.0, 5.0, 10.0)  # digits of a scale's length


class Stamp(NamedTuple):
    """A small picture to be laid on frames.

    Attributes:
        colour: Times opacity, shape (height, width, 3).
        clear: 255 less opacity, shape (height, width, 1).
    """

    colour: NDArray[np.uint16]
    clear: NDArray[np.uint16]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.colour.shape[1], self.colour.shape[0]


class Sign(NamedTuple):
    """A line of a legend.

    Attributes:
        colour: RGB of its sign, 0 to 1.
        name: What it is.
        value: With its unit; may be empty.
    """

    colour: tuple[float, float, float]
    name: str
    value: str


def letter_size(height: int) -> float:
    """Size of a font's letters in a frame of so many pixels, pixels."""
    return max(_SMALLEST, round(height * _HEIGHT, 1))


@lru_cache(maxsize=16)
def _font(size: float, bold: bool = False) -> ImageFont.FreeTypeFont:
    """DejaVu Sans, which comes with matplotlib."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


def text_width(text: str, size: float) -> float:
    """Width of a text, pixels."""
    return _font(size).getlength(text)


def _stamp(image: Image.Image) -> Stamp:
    """What is laid on frames, of an RGBA picture."""
    pixels = np.asarray(image).astype(np.uint16)
    opacity = pixels[..., 3:]
    return Stamp(pixels[..., :3] * opacity, 255 - opacity)


def lay(frame: Pixels, stamp: Stamp, x: float, y: float) -> None:
    """Lay a stamp on a frame, its upper left corner at x, y (pixels); what is outside of the frame is cut off."""
    left, top = round(x), round(y)
    width, height = stamp.size
    columns = slice(max(0, left), max(0, min(frame.shape[1], left + width)))
    rows = slice(max(0, top), max(0, min(frame.shape[0], top + height)))
    inside = (slice(rows.start - top, rows.stop - top), slice(columns.start - left, columns.stop - left))
    part = frame[rows, columns]
    if part.size:
        part[...] = (part * stamp.clear[inside] + stamp.colour[inside]) // 255


@lru_cache(maxsize=512)
def text_stamp(text: str, size: float) -> Stamp:
    """A line of plain text without a panel."""
    font = _font(size)
    image = Image.new("RGBA", (int(font.getlength(text)) + 2, int(1.3 * size) + 1), (*_TEXT[:3], 0))
    ImageDraw.Draw(image).text((1, 0.62 * size), text, font=font, fill=_TEXT, anchor="lm")
    return _stamp(image)


@lru_cache(maxsize=32)
def _panel(lines: tuple[str, ...], width: int, height: int, bold: bool) -> Stamp:
    """The lines on a translucent panel, as large as they need."""
    size = max(_SMALLEST, round(height * _HEIGHT * (1.4 if bold else 1.0), 1))
    font = _font(size, bold)
    room = (_WIDEST_HEADLINE if bold else _WIDEST) * width
    widest = max(map(font.getlength, lines))
    if widest > room:  # as much smaller as the longest line needs, but never too small to read
        font = _font(max(_SMALLEST, round(size * room / widest, 1)), bold)
    margin = max(2, round(font.size * 0.4))
    pitch = font.size * 1.3
    wide = int(max(font.getlength(line) for line in lines)) + 2 * margin + 1
    panel = Image.new("RGBA", (wide, int(pitch * len(lines)) + 2 * margin), _PANEL)
    draw = ImageDraw.Draw(panel)
    for row, line in enumerate(lines):
        draw.text((margin, margin + pitch * (row + 0.42)), line, font=font, fill=_TEXT, anchor="lm")
    return _stamp(panel)


def _edge(height: int) -> int:
    """Between a panel and the frame's edges, pixels."""
    return round(height * 0.02)


def lay_caption(frame: Pixels, lines: Sequence[str], height: int) -> tuple[int, int]:
    """Lay lines into the upper left corner of a frame.

    Args:
        frame: RGB, to be changed.
        lines: Top to bottom.
        height: Of the whole picture, whose part the frame may be, pixels; the font's size follows it.

    Returns:
        The lines' right and lower end, pixels.
    """
    edge = _edge(height)
    panel = _panel(tuple(lines), frame.shape[1], height, bold=False)
    lay(frame, panel, edge, edge)
    return edge + panel.size[0], edge + panel.size[1]


def lay_legend(
    frame: Pixels, signs: Iterable[Sign], height: int, beside: tuple[int, int] = (0, 0), headline: str = ""
) -> None:
    """Lay a legend into the upper right corner of a frame, lower where the caption leaves no room there.

    Args:
        frame: RGB, to be changed.
        signs: Its lines.
        height: Of the picture, pixels; the font's size follows it.
        beside: Right and lower end of the caption, pixels.
        headline: Larger, below it; none where empty.
    """
    signs = tuple(signs)
    size = round(letter_size(height) * 0.85, 1)
    edge, pitch = _edge(height), 1.35 * size
    right, top = frame.shape[1] - edge, float(edge)
    if signs:
        panel = _legend(tuple((sign.colour, sign.name) for sign in signs), size)
        top = edge if right - panel.size[0] > beside[0] else beside[1] + edge
        lay(frame, panel, right - panel.size[0], top)
        for row, sign in enumerate(signs):
            if sign.value:
                value = text_stamp(sign.value, size)
                lay(frame, value, right - 0.5 * size - value.size[0], top + (row + 0.25) * pitch)
        top += panel.size[1] + edge
    if headline:
        panel = _panel((headline,), frame.shape[1], height, bold=True)
        lay(frame, panel, right - panel.size[0], top)


@lru_cache(maxsize=8)
def _legend(signs: tuple[tuple[tuple[float, float, float], str], ...], size: float) -> Stamp:
    """A legend's panel, with room for values."""
    font, pitch = _font(size), 1.35 * size
    names = max(font.getlength(name) for _, name in signs)
    panel = Image.new(
        "RGBA", (int(names + font.getlength("−000.0 N m") + 3.6 * size), int(pitch * (len(signs) + 0.5))), _PANEL
    )
    draw = ImageDraw.Draw(panel)
    for row, (colour, name) in enumerate(signs):
        middle = pitch * (row + 0.75)
        fill = tuple(round(255 * part) for part in colour)
        draw.rectangle((0.5 * size, middle - 0.16 * size, 1.7 * size, middle + 0.16 * size), fill=(*fill, 255))
        draw.text((2.2 * size, middle), name, font=font, fill=_TEXT, anchor="lm")
    return _stamp(panel)


def lay_scale(frame: Pixels, pixels_per_metre: float, top: float, height: int) -> None:
    """Lay a bar of a round length in m under the caption: about a seventh of the frame's width.

    Args:
        frame: RGB, to be changed.
        pixels_per_metre: In the robot's plane.
        top: Its upper end, pixels.
        height: Of the picture, pixels; the font's size follows it.
    """
    wanted = frame.shape[1] / 7.0 / pixels_per_metre
    power = 10.0 ** np.floor(np.log10(wanted))
    length = max(digit * power for digit in _NICE if digit * power <= wanted * 1.01)
    lay(frame, _bar(f"{length:g} m", round(length * pixels_per_metre), letter_size(height)), _edge(height), top)


@lru_cache(maxsize=8)
def _bar(text: str, wide: int, size: float) -> Stamp:
    """A bar between two ticks, and its length over it."""
    tick, thick = 0.3 * size, max(1, round(size / 9))
    image = Image.new("RGBA", (max(wide, int(text_width(text, size))) + 2 * thick, int(2.2 * size)), (*_TEXT[:3], 0))
    draw = ImageDraw.Draw(image)
    draw.text((wide / 2, 0.65 * size), text, font=_font(size), fill=_TEXT, anchor="mm")
    middle = 1.65 * size
    draw.line((0, middle, wide, middle), fill=_TEXT, width=thick)
    for x in (thick / 2, wide - thick / 2):
        draw.line((x, middle - tick, x, middle + tick), fill=_TEXT, width=thick)
    return _stamp(image)


def draw_headline(frame: Pixels, text: str) -> Pixels:
    """Draw a line into the upper right corner.

    Args:
        frame: RGB, shape (height, width, 3).
        text: What is written.

    Returns:
        A copy with it.
    """
    written = frame.copy()
    lay_legend(written, (), frame.shape[0], headline=text)
    return written
