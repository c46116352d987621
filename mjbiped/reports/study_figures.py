"""The interactive figures of a study: heat maps over pairs of what varies, lines over one, histograms over none."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from mjbiped.plotting.style import BLACK, BLUE, GREEN, ORANGE, VERMILLION
from mjbiped.reports.figures import AXIS, HEADING, Shown, layout, span
from mjbiped.sweeps.bins import (
    MOST_VALUES,
    Axis,
    binned,
    chosen,
    grouped,
    measure_label,
    middle,
    quartiles,
    values_of,
    without_seeds,
)
from mjbiped.sweeps.cell import Row
from mjbiped.sweeps.plan import FINISHED
from mjbiped.utils.extras import needed

MEASURES = ("cost_of_transport", FINISHED, "peak_ankle_torque_Nm")

_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, BLACK)
_DASHES = ("solid", "dash", "dot", "dashdot", "longdash")
_PANEL = 340  # pixels
_WALKS_IN_BIN = 12  # at least, in the mean
_FEWEST_BINS = 3
_MEDIANS = "Medians of the walks that finished; the share is of all."


def study_figures(rows: Sequence[Row], varied: Sequence[str]) -> list[Shown]:
    """The figures of a study's rows.

    Args:
        rows: Of its table, one at least.
        varied: Names of the columns that vary.

    Raises:
        InputError: Plotly is not installed.
    """
    graphs = needed("plotly.graph_objects", "report", "a report")
    numeric, named = chosen(rows, without_seeds(varied))
    groups = grouped(rows, named)
    each = len(rows) / groups.count

    def axis(name: str, most: float) -> Axis:
        return binned(rows, name, int(np.clip(most, _FEWEST_BINS, MOST_VALUES)))

    if len(numeric) > 1:
        most = math.sqrt(each / _WALKS_IN_BIN)
        return [
            _maps(graphs, rows, (axis(x, most), axis(y, most)), groups, number)
            for number, (x, y) in enumerate(itertools.combinations(numeric, 2))
        ]
    if numeric:
        return [_lines(graphs, rows, axis(numeric[0], each / _WALKS_IN_BIN), groups)]
    if named:
        return [_groups(graphs, rows, groups)]
    return [_histograms(graphs, rows)]


def _shares(count: int, gap: float) -> list[tuple[float, float]]:
    """So many equal parts of a figure's width or height, with gaps between."""
    size = (1.0 - gap * (count - 1)) / count
    return [(k * (size + gap), k * (size + gap) + size) for k in range(count)]


def _number(k: int) -> str:
    return str(k + 1) if k else ""


def _scale(axis: Axis) -> dict[str, Any]:
    """A plotly axis over bins."""
    if axis.ticks:
        return {"tickvals": axis.centres.tolist(), "ticktext": list(axis.ticks)}
    return {"type": "log"} if axis.log else {}


