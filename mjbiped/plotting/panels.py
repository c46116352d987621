"""Titles and legends of panels, fitted to the width of the figure, and the lines of signals in them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase
from numpy.typing import NDArray

from mjbiped.plotting.style import C_MT, look
from mjbiped.plotting.width import width
from mjbiped.records.record import Walk
from mjbiped.records.signals import Lines, Signal, Values

_MARGIN = 0.62  # inches beside a panel, for the labels of its vertical axis
_MARGIN_OF_ONE_SCALE = 1.1  # beside a panel with one scale for both axes, which is narrower than its place
_PIXELS = 1.04
_GAP = 0.1  # between a title and a legend beside it, inches
_AS_WIDE = "\ue000" * 3  # stands for c_mt while lines are broken


def plain(text: str) -> str:
    """Escape a text that matplotlib must not read as a formula, such as a file's name."""
    return text.replace("$", r"\$")


def wrapped(text: str, *, lines: int | None = None) -> str:
    """Wrap a text into lines as wide as the figure, at most `lines` of them, without empty ones."""
    return _broken(text, width().letters(), lines)


def labelled(axes: Axes, text: str) -> None:
    """Label the horizontal axis of a panel that is as wide as the figure, in lines that fit."""
    axes.set_xlabel(_broken(text, width().letters(_MARGIN)))


def _broken(text: str, letters: int, lines: int | None = None) -> str:
    """Wrap a text, without a break in the symbol c_mt, which counts as wide as it is drawn."""
    parts = textwrap.wrap(text.replace(C_MT, _AS_WIDE), letters, max_lines=lines, placeholder=" ...")
    return "\n".join(parts).replace(_AS_WIDE, C_MT)


def head(figure: FigureBase, text: str) -> float:
    """Write a heading in small letters above the panels, and return its height, inches."""
    figure.suptitle(text, fontsize=width().font, x=0.01, ha="left", linespacing=1.4)
    return 1.4 * width().font / 72.0 * (1 + text.count("\n"))


def titled(axes: Axes, letter: str, words: str) -> None:
    """Give a panel its letter and its title, in lines that fit."""
    title = axes.set_title(f"({letter}) {words}" if letter else words)
    wide = _inches(title)
    if wide > _room(axes):
        lines = title.get_text().split("\n")
        longest = max(map(len, lines))
        fitting = max(10, int(longest * _room(axes) / wide))
        title.set_text("\n".join("\n".join(textwrap.wrap(line, fitting, break_long_words=False)) for line in lines))


def legend_above(axes: Axes, **settings: Any) -> None:
    """Draw a legend above a panel, at its right, below the title if they do not fit beside each other.

    Args:
        axes: The panel.
        **settings: Arguments of matplotlib's `legend`.
    """
    columns = 9
    settings |= {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.0, "columnspacing": 1.2}
    while True:
        legend = axes.legend(ncols=columns, **settings)
        columns = min(columns, len(legend.get_texts())) - 1
        if columns < 1 or _inches(legend) < _room(axes):
            break
    title = axes.set_title(axes.get_title(loc="left"))
    if _inches(title) + _GAP + _inches(legend) > _room(axes):
        axes.set_title(title.get_text(), pad=72.0 * legend.get_window_extent().height / legend.figure.dpi)


def legend_below(
    figure: FigureBase, handles: Sequence[Artist], names: Sequence[str] | None = None, **settings: object
) -> None:
    """Draw a legend under all panels, in as few lines as the figure's width allows."""
    names = [str(handle.get_label()) for handle in handles] if names is None else names
    for columns in range(len(handles), 0, -1):
        legend = figure.legend(handles, names, loc="outside lower center", ncols=columns, columnspacing=1.2, **settings)
        if columns == 1 or _inches(legend) < 0.97 * width().inches:
            return
        legend.remove()


def _room(axes: Axes) -> float:
    """Approximate width of a panel of the grid, inches."""
    share, spec = 1.0, axes.get_subplotspec()
    if spec is not None:
        grid = spec.get_gridspec()
        ratios: Any = grid.get_width_ratios() or [1.0] * grid.ncols
        share = sum(ratios[column] for column in spec.colspan) / sum(ratios)
    margin = _MARGIN if axes.get_aspect() == "auto" else _MARGIN_OF_ONE_SCALE
    return float(share * width().inches - margin)


def _inches(artist: Artist) -> float:
    """Width of an artist as drawn, inches, with a margin for letters that are fitted to coarser pixels."""
    return float(_PIXELS * artist.get_window_extent().width / artist.figure.dpi)


def curves_over_time(
    walk: Walk, lines: Lines, keep: slice | NDArray[np.int64] = slice(None)
) -> Iterator[tuple[str, Signal, Values, Values]]:
    """Make the curves of a panel, with a gap between steps where the values jump because the legs change roles.

    Args:
        walk: The record.
        lines: Signals of the panel.
        keep: Samples that are drawn.

    Yields:
        Name in `mjbiped.records.signals.SIGNALS`, signal, times (s) and values in the panel's unit.
    """
    time = walk.samples["time"][keep]
    steps = np.flatnonzero(np.diff(walk.samples["stance"][keep])) + 1
    gaps = steps if lines.panel.by_legs else steps[:0]
    for name, signal in lines.signals.items():
        values = np.insert(lines.values[name][keep], gaps, np.nan)
        yield name, signal, np.insert(time, gaps, time[gaps]), values


def draw_signals(axes: Axes, walk: Walk, lines: Lines, keep: slice = slice(None)) -> None:
    """Draw the signals of a panel over time (s), all samples or a part of them."""
    for name, signal, times, values in curves_over_time(walk, lines, keep):
        axes.plot(times, values, label=signal.label, **look(name))
