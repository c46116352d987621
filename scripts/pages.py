"""Tables that a study writes into a page of docs/, so that no figure there is typed by hand."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table


def show_table(
    title: str, headings: Sequence[str], rows: Sequence[Sequence[str]], page: Path | None, name: str
) -> None:
    """Print a table, and write it into a page, if there is one; see `write_table`.

    Args:
        title: Printed above it.
        headings: Of the columns.
        rows: Of cells.
        page: The page.
        name: Of the place in it.

    Raises:
        ValueError: The page has no such place.
    """
    table = Table(title=title)
    for heading in headings:
        table.add_column(heading, justify="right")
    for cells in rows:
        table.add_row(*cells)
    Console(width=160).print(table)
    if page is not None:
        write_table(page, name, headings, rows)


def write_table(page: Path, name: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Replace what stands between `<!-- NAME -->` and `<!-- end NAME -->` in a Markdown page by a table.

    Args:
        page: The page; all else in it stays.
        name: Of the place.
        headings: Of the columns.
        rows: Of cells.

    Raises:
        ValueError: The page has no such place.
    """
    write_block(page, name, markdown_table(headings, rows))


def write_block(page: Path, name: str, text: str) -> None:
    """Replace what stands between `<!-- NAME -->` and `<!-- end NAME -->` in a Markdown page by a text.

    Args:
        page: The page; all else in it stays.
        name: Of the place.
        text: Whole lines.

    Raises:
        ValueError: The page has no such place.
    """
    whole = page.read_text(encoding="utf-8")
    before, begin, rest = whole.partition(f"<!-- {name} -->\n")
    _, end, after = rest.partition(f"<!-- end {name} -->")
    if not begin or not end:
        raise ValueError(f"{page} has no place for a table between <!-- {name} --> and <!-- end {name} -->")
    page.write_text(f"{before}{begin}{text}{end}{after}", encoding="utf-8")


def markdown_table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown, whole lines."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
