"""Look of every figure of this package, and writing of figures to files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from mjbiped.errors import InputError, RenderError, shown
from mjbiped.plotting import width
from mjbiped.records.signals import SIGNALS
from mjbiped.utils import palette
from mjbiped.utils.files import saved, written_whole

BLACK, BLUE, GREEN = palette.BLACK, palette.BLUE, palette.GREEN
ORANGE, VERMILLION = palette.ORANGE, palette.VERMILLION

GROUND, SHADE, GUIDE = "#D9D4CB", "#4D4D4D", "#9A9A9A"
"""Ground, its outline and texts, guide lines."""


LOOKS = (
    (BLACK, "o", "-"),
    (BLUE, "s", (0, (5, 1.2))),
    (ORANGE, "^", (0, (2, 1))),
    (GREEN, "D", (0, (4, 1, 1, 1))),
    (VERMILLION, "v", (0, (1, 1))),
    (SHADE, "P", (0, (6, 1, 1, 1, 1, 1))),
    (palette.SKY, "X", (0, (8, 2))),
    (palette.PURPLE, "*", (0, (3, 1, 3, 1, 1, 1))),
)
"""Colour, mark and line of curves that are told apart, in their order; each of the three does it by itself."""


def told_apart(number: int) -> tuple[str, str, object]:
    """Return colour, mark and line of a curve; they repeat after eight."""
    return LOOKS[number % len(LOOKS)]


def look(signal: str) -> dict[str, Any]:
    """Look of a signal of `mjbiped.records.signals.SIGNALS`, in matplotlib's own names."""
    row = SIGNALS[signal]
    return {"color": row.colour, "linestyle": row.line}


SWING = look("q_swing")
ESTIMATE, TRUTH = look("slope_estimate"), look("slope")
ANKLE, HIP = look("torque_ankle"), look("torque_hip")
"""Legs, slope under the stance foot (estimated and true) and torques have one look each in all figures of walks. Where
other things are told apart (gains, grounds), colours mean nothing else."""

MUJOCO: Mapping[str, Any] = {"color": palette.SKY, "linestyle": "-"}
HYBRID: Mapping[str, object] = {"color": SHADE, "linestyle": (0, (3, 1.5))}
"""Looks of the engines, where they are drawn over each other."""

PLANNED: Mapping[str, Any] = {"color": "#C4C4C4", "linestyle": "-", "linewidth": 3.5, "zorder": 1.5}
"""Broad grey band behind other lines, on which a line that follows it, or leaves it, is visible."""

C_MT = r"$c_\mathrm{mt}$"
"""The cost of mechanical transport, as every figure writes it."""

_SHEET = Path(__file__).with_name("figures.mplstyle")
"""Matplotlib's settings while a figure is made or written."""

SUFFIXES = (".png", ".pdf", ".svg")
"""Suffixes of figures' files."""

_LAYOUT_DIGITS = 9
"""Digits of a panel's place, as a share of the figure. matplotlib's layout solver takes its equations in the order in
which they lie in memory, so digits 14 and beyond differ from run to run, and with them the bytes of the file."""

_DOTS_IN_NOTEBOOK = 80  # per inch: 768 pixels wide, where a notebook keeps each picture in its file
_COLOURS = 128  # of a small PNG's palette


def note_at(axes: Axes, text: str, x: float, height: float, offset: tuple[float, float], **look: object) -> None:
    """Write a note beside a place.

    Args:
        axes: The panel.
        text: The note.
        x: Place on the horizontal axis, in its own unit.
        height: Place above its lower end, as a share of the panel's height; with xycoords="data" in the unit of the
            vertical axis.
        offset: Offset of the text from there, points.
        **look: Arguments of matplotlib's `annotate`.
    """
    usual: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "fontsize": width().small}
    axes.annotate(text, (x, height), offset, textcoords="offset points", **usual | look)


def zero_line(axes: Axes) -> None:
    """Draw a thin line at zero, behind everything else."""
    axes.axhline(0.0, color=GUIDE, linewidth=0.5, zorder=0)


def widen(axes: Axes, least: float) -> None:
    """Give the vertical axis at least this span, in its own unit."""
    low, high = axes.get_ylim()
    if high - low < least:
        axes.set_ylim((low + high - least) / 2, (low + high + least) / 2)


@contextmanager
def styled() -> Iterator[None]:
    """Apply this package's settings at the present `width` in a block, and restore matplotlib's."""
    now = width()
    sized = {
        **dict.fromkeys(("font.size", "axes.titlesize", "axes.labelsize"), now.font),
        **dict.fromkeys(("legend.fontsize", "xtick.labelsize", "ytick.labelsize"), now.small),
        "lines.linewidth": now.lines,
        "savefig.dpi": now.dots,
    }
    with style.context([_SHEET, sized]):
        yield


def new_figure(height: float = 1.0) -> Figure:
    """Make an empty figure of the present `width`, `height` inches high, without pyplot."""
    figure = NotebookFigure(figsize=(width().inches, height), layout=_EvenLayout())
    FigureCanvasAgg(figure)
    return figure


class NotebookFigure(Figure):
    """Figure that a notebook shows without the help of pyplot."""

    def _repr_png_(self) -> bytes:
        """Return the picture for a notebook."""
        return figure_png(self)


class _EvenLayout(ConstrainedLayoutEngine):
    """Constrained layout of matplotlib with rounded places, which are the same in every run."""

    def execute(self, fig: Any) -> Any:
        """Lay out a figure."""
        layout = super().execute(fig)
        for part in fig.subfigs:
            part.bbox_relative.set_points(part.bbox_relative.get_points().round(_LAYOUT_DIGITS))
        for axes in fig.axes:
            axes.set_position(np.round(axes.get_position(original=True).bounds, _LAYOUT_DIGITS))
            axes.set_in_layout(True)  # which set_position takes from it
        return layout


@contextmanager
def drawn(path: str | Path | None) -> Iterator[Figure]:
    """Make an empty figure that is drawn and given its height in a block, and written when the block ends.

    Args:
        path: File to write, with one of `SUFFIXES`; None writes no file.

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
    """Write a figure in the format of the path's suffix; the file appears whole or not at all.

    Raises:
        RenderError: The file cannot be written.
    """
    kind = path.suffix.lower()[1:]
    dateless = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
    with styled(), saved(path, RenderError) as unfinished:
        figure.savefig(unfinished, format=kind, metadata=dateless)


def figure_png(figure: Figure) -> bytes:
    """Return a figure as the bytes of a small PNG file, for a notebook."""
    whole, small = BytesIO(), BytesIO()
    with styled():
        figure.savefig(whole, format="png", dpi=_DOTS_IN_NOTEBOOK)
    _write_small(whole, small)
    return small.getvalue()


def make_small(path: Path) -> None:
    """Reduce a PNG file to a palette, a third of its bytes, for a page."""
    with written_whole(path) as unfinished:
        _write_small(path, unfinished)


def _write_small(source: Path | BytesIO, target: Path | BytesIO) -> None:
    """Write a PNG file with a palette."""
    from PIL import Image  # imported where it is used: figures need not wait for it

    with Image.open(source) as picture:
        small = picture.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE)
    small.save(target, format="png", optimize=True)
