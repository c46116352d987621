"""Tables of the site: a paragraph that is only a link to a CSV file shows the file's table.

Long tables are folded, except on pages under `tables/`. The directive `{lookup}` shows a table that `lookups` makes.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any

import lookups
from docutils import nodes
from sphinx.addnodes import download_reference
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform
from sphinx.util.docutils import SphinxDirective

SHORT = 12
"""Lines of a table that is shown unfolded on any page."""

Rows = Iterable[Sequence[str]]


def table_of(rows: Rows) -> nodes.table:
    """A table whose first row has the headings; what stands between backquotes is code."""
    head, *body = [nodes.row("", *map(_cell, cells)) for cells in rows]
    width = len(head)
    parts = [nodes.colspec(colwidth=1) for _ in range(width)]
    group = nodes.tgroup("", *parts, nodes.thead("", head), nodes.tbody("", *body), cols=width)
    return nodes.table("", group)


def _cell(text: str) -> nodes.entry:
    words = [nodes.literal("", part) if k % 2 else nodes.Text(part) for k, part in enumerate(text.split("`"))]
    return nodes.entry("", nodes.paragraph("", "", *words))


class ShowLinkedTables(SphinxTransform):
    """Puts the table of a linked CSV file behind a link that is a paragraph by itself."""

    default_priority = 300  # links to files are found by then, and not yet replaced by what copies them

    def apply(self, **_: Any) -> None:
        """Change all such paragraphs of a page."""
        page = Path(self.env.doc2path(self.env.docname))
        for link in list(self.document.findall(download_reference)):
            paragraph, file = link.parent, page.parent / link["reftarget"]
            if len(paragraph.children) > 1 or file.suffix != ".csv" or not isinstance(paragraph, nodes.paragraph):
                continue
            self.env.note_dependency(str(file))
            with file.open(encoding="utf-8", newline="") as lines:
                rows = list(csv.reader(lines))
            unfolded = self.env.docname.startswith("tables/") or len(rows) <= SHORT
            begin = f"<details{' open' * unfolded}><summary>{escape(link.astext())}</summary>"
            link.children[:] = [nodes.Text("CSV")]
            raw = [nodes.raw("", text, format="html") for text in (begin, "</details>")]
            paragraph.replace_self([raw[0], table_of(rows), paragraph.deepcopy(), raw[1]])


class Lookup(SphinxDirective):
    """`{lookup} NAME`: the table that the function NAME of `lookups` makes of the code."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Make the table."""
        return [table_of(getattr(lookups, self.arguments[0])())]


def setup(app: Sphinx) -> None:
    """Connect what is above."""
    app.add_transform(ShowLinkedTables)
    app.add_directive("lookup", Lookup)
