"""One HTML file with everything that it needs: interactive figures in panels, style, programs, video."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.plotting.style import GUIDE, SHADE
from mjbiped.records.signals import DASH_DOTTED, DASHED, DOTTED, SIGNALS, SOLID
from mjbiped.utils.files import saved
from mjbiped.utils.packages import needed
from mjbiped.version import __version__

_HERE = Path(__file__).parent / "page"
_DASHES = {SOLID: "solid", DASHED: "dash", DOTTED: "dot", DASH_DOTTED: "dashdot"}
ABOVE, BELOW = 70, 60
"""Margins of a figure, for its legend and the title of its axis, pixels."""

UNIFIED: dict[str, Any] = {"hovermode": "x unified", "hoversubplots": "axis"}
"""Settings of panels over each other, in which the reader points at one place in all."""

_LAYOUT: dict[str, object] = {
    "template": "none",
    "font": {"family": "system-ui, sans-serif", "size": 13, "color": "#222222"},
    "paper_bgcolor": "white",
    "plot_bgcolor": "white",
    "margin": {"l": 80, "r": 30, "t": ABOVE, "b": BELOW},
    "autosize": True,
}
_AXIS: dict[str, Any] = {"gridcolor": "#e6e6e6", "linecolor": SHADE, "zerolinecolor": GUIDE, "ticks": "outside"}
_HEADING: dict[str, object] = {"showarrow": False, "align": "left", "xanchor": "left", "yanchor": "bottom"}

_MOST_LISTED = 12  # greatest number of listed numbers of a parameter; a ground may have thousands


class Panel(NamedTuple):
    """A panel of a figure, in plotly's own names.

    Attributes:
        traces: What is drawn; lines unless a trace has another type.
        x: Settings of the horizontal axis; of the first panel alone where all panels have one axis.
        y: Settings of the vertical axis.
        heading: Title above the panel; none if empty.
    """

    traces: Sequence[dict[str, Any]]
    x: dict[str, Any]
    y: dict[str, Any]
    heading: str = ""


class Shown(NamedTuple):
    """A figure of a page.

    Attributes:
        name: Name of its place in the page, letters and dashes.
        title: Title above it.
        note: Note under the title; may be empty.
        plot: Figure of plotly.
        height: Height, pixels.
    """

    name: str
    title: str
    note: str
    plot: Any
    height: int


def plotted(
    panels: Sequence[Panel], *, columns: int = 1, shared: bool = False, legend: float = 1.0, **layout: Any
) -> Any:
    """Make a figure of plotly with panels in rows; of traces with one name the first is in the legend.

    Args:
        panels: The panels, row by row.
        columns: Number of panels side by side.
        shared: Whether all panels have the horizontal axis of the first one.
        legend: Lower end of the legend, in shares of the panels' height.
        **layout: Further settings of its layout in plotly's own names, as the gaps in `grid`.

    Raises:
        InputError: Plotly is not installed.
    """
    traces, named, axes, headings, places = [], set[str](), dict[str, Any](), [], []
    for k, panel in enumerate(panels, start=1):
        number = str(k) if k > 1 else ""
        x, y = "x" if shared else f"x{number}", f"y{number}"
        places.append(x + y)
        axes[f"yaxis{number}"] = {**_AXIS, **panel.y}
        axes.setdefault(f"xaxis{x[1:]}", {**_AXIS, **panel.x})
        for trace in panel.traces:
            traces.append({"showlegend": trace["name"] not in named, **trace, "xaxis": x, "yaxis": y})
            named.add(trace["name"])
        if panel.heading:
            at = {"x": 0.0, "y": 1.0, "xref": f"{x} domain", "yref": f"{y} domain"}
            headings.append({"text": panel.heading, "font": {"size": 13}, **_HEADING, **at})
    above = {"orientation": "h", "yanchor": "bottom", "y": legend, "xanchor": "left", "x": 0.0}
    rows = [places[start : start + columns] for start in range(0, len(places), columns)]
    grid = {"rows": len(rows), "columns": columns, "subplots": rows, **layout.pop("grid", {})}
    graphs = needed("plotly.graph_objects", "report", "a report")
    return graphs.Figure(traces, {**_LAYOUT, **axes, "annotations": headings, "legend": above, "grid": grid, **layout})


def line(signal: str, **more: object) -> dict[str, Any]:
    """Look of a line that shows a signal of `mjbiped.records.signals.SIGNALS`, in plotly's own names."""
    row = SIGNALS[signal]
    return {"color": row.colour, "dash": _DASHES[row.line], "width": 1.6, **more}


