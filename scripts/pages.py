"""Tables that a study writes into a page of docs/, so that no figure there is typed by hand."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from mjbiped.utils.files import markdown_table


def show_table(
    title: str, headings: Sequence[str], rows: Sequence[Sequence[str]], page: Path | None = None, name: str = ""
) -> None:
    """Print a table, and write it into a page where one is given.

    Args:
        title: Title printed above the table.
        headings: Heading of each column.
        rows: Cells of each row.
        page: Page that gets the table; None prints only.
        name: Name of the place in the page.

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


def show_rows(title: str, rows: Sequence[Mapping[str, str]], page: Path | None = None, name: str = "") -> None:
    """Print a table whose rows have their cells by heading, and write it into a page where one is given.

    Args:
        title: Title printed above the table.
        rows: Cells of each row by heading; the longest row has all headings, and a dash stands for what others lack.
        page: Page that gets the table; None prints only.
        name: Name of the place in the page.

    Raises:
        ValueError: The page has no such place.
    """
    headings = [*max(rows, key=len)]
    show_table(title, headings, [[row.get(heading, "–") for heading in headings] for row in rows], page, name)


def write_table(page: Path, name: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Replace the text between `<!-- NAME -->` and `<!-- end NAME -->` in a Markdown page by a table.

    Args:
        page: The page; its other text stays.
        name: Name of the place.
        headings: Heading of each column.
        rows: Cells of each row.

    Raises:
        ValueError: The page has no such place.
    """
    write_block(page, name, markdown_table(headings, rows))


def write_block(page: Path, name: str, text: str) -> None:
    """Replace the text between `<!-- NAME -->` and `<!-- end NAME -->` in a Markdown page.

    Args:
        page: The page; its other text stays.
        name: Name of the place.
        text: New text.

    Raises:
        ValueError: The page has no such place.
    """
    whole = page.read_text(encoding="utf-8")
    before, begin, rest = whole.partition(f"<!-- {name} -->\n")
    _, end, after = rest.partition(f"<!-- end {name} -->")
    if not begin or not end:
        raise ValueError(f"{page} has no place for a table between <!-- {name} --> and <!-- end {name} -->")
    page.write_text(f"{before}{begin}{text.rstrip()}\n{end}{after}", encoding="utf-8")
