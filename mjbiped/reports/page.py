"""One HTML file with everything that it needs: interactive figures in panels, style, programs, video."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.plotting.style import GUIDE, SHADE
from mjbiped.records.signals import DASHED, DOTTED, SIGNALS, SOLID
from mjbiped.utils.files import saved
from mjbiped.utils.packages import needed
from mjbiped.version import __version__

_HERE = Path(__file__).parent / "page"
_DASHES = {SOLID: "solid", DASHED: "dash", DOTTED: "dot"}
_LAYOUT: dict[str, object] = {
    "template": "none",
    "font": {"family": "system-ui, sans-serif", "size": 13, "color": "#222222"},
    "paper_bgcolor": "white",
    "plot_bgcolor": "white",
    "margin": {"l": 70, "r": 20, "t": 40, "b": 50},
    "autosize": True,
}
_AXIS: dict[str, Any] = {"gridcolor": "#e6e6e6", "linecolor": SHADE, "zerolinecolor": GUIDE, "ticks": "outside"}
_HEADING: dict[str, object] = {"showarrow": False, "align": "left", "xanchor": "left", "yanchor": "bottom"}
_LEAST_SPAN = 0.02  # of the values


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


class Panels:
    """A figure of plotly in panels, each with axes and a heading of its own.

    Attributes:
        figure: The figure.

    Raises:
        InputError: Plotly is not installed.
    """

    def __init__(self) -> None:
        """Begin without panels."""
        self.figure = needed("plotly.graph_objects", "report", "a report").Figure()
        self._axes: dict[str, Any] = {}
        self._count = 0

    def add(
        self,
        across: tuple[float, float] = (0.0, 1.0),
        down: tuple[float, float] = (0.0, 1.0),
        *,
        x: dict[str, Any] | None = None,
        y: dict[str, Any],
        heading: str = "",
    ) -> dict[str, str]:
        """Add a panel.

        Args:
            across: Left and right end, in shares of the figure's width.
            down: Lower and upper end, in shares of the figure's height.
            x: Settings of its horizontal axis; None if it shares that of the first panel, which stands below the last.
            y: Settings of its vertical axis.
            heading: Title above it; none if empty.

        Returns:
            The axes of its traces, in plotly's own names.
        """
        number = str(self._count + 1) if self._count else ""
        self._count += 1
        shared = x is None
        own = "" if shared else number
        settings = self._axes["xaxis"] if x is None else {**_AXIS, **x, "domain": across}
        self._axes[f"xaxis{own}"] = {**settings, "anchor": f"y{number}"}
        self._axes[f"yaxis{number}"] = {**_AXIS, **y, "domain": down, "anchor": f"x{own}"}
        if heading:
            self.figure.add_annotation(
                text=heading, x=across[0], y=down[1], xref="paper", yref="paper", font={"size": 13}, **_HEADING
            )
        return {"xaxis": f"x{own}", "yaxis": f"y{number}"}

    def shown(self, name: str, title: str, note: str, height: int, *, legend: float = 1.0, **layout: object) -> Shown:
        """Return the figure for a page.

        Args:
            name: Name of its place in the page, letters and dashes.
            title: Title above it.
            note: Note under the title; may be empty.
            height: Height, pixels.
            legend: Lower end of the legend, in shares of the panels' height.
            **layout: Further settings of its layout in plotly's own names.
        """
        above = {"orientation": "h", "yanchor": "bottom", "y": legend, "xanchor": "left", "x": 0.0}
        self.figure.update_layout({**_LAYOUT, "legend": above, **self._axes, **layout})
        return Shown(name, title, note, self.figure, height)


def shares(count: int, gap: float) -> list[tuple[float, float]]:
    """Divide a figure's width or height into equal parts with gaps between them."""
    size = (1.0 - gap * (count - 1)) / count
    return [(k * (size + gap), k * (size + gap) + size) for k in range(count)]


def line(signal: str, **more: object) -> dict[str, Any]:
    """Look of a line that shows a signal of `mjbiped.records.signals.SIGNALS`, in plotly's own names."""
    row = SIGNALS[signal]
    return {"color": row.colour, "dash": _DASHES[row.line], "width": 1.6, **more}


def span(values: NDArray[np.floating]) -> dict[str, Any]:
    """Range of an axis whose values hardly differ, so that rounding does not fill the panel; else nothing."""
    known = values[np.isfinite(values)]
    if not known.size or np.ptp(known) > _LEAST_SPAN * np.abs(known).max():
        return {}
    middle, half = float(known.mean()), _LEAST_SPAN * (float(np.abs(known).max()) or 1.0)
    return {"range": [middle - half, middle + half]}


def include(values: NDArray[np.floating], least: float = 0.0, room: float = 0.0) -> dict[str, object]:
    """Ends that an axis shows whatever its range.

    Args:
        values: Drawn values.
        least: Least span about their middle, in their unit.
        room: Room on both sides, as a share of their span.
    """
    known = values[np.isfinite(values)]
    if not known.size or not (least or room):
        return {"autorangeoptions": {"include": []}}
    low, high = float(known.min()), float(known.max())
    half = least / 2.0 if least else (0.5 + room) * (high - low)
    middle = (low + high) / 2.0
    return {"autorangeoptions": {"include": [middle - half, middle + half]}}


def small(values: NDArray[np.floating]) -> NDArray[np.float32]:
    """Convert numbers to the seven digits that a page needs, in half the bytes."""
    return np.asarray(values, dtype=np.float32)


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
