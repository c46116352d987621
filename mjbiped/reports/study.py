"""Report of a study: maps over pairs of parameters, lines over one, histograms over none, from its table's folder."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.errors import InputError, RecordError
from mjbiped.plotting.style import BLACK, BLUE, GREEN, ORANGE, VERMILLION
from mjbiped.records.summary import MEASURES as LISTED
from mjbiped.records.summary import in_words, quantile_rows
from mjbiped.reports.page import UNIFIED, Panel, Shown, check_installed, curve, flattened, include, plotted, write_page
from mjbiped.robots.compass import Array
from mjbiped.studies.bins import SHOWN, Axis, Drawing, drawings, known_of, measure_label
from mjbiped.studies.cell import MEASURES, Row
from mjbiped.studies.plan import FINISHED
from mjbiped.studies.store import read_table
from mjbiped.studies.summary import summarised

TABLE = "study.sqlite"
"""File in a study's folder from which a report is made."""

MOST_ROWS = 3000
"""Greatest number of walks on the page; a study may have hundreds of thousands."""

_LOOKS = ((BLUE, "solid"), (VERMILLION, "dash"), (GREEN, "dot"), (ORANGE, "dashdot"), (BLACK, "longdash"))
_PANEL = 340  # pixels
_MEDIANS = "Medians of the walks that finished; the share is of all."
_LEAST_SPAN = 0.02  # of a measure's axis to either side, as a share of the greatest value
_MAP_GAP = 0.32  # between maps, of the width of a map with its gap: room for the colours' scale and labels


def report_study(folder: Path, path: Path) -> None:
    """Write the report of a study: one HTML page with outcomes, interactive figures and the table.

    Args:
        folder: Folder in which `mjbiped sweep` writes; it may still be running.
        path: The page.

    Raises:
        InputError: The folder holds no study, or none of its walks has ended; or Plotly or Jinja is not installed.
        RecordError: The study's table is damaged, or the page cannot be written.
    """
    check_installed()
    table = folder / TABLE
    if not table.is_file():
        raise InputError(f"{folder} holds no {TABLE}: expected a walk's record (.npz), or the folder of a sweep")
    rows, identity = read_table(table)
    if not rows:
        raise InputError(f"no walk of the study in {folder} has ended yet")
    varied = _checked(table, rows)
    summary = summarised(rows)
    declared = identity.get("study", {})
    names = [name for name in rows[0] if name not in MEASURES]
    headings = [*names, *(f"{each.label} ({each.unit})".removesuffix(" ()") for each in LISTED)]
    told = f"The first {MOST_ROWS} of {len(rows)}; all are in study.csv." if len(rows) > MOST_ROWS else ""
    write_page(
        path,
        "study.html",
        study_figures(rows, varied),
        {},
        title=folder.resolve().name,
        outcome=f"Study of {len(rows)} walks, {summary['outcomes'].get('finished', 0)} finished",
        outcome_headings=["outcome", "walks", "%"],
        outcomes=[[name, count, f"{100.0 * count / len(rows):.1f}"] for name, count in summary["verdicts"].items()],
        errors=[[each["error"], each["walks"], each["first_cell"]] for each in summary["errors"]],
        quantile_headings=["measure", *(f"{100 * q:g} %" for q in summary["quantiles"]), "unit"],
        quantiles=quantile_rows(summary["finished"]),
        table_note=f"Click a heading to sort by it. {told}".strip(),
        headings=headings,
        rows=[
            [*(_cell(row[name]) for name in names), *(in_words(row[m.key], m.factor, m.form) for m in LISTED)]
            for row in rows[:MOST_ROWS]
        ],
        parameters=list(flattened(declared)) if isinstance(declared, dict) else [],
        command=shlex.join(["mjbiped", "sweep", f"{folder}.toml", "--out", str(folder)]),
    )


def _checked(table: Path, rows: Sequence[Row]) -> list[str]:
    """Check the columns, and return those that vary.

    Raises:
        RecordError: The rows are not those of a study.
    """
    missing = [name for name in ("cell", "outcome", "error", *MEASURES) if name not in rows[0]]
    if missing:
        raise RecordError(f"{table} is no study's table of this mjbiped: it lacks {', '.join(missing)}")
    return [name for name in rows[0] if name not in ("cell", "sample", "outcome", "error", *MEASURES)]


def _cell(value: Any) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def study_figures(rows: Sequence[Row], varied: Sequence[str]) -> list[Shown]:
    """Draw the figures of a study.

    Args:
        rows: Rows of its table, at least one.
        varied: Names of the columns that vary.

    Raises:
        InputError: Plotly is not installed.
    """
    made = drawings(rows, varied, SHOWN)
    return [_KINDS[drawing.kind](drawing, number) for number, drawing in enumerate(made)]


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


