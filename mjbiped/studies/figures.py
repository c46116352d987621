"""Figures of a study: heat maps over pairs of varied parameters, lines over a single one, else histograms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure

from mjbiped.plotting import width
from mjbiped.plotting.panels import head, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import BLACK, BLUE, GROUND, GUIDE, VERMILLION, drawn, told_apart
from mjbiped.robots.compass import Array
from mjbiped.studies.bins import SHOWN, Axis, Drawing, drawings, known_of, measure_label, never_began
from mjbiped.studies.cell import Row
from mjbiped.studies.plan import FINISHED, Study

_MOST_TICKS = 8
_COLUMNS = 3
_BESIDE_MAP = 1.15  # labels and colour bar, inches
_SMALLEST = 5.0  # letters in a map, points
_LETTERS = 6  # of a number in a map
_MOST_NUMBERED = 7  # columns of a heat map that has its numbers written in
_LOG_RATIO = 30.0  # of greatest to least value, from which on a colour scale is logarithmic
_MAP = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.95, 256)))
_SHARES = (-0.03, 1.03)  # ends of an axis of shares


def draw(study: Study, rows: Sequence[Row], folder: Path) -> list[Path]:
    """Draw a study's figures, .png files.

    Args:
        study: The study, which names the varied parameters and the measures to show.
        rows: Rows of its table.
        folder: Folder of the files.

    Returns:
        The files.

    Raises:
        RenderError: A file cannot be written.
    """
    written = []
    for drawing in drawings(rows, study.plot_parameters or study.varied, study.plot_measures or SHOWN):
        written.append(folder / f"{drawing.name}.png")
        with drawn(written[-1]) as figure:
            _note(figure, rows, _KINDS[drawing.kind](drawing, figure))
    return written


def _panels(figure: Figure, measures: Sequence[str], height: float, groups: int = 1) -> Any:
    """Make a panel for each group and measure; places of the grid that are left over are removed."""
    columns = width().beside(min(len(measures), _COLUMNS))
    lines = math.ceil(len(measures) / columns)
    figure.set_figheight(0.6 + height * lines * groups)
    panels: Any = figure.subplots(lines * groups, columns, squeeze=False)
    for line, column in np.ndindex(lines * groups, columns):
        if line % lines * columns + column >= len(measures):
            panels[line, column].remove()
    return panels.reshape(groups, lines * columns)[:, : len(measures)]


def _maps(drawing: Drawing, figure: Figure) -> str:
    """Draw a heat map for each group (downwards) and measure (to the right)."""
    pair, groups = drawing.axes, drawing.groups
    panels = _panels(figure, [*drawing.measures], 3.1, groups.count)
    for place, (name, spreads) in enumerate(drawing.measures.items()):
        norm = _norm(spreads[:, 0], name)
        for axes, (table, _, _, count), kind in zip(panels[:, place], spreads, groups.ticks, strict=True):
            _draw_map(figure, axes, pair, table, norm)
            titled(axes, "", "\n".join(filter(None, (measure_label(name), plain(kind)))))
            if max(axis.count for axis in pair) <= _MOST_NUMBERED:
                _number(axes, pair, table, count, norm)
    return f"medians of those that finished{_in_bins(pair)}; grey: none; in brackets: number of walks"


def _in_bins(axes: Sequence[Axis]) -> str:
    return "" if all(axis.ticks for axis in axes) else ", in bins"


def _norm(tables: Array, name: str) -> Normalize:
    """Make one colour scale for all groups."""
    values = known_of(tables)
    if name == FINISHED or not values.size:
        return Normalize(0.0, 1.0)
    low, high = float(values.min()), float(values.max())
    return LogNorm(low, high) if low > 0.0 and high / low > _LOG_RATIO else Normalize(low, high)


def _draw_map(figure: Figure, axes: Axes, parameters: Sequence[Axis], table: Array, norm: Normalize) -> None:
    x, y = parameters
    axes.set_facecolor(GROUND)  # where nothing finished
    mesh = axes.pcolormesh(x.edges, y.edges, np.ma.masked_invalid(table), cmap=_MAP, norm=norm)
    figure.colorbar(mesh, ax=axes, pad=0.02)
    _set_scale(axes, x, "x")
    _set_scale(axes, y, "y")
    axes.spines[:].set_visible(True)


def _number(axes: Axes, parameters: Sequence[Axis], table: Array, counts: Array, norm: Normalize) -> None:
    """Write into each cell of a map its value and the number of walks, where there is room for them."""
    x, y = parameters
    across = axes.get_subplotspec()
    columns = 1 if across is None else across.get_gridspec().ncols
    room = 72.0 * (width().inches / columns - _BESIDE_MAP) / x.count  # points
    size = min(width().small, room / (0.7 * _LETTERS))
    if size < _SMALLEST:
        return
    for j, i in np.ndindex(table.shape):
        value = float(table[j, i])
        light = math.isnan(value) or float(np.dot(_MAP(norm(value))[:3], (0.299, 0.587, 0.114))) >= 0.5
        number = f"{value:#.3g}".removesuffix(".") if abs(value) < 1000.0 else f"{value:.0f}"
        text = "–" if math.isnan(value) else f"{number}\n({counts[j, i]:.0f})".replace("-", "−")
        look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": size, "color": BLACK if light else "white"}
        axes.text(float(x.centres[i]), float(y.centres[j]), text, **look)


def _set_scale(axes: Axes, axis: Axis, which: str) -> None:
    axes.set(**{f"{which}label": axis.label})
    if axis.ticks:
        shown = slice(None, None, math.ceil(axis.count / _MOST_TICKS))
        axes.set(**{f"{which}ticks": axis.centres[shown], f"{which}ticklabels": axis.ticks[shown]})
    elif axis.log:
        axes.set(**{f"{which}scale": "log"})


def _lines(drawing: Drawing, figure: Figure) -> str:
    """Draw the middle of each measure over a parameter, with the quartiles as a band; a line for each group."""
    (axis,), groups = drawing.axes, drawing.groups
    panels = _panels(figure, [*drawing.measures], 3.2)
    for axes, (name, spreads) in zip(panels[0], drawing.measures.items(), strict=True):
        for k, (kind, (middles, low, high, _)) in enumerate(zip(groups.ticks, spreads, strict=True)):
            colour, marker, style = told_apart(k)
            looks = {"color": colour, "linestyle": style, "marker": marker, "markersize": 3.5}
            axes.plot(axis.at, middles, label=plain(kind), **looks)
            axes.fill_between(axis.at, low, high, color=colour, alpha=0.2, linewidth=0)
        titled(axes, "", measure_label(name))
        none = np.isnan(spreads[:, 0]).all()  # a logarithmic scale of nothing is an error
        axes.set(xlabel=axis.label, xscale="log" if axis.log and not none else "linear")
        if name == FINISHED:
            axes.set_ylim(*_SHARES)
        elif none:
            _write_none(axes)
    if groups.count > 1:
        legend_below(figure, *panels[0, 0].get_legend_handles_labels())
    return f"medians of those that finished{_in_bins([axis])}; band: from the lower to the upper quartile"


def _groups(drawing: Drawing, figure: Figure) -> str:
    """Draw the middle of each measure for each group, and a line from quartile to quartile."""
    (groups,) = drawing.axes
    panels = _panels(figure, [*drawing.measures], 0.9 + 0.3 * groups.count)
    for axes, (name, [(middles, low, high, _)]) in zip(panels[0], drawing.measures.items(), strict=True):
        axes.plot(middles, groups.centres, "o", color=BLUE, markersize=4.5)
        axes.hlines(groups.centres, low, high, color=BLUE)
        axes.set(ylim=(groups.count, 0.0), xlabel=measure_label(name))
        if name == FINISHED:
            axes.set_xlim(*_SHARES)
        axes.set_yticks(groups.centres, [plain(kind) for kind in groups.ticks])
        axes.grid(axis="x", color=GROUND, linewidth=0.5)
        axes.tick_params(labelleft=axes.get_subplotspec().is_first_col())
    return "medians of those that finished; line: from the lower to the upper quartile"


def _histograms(drawing: Drawing, figure: Figure) -> str:
    """Draw histograms of the measures of walks that finished."""
    panels = _panels(figure, [*drawing.measures], 2.9)
    for axes, (name, values) in zip(panels[0], drawing.measures.items(), strict=True):
        if values.size:
            half = float(np.median(values))
            axes.hist(values, bins=int(np.clip(math.sqrt(values.size), 5, 40)), color=BLUE, edgecolor="white")
            axes.axvline(half, color=VERMILLION, linestyle="--", label=f"median {half:.4g}")
            axes.legend()
        else:
            _write_none(axes)
        axes.set(xlabel=measure_label(name), ylabel="walks")
    return "only those that finished are shown"


_KINDS = {"map": _maps, "line": _lines, "groups": _groups, "histograms": _histograms}
"""What draws a figure, and returns the meaning of its marks."""


def _write_none(axes: Axes) -> None:
    """Note in an empty panel that no walk finished."""
    axes.text(0.5, 0.5, "no walk finished", ha="center", transform=axes.transAxes, color=GUIDE)


def _note(figure: Figure, rows: Sequence[Row], meaning: str) -> None:
    """Write the number of walks and the meaning of the marks above the figure."""
    finished, failed = sum(row["outcome"] == FINISHED for row in rows), sum(map(never_began, rows))
    began = f", {failed} could not begin" if failed else ""
    head(figure, wrapped(f"{len(rows)} walks, {finished} finished{began}; {meaning}"))
