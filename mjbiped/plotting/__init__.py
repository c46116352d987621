"""Figures of walks, gaits and studies of them, and their widths: a page on the screen, or columns of a journal.

The widths stand here, apart from Matplotlib, which takes long to load: the command line's help names them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from mjbiped.utils.domains import known_name


@dataclass(frozen=True)
class Width:
    """Width of a figure, with the sizes of its letters and lines.

    Attributes:
        inches: Width of the figure, inches.
        font: Size of titles and labels of axes, points.
        small: Size of tick labels, legends and notes, points.
        lines: Width of lines, points.
        dots: Dots per inch of a PNG file, for a screen or for a journal.
        height: Height of the figure of a walk, inches; none where its panels say.
        panels: Panels of the figure of a walk unless others are named; none where its signals say.
    """

    inches: float
    font: float
    small: float
    lines: float
    dots: float
    height: float | None = None
    panels: tuple[str, ...] = ()

    def letters(self, beside: float = 0.2) -> int:
        """Number of letters in a line of text that leaves `beside` inches of the figure's width free.

        The mean width of a letter is 0.56 of its size.
        """
        return int(72.0 * (self.inches - beside) / (0.56 * self.font))

    def beside(self, count: int, least: float = 2.9) -> int:
        """Number of panels side by side, each at least `least` inches wide; the others stand below."""
        return max(1, min(count, int(self.inches / least)))


WIDTHS: Mapping[str, Width] = {
    "page": Width(9.6, 9.0, 8.0, 1.2, 160.0),
    "double": Width(7.16, 8.0, 7.0, 1.0, 300.0),
    "single": Width(3.5, 7.5, 7.0, 0.9, 300.0),
    "slide": Width(9.6, 10.0, 9.0, 1.4, 200.0, 5.4, ("lapse", "torque")),
}
"""Widths by name: the project's pages, both columns or one column of an IEEE journal, and a slide of 16:9."""

DEFAULT_WIDTH = "page"

_CURRENT: ContextVar[Width] = ContextVar("width", default=WIDTHS[DEFAULT_WIDTH])


def width() -> Width:
    """Return the width of the figures that are made now."""
    return _CURRENT.get()


@contextmanager
def figure_width(name: str) -> Iterator[None]:
    """Set the width of all figures in a block; panels that do not fit side by side stand below each other.

    `with figure_width("single"): plot_walk(walk, "walk.pdf")` draws a walk for one column of a journal, with letters of
    7 to 7.5 points where it is printed unscaled.

    Args:
        name: "page" (9.6 in), "double" (7.16 in), "single" (3.5 in) or "slide" (9.6 in, walks 16:9).

    Raises:
        InputError: There is no such width.
    """
    before = _CURRENT.set(WIDTHS[known_name("figure width", name, WIDTHS)])
    try:
        yield
    finally:
        _CURRENT.reset(before)
