"""Captions drawn on frames: white text on a dark panel, in a font whose size follows the frame's."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Pixels = NDArray[np.uint8]

_HEIGHT = 1 / 26  # of the letters, per frame height: 18 pixels at 480
_SMALLEST = 7.0  # pixels; smaller letters cannot be read
_WIDEST = 0.54  # of the lines, per frame width
_WIDEST_HEADLINE = 0.36
_PANEL = (0, 0, 0, 150)
_TEXT = (255, 255, 255, 255)


@lru_cache(maxsize=8)
def _font(size: float, bold: bool) -> ImageFont.FreeTypeFont:
    """DejaVu Sans, which comes with matplotlib."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


@lru_cache(maxsize=32)
def _panel(lines: tuple[str, ...], width: int, height: int, bold: bool) -> Image.Image:
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
    return panel


def draw_caption(frame: Pixels, lines: Sequence[str], headline: str = "") -> Pixels:
    """Draw lines into the upper left corner, and a headline into the upper right one.

    Args:
        frame: RGB, shape (height, width, 3).
        lines: Top to bottom.
        headline: Larger; none where empty.

    Returns:
        A captioned copy.
    """
    height, width = frame.shape[:2]
    image = Image.fromarray(frame)
    edge = round(height * 0.02)
    if lines:
        panel = _panel(tuple(lines), width, height, bold=False)
        image.paste(panel, (edge, edge), panel)
    if headline:
        panel = _panel((headline,), width, height, bold=True)
        image.paste(panel, (width - panel.width - edge, edge), panel)
    return np.asarray(image)
