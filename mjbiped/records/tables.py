"""Tables on a terminal, in the house's one way."""

from __future__ import annotations

from collections.abc import Iterable

from rich import box
from rich.table import Table
from rich.text import Text


def bare_table(*headings: str, numbers: bool = False) -> Table:
    """An empty table: words to the left, numbers to the right; all are numbers if told so."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    for heading in headings:
        words = heading in (headings[0], "unit") and not numbers
        table.add_column(heading, justify="left" if words else "right", overflow="fold")
    return table


def table_of(rows: Iterable[tuple[str, str, str]]) -> Table:
    """Rows of label, value and unit; nothing in them is taken for markup."""
    table = Table(box=box.SIMPLE, show_header=False, pad_edge=False)
    for _ in range(3):
        table.add_column(overflow="fold")
    for cells in rows:
        table.add_row(*(Text(cell) for cell in cells))
    return table
