"""Interactive figures of a study: heat maps over pairs of parameters, lines over one, histograms over none."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from mjbiped.plotting.style import BLACK, BLUE, GREEN, ORANGE, VERMILLION
from mjbiped.reports.page import Panels, Shown, shares, span
from mjbiped.sweeps.bins import SHOWN, Axis, arranged, measure_label, spread, tabulated, values_of
from mjbiped.sweeps.cell import Row
from mjbiped.sweeps.plan import FINISHED

_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, BLACK)
_DASHES = ("solid", "dash", "dot", "dashdot", "longdash")
_PANEL = 340  # pixels
_MEDIANS = "Medians of the walks that finished; the share is of all."
_SHARE = {"range": [-0.03, 1.03]}


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


def _maps(rows: Sequence[Row], pair: tuple[Axis, Axis], groups: Axis, number: int) -> Shown:
    """Draw a heat map for each group (downwards) and measure (to the right)."""
    x, y = pair
    panels = Panels()
    down = shares(groups.count, 0.3 / groups.count)[::-1]
    for name, across in zip(SHOWN, shares(len(SHOWN), 0.12), strict=True):
        drawn = [tabulated(pair, groups.bin == k, rows, name) for k in range(groups.count)]
        tables, counts = (np.array(each) for each in zip(*drawn, strict=True))
        known = tables[~np.isnan(tables)]
        ends = (0.0, 1.0) if name == FINISHED or not known.size else (float(known.min()), float(known.max()))
        first = next((k for k, table in enumerate(tables) if not np.isnan(table).all()), None)
        for k, (low, high) in enumerate(down):
            words = "<br>".join(filter(None, (f"<b>{measure_label(name)}</b>", groups.ticks[k])))
            axes = {"x": _map_axis(x, k == groups.count - 1), "y": _map_axis(y, name == SHOWN[0])}
            place = panels.add(across, (low, high), heading=words, **axes)
            if np.isnan(tables[k]).all():
                continue
            panels.figure.add_heatmap(
                x=x.centres,
                y=y.centres,
                z=tables[k],
                customdata=counts[k],
                zmin=ends[0],
                zmax=ends[1],
                colorscale="Viridis",
                showscale=k == first,
                colorbar={"x": across[1] + 0.005, "len": high - low, "y": high, "yanchor": "top", "thickness": 10},
                hovertemplate=f"{x.label} %{{x:.4g}}<br>{y.label} %{{y:.4g}}<br>%{{z:.4g}}, of %{{customdata}} "
                "walks<extra></extra>",
                **place,
            )
    title, note, height = f"{y.label} over {x.label}", f"{_MEDIANS} White: none.", 100 + _PANEL * groups.count
    return panels.shown(f"map-{number}", title, note, height, margin={"l": 80, "r": 40, "t": 60, "b": 60})


def _lines(rows: Sequence[Row], axis: Axis, groups: Axis) -> Shown:
    """Draw the median of each measure over a parameter, with the quartiles as a band, a line for each group."""
    panels = Panels()
    scale: dict[str, Any] = {"type": "log"} if axis.log else {}
    x: dict[str, Any] | None = {**scale, "title": {"text": axis.label}}
    for name, down in zip(SHOWN, shares(len(SHOWN), 0.08)[::-1], strict=True):
        values = values_of(rows, name)
        bins = [[values[axis.within(i, groups.bin == k)] for i in range(axis.count)] for k in range(groups.count)]
        spreads = [spread(group, name) for group in bins]
        reach = _SHARE if name == FINISHED else span(np.ravel(spreads))
        heading, first = f"<b>{measure_label(name)}</b>", name == SHOWN[0]
        place = panels.add(down=down, heading=heading, x=x if first else None, y={**reach, "automargin": True})
        looks = zip(groups.ticks, itertools.cycle(zip(_COLOURS, _DASHES, strict=True)), strict=False)
        for k, (kind, (colour, dash)) in enumerate(looks):
            at = {**place, "legendgroup": str(k)}
            middles, low, high = spreads[k]
            if name != FINISHED:
                panels.figure.add_scatter(
                    x=np.concatenate([axis.at, axis.at[::-1]]), y=np.concatenate([high, low[::-1]]), fill="toself",
                    fillcolor=colour, opacity=0.18, line={"width": 0}, mode="lines", hoverinfo="skip",
                    showlegend=False, **at,
                )  # fmt: skip
            panels.figure.add_scatter(
                x=axis.at, y=middles, mode="lines+markers", name=kind or "all",
                line={"color": colour, "dash": dash}, showlegend=first and groups.count > 1,
                hovertemplate="%{y:.4g}", **at,
            )  # fmt: skip
    return panels.shown(
        "line",
        f"Over {axis.label}",
        f"{_MEDIANS} Band: from quartile to quartile.",
        760,
        hovermode="x unified",
        hoversubplots="axis",
        legend=1.05,
        margin={"l": 80, "r": 20, "t": 70, "b": 60},
    )


def _groups(rows: Sequence[Row], groups: Axis) -> Shown:
    """Draw the median of each measure of each group, and a bar from quartile to quartile."""
    panels = Panels()
    for name, across in zip(SHOWN, shares(len(SHOWN), 0.04), strict=True):
        values = values_of(rows, name)
        middles, low, high = spread([values[groups.bin == k] for k in range(groups.count)], name)
        bars = {} if name == FINISHED else {"error_x": {"array": high - middles, "arrayminus": middles - low}}
        x = {**(_SHARE if name == FINISHED else span(middles)), "title": {"text": measure_label(name)}}
        y = {"automargin": True, "autorange": "reversed", "showticklabels": name == SHOWN[0]}
        panels.figure.add_scatter(
            x=middles, y=list(groups.ticks), mode="markers", marker={"size": 9, "color": BLUE}, showlegend=False,
            hovertemplate="%{y}: %{x:.4g}<extra></extra>", **panels.add(across, x=x, y=y), **bars,
        )  # fmt: skip
    note = f"{_MEDIANS} Bar: from quartile to quartile."
    return panels.shown("groups", groups.label.capitalize(), note, 160 + 36 * groups.count)


def _histograms(rows: Sequence[Row]) -> Shown:
    """Draw how often each measure has which value, of walks that finished."""
    panels = Panels()
    drawn = [name for name in SHOWN if name != FINISHED]
    for name, across in zip(drawn, shares(len(drawn), 0.08), strict=True):
        values = values_of(rows, name)
        place = panels.add(across, x={"title": {"text": measure_label(name)}}, y={"title": {"text": "walks"}})
        panels.figure.add_histogram(
            x=values[~np.isnan(values)], marker={"color": BLUE, "line": {"width": 1, "color": "white"}},
            showlegend=False, hovertemplate="%{x}: %{y} walks<extra></extra>", **place,
        )  # fmt: skip
    return panels.shown("histograms", "How often", "Of the walks that finished.", 380)