def _maps(graphs: Any, rows: Sequence[Row], pair: tuple[Axis, Axis], groups: Axis, number: int) -> Shown:
    """A heat map for each group (downwards) and measure (to the right)."""
    x, y = pair
    there = (x.bin >= 0) & (y.bin >= 0)
    shown = [k for k in range(groups.count) if (there & (groups.bin == k)).any()]
    figure = graphs.Figure()
    axes: dict[str, Any] = {}
    across, down = _shares(len(MEASURES), 0.12), _shares(len(shown), 0.3 / len(shown))[::-1]
    for column, name in enumerate(MEASURES):
        values = values_of(rows, name)
        bins = [
            [[values[(groups.bin == k) & (x.bin == i) & (y.bin == j)] for i in range(x.count)] for j in range(y.count)]
            for k in shown
        ]
        tables = np.array([[[middle(cell, name) for cell in line] for line in table] for table in bins])
        counts = np.array([[[(~np.isnan(cell)).sum() for cell in line] for line in table] for table in bins])
        known = tables[~np.isnan(tables)]
        ends = (0.0, 1.0) if name == FINISHED else (float(known.min()), float(known.max())) if known.size else (0, 1)
        with_scale = True
        for line, k in enumerate(shown):
            place, last = line * len(MEASURES) + column, line == len(shown) - 1
            low, high = down[line]
            if not np.isnan(tables[line]).all():
                figure.add_heatmap(
                    x=x.centres,
                    y=y.centres,
                    z=tables[line],
                    customdata=counts[line],
                    zmin=ends[0],
                    zmax=ends[1],
                    colorscale="Viridis",
                    showscale=with_scale,
                    colorbar={"x": across[column][1] + 0.005, "len": high - low, "y": high, "yanchor": "top",
                              "thickness": 10},
                    hovertemplate=f"{x.label} %{{x:.4g}}<br>{y.label} %{{y:.4g}}<br>%{{z:.4g}}, of %{{customdata}} "
                    "walks<extra></extra>",
                    xaxis=f"x{_number(place)}",
                    yaxis=f"y{_number(place)}",
                )  # fmt: skip
                with_scale = False
            axes[f"xaxis{_number(place)}"] = {
                **AXIS, **_scale(x), "domain": across[column], "anchor": f"y{_number(place)}",
                "title": {"text": x.label if last else ""}, "showgrid": False, "range": _reach(x),
            }  # fmt: skip
            axes[f"yaxis{_number(place)}"] = {
                **AXIS, **_scale(y), "domain": [low, high], "anchor": f"x{_number(place)}",
                "title": {"text": "" if column else y.label}, "showgrid": False, "range": _reach(y),
            }  # fmt: skip
            words = "<br>".join(filter(None, (f"<b>{measure_label(name)}</b>", groups.ticks[k])))
            figure.add_annotation(text=words, x=across[column][0], y=high, xref="paper", yref="paper", **HEADING)
    figure.update_layout(layout(**axes, margin={"l": 80, "r": 40, "t": 60, "b": 60}))
    title = f"{y.label} over {x.label}"
    return Shown(f"map-{number}", title, f"{_MEDIANS} White: none.", figure, 100 + _PANEL * len(shown))


def _reach(axis: Axis) -> list[float]:
    """The ends of a plotly axis over bins."""
    ends = axis.edges[[0, -1]]
    return (np.log10(ends) if axis.log and not axis.ticks else ends).tolist()  # type: ignore[no-any-return]


def _lines(graphs: Any, rows: Sequence[Row], axis: Axis, groups: Axis) -> Shown:
    """The middle of each measure over a parameter, with the quartiles as a band, a line for each group."""
    figure = graphs.Figure()
    axes: dict[str, Any] = {}
    heights = _shares(len(MEASURES), 0.08)[::-1]
    for row, name in enumerate(MEASURES):
        values = values_of(rows, name)
        styles = zip(groups.ticks, itertools.cycle(zip(_COLOURS, _DASHES, strict=True)), strict=False)
        for k, (kind, (colour, dash)) in enumerate(styles):
            bins = [values[(groups.bin == k) & (axis.bin == i)] for i in range(axis.count)]
            low, high = np.array([quartiles(each) for each in bins]).T
            at = {"yaxis": f"y{_number(row)}", "legendgroup": str(k)}
            if name != FINISHED:
                figure.add_scatter(
                    x=np.concatenate([axis.at, axis.at[::-1]]), y=np.concatenate([high, low[::-1]]), fill="toself",
                    fillcolor=colour, opacity=0.18, line={"width": 0}, mode="lines", hoverinfo="skip",
                    showlegend=False, **at,
                )  # fmt: skip
            figure.add_scatter(
                x=axis.at, y=[middle(each, name) for each in bins], mode="lines+markers", name=kind or "all",
                line={"color": colour, "dash": dash}, showlegend=row == 0 and groups.count > 1,
                hovertemplate="%{y:.4g}", **at,
            )  # fmt: skip
        drawn = np.concatenate([trace.y for trace in figure.data if trace.yaxis == f"y{_number(row)}"]).astype(float)
        reach = {"range": [-0.03, 1.03]} if name == FINISHED else span(drawn)
        axes[f"yaxis{_number(row)}"] = {**AXIS, **reach, "domain": heights[row], "anchor": "x", "automargin": True}
        figure.add_annotation(
            text=f"<b>{measure_label(name)}</b>", x=0.0, y=heights[row][1], xref="paper", yref="paper", **HEADING
        )
    scale = {"type": "log"} if axis.log else {}
    figure.update_layout(
        layout(
            **axes,
            xaxis={**AXIS, **scale, "title": {"text": axis.label}, "anchor": f"y{_number(len(MEASURES) - 1)}"},
            hovermode="x unified",
            hoversubplots="axis",
            legend={"orientation": "h", "yanchor": "bottom", "y": 1.05, "xanchor": "left", "x": 0.0},
            margin={"l": 80, "r": 20, "t": 70, "b": 60},
        )
    )
    return Shown("line", f"Over {axis.label}", f"{_MEDIANS} Band: from quartile to quartile.", figure, 760)


