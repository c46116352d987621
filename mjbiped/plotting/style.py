"""How every figure of this package looks, and how it is written to a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, cast

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from mjbiped.errors import InputError, RenderError, shown
from mjbiped.utils.files import saved, written_whole

BLUE, ORANGE, VERMILLION, GREEN, BLACK = "#0072B2", "#E69F00", "#D55E00", "#009E73", "#000000"
"""Okabe and Ito's colours, told apart by colour-blind eyes; blue is darker than orange where print is grey."""

GROUND, SHADE, GUIDE = "#D9D4CB", "#4D4D4D", "#9A9A9A"
"""Ground, its outline and texts, helping lines."""

STANCE: Mapping[str, Any] = {"color": BLUE, "linestyle": "-"}
SWING: Mapping[str, Any] = {"color": ORANGE, "linestyle": (0, (4, 1.2))}
ANKLE, HIP = STANCE, {"color": VERMILLION, "linestyle": (0, (4, 1.2))}
TRUTH: Mapping[str, Any] = {"color": BLACK, "linestyle": (0, (1.5, 1.2))}
"""Lines differ in style as well as in colour."""

PLANNED: Mapping[str, Any] = {"color": "#9FD9C7", "linestyle": "-", "linewidth": 3.5, "zorder": 1.5}
"""A broad band of pale `GREEN` behind other lines: what follows it is seen on it, and where it leaves it."""

STYLE: Mapping[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "legend.fontsize": 8.0,
    "legend.frameon": True,
    "legend.framealpha": 0.85,
    "legend.edgecolor": "none",
    "lines.linewidth": 1.2,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "figure.dpi": 100.0,
    "savefig.dpi": 160.0,
    "pdf.fonttype": 42,  # letters that an editor can change
    "svg.fonttype": "path",
    "svg.hashsalt": "mjbiped",  # the same figure is the same file
}
"""matplotlib's settings (its own names) while a figure is made or written."""

SUFFIXES = (".png", ".pdf", ".svg")
"""Kinds of files that a figure can be written to."""

WIDTH = 9.6
"""Width of a figure, inches."""

_LAYOUT_DIGITS = 9
"""Digits of a panel's place, as a share of the figure. matplotlib's layout solver takes its equations in the order in
which they lie in memory, so digits 14 and beyond differ from run to run, and with them the bytes of the file."""

_DOTS_IN_NOTEBOOK = 80  # per inch: 768 pixels wide, where a notebook keeps each picture in its file
_COLOURS = 128  # of a small PNG's palette


def note_at(axes: Axes, text: str, x: float, height: float, offset: tuple[float, float], **look: Any) -> None:
    """Write beside a place of the horizontal axis.

    Args:
        axes: Where.
        text: What.
        x: Place on the axis, in its own unit.
        height: Place above its lower end, as a share of the panel's height; with xycoords="data" in the unit of the
            vertical axis.
        offset: Of the text from there, points.
        **look: As matplotlib's `annotate` takes it.
    """
    usual: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "fontsize": 8}
    axes.annotate(text, (x, height), offset, textcoords="offset points", **usual | look)


def widen(axes: Axes, least: float) -> None:
    """Give the vertical axis at least this span, in its own unit."""
    low, high = axes.get_ylim()
    if high - low < least:
        axes.set_ylim((low + high - least) / 2, (low + high + least) / 2)


@contextmanager
def styled() -> Iterator[None]:
    """The house's settings for a while; matplotlib's own are put back."""
    with matplotlib.rc_context(cast(Any, dict(STYLE))):
        yield


def new_figure(height: float = 1.0) -> Figure:
    """An empty figure of the house's width, `height` inches high, that leaves pyplot alone."""
    figure = NotebookFigure(figsize=(WIDTH, height), layout=_EvenLayout())
    FigureCanvasAgg(figure)
    return figure


class NotebookFigure(Figure):
    """A figure that a notebook shows, although pyplot, which would tell it how, is left alone."""

    def _repr_png_(self) -> bytes:
        """What a notebook shows."""
        return figure_png(self)


class _EvenLayout(ConstrainedLayoutEngine):
    """matplotlib's constrained layout with places of so few digits that they are the same in every run."""

    def execute(self, fig: Any) -> Any:
        """Lay out a figure; as matplotlib's own."""
        layout = super().execute(fig)
        for part in fig.subfigs:
            part.bbox_relative.set_points(part.bbox_relative.get_points().round(_LAYOUT_DIGITS))
        for axes in fig.axes:
            axes.set_position(np.round(axes.get_position(original=True).bounds, _LAYOUT_DIGITS))
            axes.set_in_layout(True)  # which set_position takes from it
        return layout


@contextmanager
def drawn(path: str | Path | None) -> Iterator[Figure]:
    """An empty figure, to be drawn in the block and given its height there; written when the block ends.

    Args:
        path: File to write, one of `SUFFIXES`; None: none.

    Raises:
        InputError: The path has another suffix; raised before the block is entered.
        RenderError: The file cannot be written.
    """
    path = None if path is None else Path(path)
    if path is not None and path.suffix.lower() not in SUFFIXES:
        raise InputError(f"a figure is a file of {', '.join(SUFFIXES)}; cannot draw to {shown(path.name)}")
    with styled():
        figure = new_figure()
        yield figure
    if path is not None:
        save_figure(figure, path)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as its path's suffix says; the file appears whole or not at all.

    Raises:
        RenderError: The file cannot be written.
    """
    kind = path.suffix.lower()[1:]
    dateless = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
    with styled(), saved(path, RenderError) as unfinished:
        figure.savefig(unfinished, format=kind, metadata=dateless)


def figure_png(figure: Figure) -> bytes:
    """A figure as a small PNG file's bytes, for a notebook."""
    whole, small = BytesIO(), BytesIO()
    with styled():
        figure.savefig(whole, format="png", dpi=_DOTS_IN_NOTEBOOK)
    _write_small(whole, small)
    return small.getvalue()


def make_small(path: Path) -> None:
    """Give a PNG file a palette: a third of the bytes, for a page."""
    with written_whole(path) as unfinished:
        _write_small(path, unfinished)


def _write_small(source: Path | BytesIO, target: Path | BytesIO) -> None:
    """Write a PNG file again, with a palette."""
    from PIL import Image  # imported where it is used: figures need not wait for it

    with Image.open(source) as picture:
        small = picture.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE)
    small.save(target, format="png", optimize=True)
