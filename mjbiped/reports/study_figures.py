"""Interactive figures of a study: heat maps over pairs of parameters, lines over one, histograms over none."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from mjbiped.plotting.style import BLACK, BLUE, GREEN, ORANGE, VERMILLION
from mjbiped.reports.page import LEGEND, Panel, Shown, include, plotted
from mjbiped.robots.compass import Array
from mjbiped.sweeps.bins import SHOWN, Axis, arranged, measure_label, spread, tabulated, values_of
from mjbiped.sweeps.cell import Row
from mjbiped.sweeps.plan import FINISHED

_LOOKS = ((BLUE, "solid"), (VERMILLION, "dash"), (GREEN, "dot"), (ORANGE, "dashdot"), (BLACK, "longdash"))
_PANEL = 340  # pixels
_MEDIANS = "Medians of the walks that finished; the share is of all."
_LEAST_SPAN = 0.02  # of a measure's axis to either side, as a share of the greatest value
_MAP_GAP = 0.32  # between maps, of the width of a map with its gap: room for the colours' scale and labels


def study_figures(rows: Sequence[Row], varied: Sequence[str]) -> list[Shown]:
    """Draw the figures of a study.

    Args:
        rows: Rows of its table, at least one.
        varied: Names of the columns that vary.

    Raises:
        InputError: Plotly is not installed.
    """
    axes, groups = arranged(rows, varied)
    if len(axes) > 1:
        pairs = enumerate(itertools.combinations(axes, 2))
        return [_maps(rows, pair, groups, number) for number, pair in pairs]
    if axes:
        return [_lines(rows, axes[0], groups)]
    return [_groups(rows, groups) if groups.name else _histograms(rows)]


def _scale(axis: Axis) -> dict[str, object]:
    """Settings of a plotly axis over bins, without its range."""
    if axis.ticks:
        return {"tickvals": axis.centres.tolist(), "ticktext": list(axis.ticks)}
    return {"type": "log"} if axis.log else {}


def _map_axis(axis: Axis, titled: bool) -> dict[str, object]:
    """Settings of a plotly axis of a map."""
    ends = axis.edges[[0, -1]]
    ends = np.log10(ends) if axis.log and not axis.ticks else ends
    title = {"text": axis.label if titled else ""}
    return {**_scale(axis), "title": title, "showgrid": False, "range": ends.tolist()}


def _reach(name: str, values: Array) -> dict[str, object]:
    """Range of the axis of a measure: all shares, or values so far apart that rounding does not fill the panel."""
    least = 2.0 * _LEAST_SPAN * float(np.nanmax(np.abs(values), initial=0.0))
    return {"range": [-0.03, 1.03]} if name == FINISHED else include(values, least)


def _maps(rows: Sequence[Row], pair: tuple[Axis, Axis], groups: Axis, number: int) -> Shown:
    """Draw a heat map for each group (downwards) and measure (to the right)."""
    x, y = pair
    panels = dict[tuple[int, int], Panel]()
    for column, name in enumerate(SHOWN):
        drawn = [tabulated(pair, groups.bin == k, rows, name) for k in range(groups.count)]
        known = np.concatenate([table[~np.isnan(table)] for table, _ in drawn])
        ends = (0.0, 1.0) if name == FINISHED or not known.size else (float(known.min()), float(known.max()))
        right = (column + 1 - _MAP_GAP) / (len(SHOWN) - _MAP_GAP)  # end of the column, as a share of the width
        scale = {"zmin": ends[0], "zmax": ends[1], "colorscale": "Viridis", "colorbar": {"x": right, "thickness": 10}}
        bare = True
        for k, (table, count) in enumerate(drawn):
            hover = (
                f"{x.label} %{{x:.4g}}<br>{y.label} %{{y:.4g}}<br>%{{z:.4g}}, of %{{customdata}} walks<extra></extra>"
            )
            cells = {"type": "heatmap", "x": x.centres, "y": y.centres, "z": table, "customdata": count}
            traces = [] if np.isnan(table).all() else [{**cells, **scale, "hovertemplate": hover, "showscale": bare}]
            bare = bare and not traces
            words = "<br>".join(filter(None, (f"<b>{measure_label(name)}</b>", groups.ticks[k])))
            axes = _map_axis(x, k == groups.count - 1), _map_axis(y, column == 0)
            panels[k, column] = Panel(traces, *axes, words)
    gaps = {"xgap": _MAP_GAP, "ygap": 0.3}
    looks: dict[str, Any] = {"grid": gaps, "margin": {"l": 80, "r": 40, "t": 60, "b": 60}}
    plot = plotted([panels[place] for place in sorted(panels)], columns=len(SHOWN), **looks)
    title = f"{y.label} over {x.label}"
    return Shown(f"map-{number}", title, f"{_MEDIANS} White: none.", plot, 100 + _PANEL * groups.count)


def _lines(rows: Sequence[Row], axis: Axis, groups: Axis) -> Shown:
    """Draw the median of each measure over a parameter, with the quartiles as a band, a line for each group."""
    panels = list[Panel]()
    for name in SHOWN:
        values, traces = values_of(rows, name), list[dict[str, Any]]()
        bins = [[values[axis.within(i, groups.bin == k)] for i in range(axis.count)] for k in range(groups.count)]
        spreads = np.array([spread(group, name) for group in bins])
        for k, (kind, (middles, low, high)) in enumerate(zip(groups.ticks, spreads, strict=True)):
            colour, dash = _LOOKS[k % len(_LOOKS)]
            band = {"x": np.append(axis.at, axis.at[::-1]), "y": np.append(high, low[::-1]), "fill": "toself"}
            faint = {"fillcolor": colour, "opacity": 0.18, "line": {"width": 0}, "hoverinfo": "skip"}
            middle = {"x": axis.at, "y": middles, "line": {"color": colour, "dash": dash}, "mode": "lines+markers"}
            named = {"name": kind or "all", "showlegend": not panels and groups.count > 1, "hovertemplate": "%{y:.4g}"}
            group = {"legendgroup": str(k)}
            traces += [] if name == FINISHED else [{**band, **faint, **group, "showlegend": False}]
            traces.append({**middle, **named, **group})
        scale = {"type": "log"} if axis.log else {}
        y = {**_reach(name, spreads), "automargin": True}
        panels.append(Panel(traces, {**scale, "title": {"text": axis.label}}, y, f"<b>{measure_label(name)}</b>"))
    hover = {"hovermode": "x unified", "hoversubplots": "axis"}
    looks: dict[str, Any] = {"legend": {**LEGEND, "y": 1.05}, "margin": {"l": 80, "r": 20, "t": 70, "b": 60}, **hover}
    plot = plotted(panels, shared=True, grid={"ygap": 0.24}, **looks)
    return Shown("line", f"Over {axis.label}", f"{_MEDIANS} Band: from quartile to quartile.", plot, 760)


def _groups(rows: Sequence[Row], groups: Axis) -> Shown:
    """Draw the median of each measure of each group, and a bar from quartile to quartile."""
    panels = list[Panel]()
    for name in SHOWN:
        values = values_of(rows, name)
        middles, low, high = spread([values[groups.bin == k] for k in range(groups.count)], name)
        bars = {} if name == FINISHED else {"error_x": {"array": high - middles, "arrayminus": middles - low}}
        dots = {"x": middles, "y": list(groups.ticks), "mode": "markers", "marker": {"size": 9, "color": BLUE}, **bars}
        x = {**_reach(name, middles), "title": {"text": measure_label(name)}}
        y = {"automargin": True, "autorange": "reversed", "showticklabels": not panels}
        hover = {"showlegend": False, "hovertemplate": "%{y}: %{x:.4g}<extra></extra>"}
        panels.append(Panel([{**dots, **hover}], x, y))
    plot = plotted(panels, columns=len(SHOWN), grid={"xgap": 0.12})
    note = f"{_MEDIANS} Bar: from quartile to quartile."
    return Shown("groups", groups.label.capitalize(), note, plot, 160 + 36 * groups.count)


def _histograms(rows: Sequence[Row]) -> Shown:
    """Draw how often each measure has which value, of walks that finished."""
    panels = list[Panel]()
    for name in SHOWN:
        if name != FINISHED:
            values = values_of(rows, name)
            bars = {"x": values[~np.isnan(values)], "marker": {"color": BLUE, "line": {"width": 1, "color": "white"}}}
            hover = {"showlegend": False, "hovertemplate": "%{x}: %{y} walks<extra></extra>"}
            x, y = ({"title": {"text": words}} for words in (measure_label(name), "walks"))
            panels.append(Panel([{"type": "histogram", **bars, **hover}], x, y))
    plot = plotted(panels, columns=len(panels), grid={"xgap": 0.16})
    return Shown("histograms", "How often", "Of the walks that finished.", plot, 380)
