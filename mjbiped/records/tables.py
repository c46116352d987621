"""Tables on a terminal, all in one style."""

from __future__ import annotations

from collections.abc import Iterable

from rich import box
from rich.table import Table
from rich.text import Text


def bare_table(*headings: str, numbers: bool = False) -> Table:
    """Make an empty table with words to the left and numbers to the right; `numbers` tells that all are numbers."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    for heading in headings:
        words = heading in (headings[0], "unit") and not numbers
        table.add_column(heading, justify="left" if words else "right", overflow="fold")
    return table


def table_of(rows: Iterable[tuple[str, str, str]]) -> Table:
    """Make a table of rows of label, value and unit, without interpreting markup."""
    table = Table(box=box.SIMPLE, show_header=False, pad_edge=False)
    for _ in range(3):
        table.add_column(overflow="fold")
    for cells in rows:
        table.add_row(*(Text(cell) for cell in cells))
    return table