def _maps(drawing: Drawing, number: int) -> Shown:
    """Draw a heat map for each group (downwards) and measure (to the right)."""
    (x, y), groups = drawing.axes, drawing.groups
    panels = dict[tuple[int, int], Panel]()
    for column, (name, spreads) in enumerate(drawing.measures.items()):
        tables = spreads[:, 0]
        known = known_of(tables)
        ends = (0.0, 1.0) if name == FINISHED or not known.size else (float(known.min()), float(known.max()))
        right = (column + 1 - _MAP_GAP) / (len(SHOWN) - _MAP_GAP)  # end of the column, as a share of the width
        scale = {"zmin": ends[0], "zmax": ends[1], "colorscale": "Viridis", "colorbar": {"x": right, "thickness": 10}}
        told = f"{x.label} %{{x:.4g}}<br>{y.label} %{{y:.4g}}<br>%{{z:.4g}}, of %{{customdata}} walks<extra></extra>"
        shown = [k for k, table in enumerate(tables) if not np.isnan(table).all()]
        for k, (table, _, _, count) in enumerate(spreads):
            places = {"x": x.centres, "y": y.centres, "z": table, "customdata": count.astype(int)}
            look = {"hovertemplate": told, "showscale": [k] == shown[:1], "showlegend": False, **scale}
            traces = [{"type": "heatmap", "name": "", **places, **look}] if k in shown else []
            words = "<br>".join(filter(None, (f"<b>{measure_label(name)}</b>", groups.ticks[k])))
            axes = _map_axis(x, k == groups.count - 1), _map_axis(y, column == 0)
            panels[k, column] = Panel(traces, *axes, words)
    gaps = {"xgap": _MAP_GAP, "ygap": 0.3}
    plot = plotted([panels[place] for place in sorted(panels)], columns=len(SHOWN), grid=gaps)
    title = f"{y.label} over {x.label}"
    return Shown(f"map-{number}", title, f"{_MEDIANS} White: none.", plot, 100 + _PANEL * groups.count)


def _lines(drawing: Drawing, _: int) -> Shown:
    """Draw the median of each measure over a parameter, with the quartiles as a band, a line for each group."""
    (axis,), groups, panels = drawing.axes, drawing.groups, list[Panel]()
    for name, spreads in drawing.measures.items():
        traces = list[dict[str, Any]]()
        for k, (kind, (middles, low, high, _)) in enumerate(zip(groups.ticks, spreads, strict=True)):
            colour, dash = _LOOKS[k % len(_LOOKS)]
            look = {"line": {"color": colour, "dash": dash}, "mode": "lines+markers"}
            band = {"fill": "toself", "fillcolor": colour, "opacity": 0.18, "line": {"width": 0}, "showlegend": False}
            if name != FINISHED:
                around = np.append(axis.at, axis.at[::-1]), np.append(high, low[::-1])
                traces.append({**curve("band", *around, **band), "legendgroup": kind or "all"})
            traces.append(curve(kind or "all", axis.at, middles, "%{y:.4g}", **look))
        x = {"type": "log" if axis.log else "linear", "title": {"text": axis.label}}
        panels.append(
            Panel(traces, x, {**_reach(name, spreads[:, :3]), "automargin": True}, f"<b>{measure_label(name)}</b>")
        )
    named = groups.count > 1
    plot = plotted(panels, shared=True, legend=1.05, grid={"ygap": 0.24}, showlegend=named, **UNIFIED)
    return Shown("line", f"Over {axis.label}", f"{_MEDIANS} Band: from quartile to quartile.", plot, 760)


def _groups(drawing: Drawing, _: int) -> Shown:
    """Draw the median of each measure of each group, and a bar from quartile to quartile."""
    (groups,), panels = drawing.axes, list[Panel]()
    for name, [(middles, low, high, _)] in drawing.measures.items():
        bars = {} if name == FINISHED else {"error_x": {"array": high - middles, "arrayminus": middles - low}}
        look = {"mode": "markers", "marker": {"size": 9, "color": BLUE}, "showlegend": False, **bars}
        dots = curve("", middles, list(groups.ticks), "%{y}: %{x:.4g}<extra></extra>", **look)
        x = {**_reach(name, middles), "title": {"text": measure_label(name)}}
        y = {"automargin": True, "autorange": "reversed", "showticklabels": not panels}
        panels.append(Panel([dots], x, y))
    plot = plotted(panels, columns=len(SHOWN), grid={"xgap": 0.12})
    note = f"{_MEDIANS} Bar: from quartile to quartile."
    return Shown("groups", groups.label.capitalize(), note, plot, 160 + 36 * groups.count)


def _histograms(drawing: Drawing, _: int) -> Shown:
    """Draw how often each measure has which value, of walks that finished."""
    panels = list[Panel]()
    for name, values in drawing.measures.items():
        bars = {"x": values, "marker": {"color": BLUE, "line": {"width": 1, "color": "white"}}}
        hover = {"showlegend": False, "hovertemplate": "%{x}: %{y} walks<extra></extra>"}
        x, y = ({"title": {"text": words}} for words in (measure_label(name), "walks"))
        panels.append(Panel([{"type": "histogram", "name": "", **bars, **hover}], x, y))
    plot = plotted(panels, columns=len(panels), grid={"xgap": 0.16})
    return Shown("histograms", "How often", "Of the walks that finished.", plot, 380)


_KINDS = {"map": _maps, "line": _lines, "groups": _groups, "histograms": _histograms}
"""What draws a figure; a map is numbered."""