def _groups(graphs: Any, rows: Sequence[Row], groups: Axis) -> Shown:
    """The middle of each measure of each group, and a bar from quartile to quartile."""
    figure = graphs.Figure()
    axes: dict[str, Any] = {}
    across = _shares(len(MEASURES), 0.04)
    for column, name in enumerate(MEASURES):
        values = values_of(rows, name)
        bins = [values[groups.bin == k] for k in range(groups.count)]
        middles = np.array([middle(each, name) for each in bins])
        low, high = np.array([quartiles(each) for each in bins]).T
        bars = {} if name == FINISHED else {"error_x": {"array": high - middles, "arrayminus": middles - low}}
        figure.add_scatter(
            x=middles, y=list(groups.ticks), mode="markers", marker={"size": 9, "color": BLUE}, showlegend=False,
            xaxis=f"x{_number(column)}", hovertemplate="%{y}: %{x:.4g}<extra></extra>", **bars,
        )  # fmt: skip
        axes[f"xaxis{_number(column)}"] = {
            **AXIS, **({"range": [-0.03, 1.03]} if name == FINISHED else span(middles)), "domain": across[column],
            "anchor": "y", "title": {"text": measure_label(name)},
        }  # fmt: skip
    figure.update_layout(layout(**axes, yaxis={**AXIS, "automargin": True, "autorange": "reversed"}))
    note = f"{_MEDIANS} Bar: from quartile to quartile."
    return Shown("groups", groups.label.capitalize(), note, figure, 160 + 36 * groups.count)


def _histograms(graphs: Any, rows: Sequence[Row]) -> Shown:
    """How often each measure has which value, of walks that finished."""
    figure = graphs.Figure()
    axes: dict[str, Any] = {}
    shown = [name for name in MEASURES if name != FINISHED]
    for column, (name, share) in enumerate(zip(shown, _shares(len(shown), 0.08), strict=True)):
        values = values_of(rows, name)
        figure.add_histogram(
            x=values[~np.isnan(values)], marker={"color": BLUE, "line": {"width": 1, "color": "white"}},
            showlegend=False, xaxis=f"x{_number(column)}", yaxis=f"y{_number(column)}",
            hovertemplate="%{x}: %{y} walks<extra></extra>",
        )  # fmt: skip
        axes[f"xaxis{_number(column)}"] = {
            **AXIS, "domain": share, "anchor": f"y{_number(column)}", "title": {"text": measure_label(name)},
        }  # fmt: skip
        axes[f"yaxis{_number(column)}"] = {**AXIS, "anchor": f"x{_number(column)}", "title": {"text": "walks"}}
    figure.update_layout(layout(**axes))
    return Shown("histograms", "How often", "Of the walks that finished.", figure, 380)
