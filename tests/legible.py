"""Whether a figure can be read where it is printed: what every test of a figure's layout asks."""

import os
import re
from itertools import combinations

import golden_numbers
from matplotlib.figure import Figure
from matplotlib.text import Text

from mjbiped.plotting import WIDTHS

DPI = 160.0  # of the files, to whose pixels letters are fitted
ROUNDING = 1.0  # pixels


def assert_legible(figure: Figure, name: str, *, smallest: float = 7.0) -> None:
    """The figure has the width of that name; its letters are of its size, inside, apart; panels differ in letters.

    In print, a figure also is what it was.

    Args:
        figure: Any.
        name: Of the width.
        smallest: Letters in print, points.
    """
    assert figure.get_size_inches()[0] == WIDTHS[name].inches
    figure.set_dpi(DPI)
    figure.draw_without_rendering()
    boxes = [(text, text.get_window_extent()) for text in texts(figure)]
    width, height = figure.get_size_inches() * DPI
    for text, box in boxes:
        words = text.get_text()
        assert -ROUNDING < box.x0 < box.x1 < width + ROUNDING, words
        assert -ROUNDING < box.y0 < box.y1 < height + ROUNDING, words
        assert "c_mt" not in words, words
        if name in ("double", "single"):  # in print
            assert smallest <= float(text.get_fontsize()) <= 8.0, words
    for (one, first), (other, second) in combinations(boxes, 2):
        across = min(first.x1, second.x1) - max(first.x0, second.x0)
        up = min(first.y1, second.y1) - max(first.y0, second.y0)
        assert min(across, up) <= ROUNDING, (one.get_text(), other.get_text())
    letters = [found for axes in figure.axes for found in re.findall(r"^\((\w)\)", axes.get_title(loc="left"))]
    assert letters == sorted(set(letters))
    if name != "slide":
        test = os.environ["PYTEST_CURRENT_TEST"].removesuffix(" (call)")
        golden_numbers.check(test, golden_numbers.of_figure(figure))


def texts(figure: Figure) -> list[Text]:
    """All that is shown: no empty text, and no label of a tick that lies outside its axis."""
    hidden = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            room = 1e-9 * (high - low)
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if not low - room <= tick.get_loc() <= high + room:
                    hidden |= {tick.label1, tick.label2}
    found = figure.findobj(Text)
    return [text for text in found if text.get_text().strip() and text.get_visible() and text not in hidden]
