"""One HTML file with everything that it needs: style, programs, figures, video."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mjbiped.reports.figures import Shown
from mjbiped.utils.extras import needed
from mjbiped.utils.files import saved
from mjbiped.version import __version__

_HERE = Path(__file__).parent / "page"


def check_installed() -> None:
    """Check that a report can be written.

    Raises:
        InputError: Plotly or Jinja is not installed.
    """
    for module in ("plotly", "jinja2"):
        needed(module, "report", "a report")


def write_page(path: Path, template: str, figures: Sequence[Shown], data: Mapping[str, Any], **context: object) -> None:
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
    environment = jinja.Environment(
        loader=jinja.FileSystemLoader(_HERE),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja.StrictUndefined,
    )
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
