"""How wide figures are: of a page on the screen, or of one or two columns of a journal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from mjbiped.utils.domains import known_name


@dataclass(frozen=True)
class Width:
    """The width of a figure, and how large its letters are at that width.

    Attributes:
        inches: Of the figure.
        font: Titles and labels of axes, points.
        small: Tick labels, legends and notes, points.
        lines: Width of lines, points.
        dots: Of a PNG file, per inch: what a screen can show, or what journals ask for.
    """

    inches: float
    font: float
    small: float
    lines: float
    dots: float

    def letters(self, beside: float = 0.2) -> int:
        """Letters of a line of text that leaves so many inches of the figure's width free.

        A letter is 0.56 of its size wide in the mean.
        """
        return int(72.0 * (self.inches - beside) / (0.56 * self.font))

    def beside(self, count: int, least: float = 2.9) -> int:
        """How many of some panels stand side by side, each at least so many inches wide; the others go below."""
        return max(1, min(count, int(self.inches / least)))


WIDTHS: Mapping[str, Width] = {
    "page": Width(9.6, 9.0, 8.0, 1.2, 160.0),
    "double": Width(7.16, 8.0, 7.0, 1.0, 300.0),
    "single": Width(3.5, 7.5, 7.0, 0.9, 300.0),
}
"""By name: the project's pages, and both columns or one column of a journal as IEEE sets it."""

DEFAULT_WIDTH = "page"

_CURRENT: ContextVar[Width] = ContextVar("width", default=WIDTHS[DEFAULT_WIDTH])


def width() -> Width:
    """The width of the figures that are made now."""
    return _CURRENT.get()


@contextmanager
def figure_width(name: str) -> Iterator[None]:
    """Make all figures in the block so wide; panels that do not fit side by side stand below each other.

    `with figure_width("single"): plot_walk(walk, "walk.pdf")` draws a walk for one column of a journal, with letters of
    7 to 7.5 points where it is printed unscaled.

    Args:
        name: "page" (9.6 in), "double" (7.16 in) or "single" (3.5 in).

    Raises:
        InputError: There is no such width.
    """
    before = _CURRENT.set(WIDTHS[known_name("figure width", name, WIDTHS)])
    try:
        yield
    finally:
        _CURRENT.reset(before)