def curve(name: str, x: Any, y: Any, told: str = "", /, **look: Any) -> dict[str, Any]:
    """Make a trace.

    Args:
        name: Name in the legend.
        x: Horizontal places.
        y: Vertical places.
        told: Words where the reader points at the curve, in plotly's notation; none if empty.
        **look: Further settings in plotly's own names.
    """
    hover = {"hovertemplate": told} if told else {"hoverinfo": "skip"}
    return {"type": "scatter", "mode": "lines", "name": name, "legendgroup": name, "x": x, "y": y, **hover, **look}


def include(values: NDArray[np.floating], least: float = 0.0, room: float = 0.0) -> dict[str, object]:
    """Ends that an axis shows whatever its range.

    Args:
        values: Drawn values.
        least: Least span about their middle, in their unit.
        room: Room on both sides, as a share of their span.
    """
    known = values[np.isfinite(values)]
    if not known.size:
        return {}
    low, high = float(known.min()), float(known.max())
    middle, half = (low + high) / 2.0, max(least / 2.0, (0.5 + room) * (high - low))
    return {"autorangeoptions": {"include": [middle - half, middle + half]}}


def small(values: NDArray[np.floating]) -> NDArray[np.float32]:
    """Convert numbers to the seven digits that a page needs, in half the bytes."""
    return np.asarray(values, dtype=np.float32)


def flattened(settings: Mapping[str, object], beginning: str = "") -> Iterator[tuple[str, str, str]]:
    """Flatten nested settings into lines: name with dots, value, no unit."""
    for key, value in settings.items():
        name = f"{beginning}{key}"
        if isinstance(value, Mapping) and value:
            yield from flattened(value, f"{name}.")
            continue
        if isinstance(value, list | tuple) and len(value) > _MOST_LISTED:
            yield name, f"{', '.join(map(str, value[:_MOST_LISTED]))}, ... ({len(value)} in all)", ""
        else:
            yield name, ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value), ""


def check_installed() -> None:
    """Check that a report can be written.

    Raises:
        InputError: Plotly or Jinja is not installed.
    """
    for module in ("plotly", "jinja2"):
        needed(module, "report", "a report")


def write_page(
    path: Path, template: str, figures: Sequence[Shown], data: Mapping[str, object], **context: object
) -> None:
    """Write a page; it appears whole or not at all.

    Plotly's program and the figures are compressed, and the browser unpacks them: the page is a third as large, and
    needs no network. Texts are escaped, because a record may come from anyone.

    Args:
        path: The file.
        template: Name of its template in the folder `page`.
        figures: Figures in their order.
        data: Data that the page's program needs beside the figures; arrays become lists.
        **context: Values of the template's names.

    Raises:
        InputError: Plotly or Jinja is not installed.
        RecordError: The file cannot be written.
    """
    jinja = needed("jinja2", "report", "a report")
    offline = needed("plotly.offline", "report", "a report")
    loader, tidy = jinja.FileSystemLoader(_HERE), {"trim_blocks": True, "lstrip_blocks": True}
    environment = jinja.Environment(loader=loader, autoescape=True, undefined=jinja.StrictUndefined, **tidy)
    plots = {shown.name: json.loads(shown.plot.to_json()) for shown in figures}
    text = environment.get_template(template).render(
        figures=figures,
        plotly=_packed(offline.get_plotlyjs()),
        packed=_packed(json.dumps({"plots": plots, "data": dict(data)})),
        style=(_HERE / "page.css").read_text(encoding="utf-8"),
        program=(_HERE / "page.js").read_text(encoding="utf-8"),
        version=__version__,
        **context,
    )
    with saved(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def _packed(text: str) -> str:
    """Compress a text, and encode it in letters that a page can hold."""
    return b64encode(gzip.compress(text.encode(), mtime=0)).decode()
