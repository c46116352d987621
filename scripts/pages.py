"""Tables that a study writes as CSV files for the pages of docs/, so that no figure there is typed by hand.

A page that was written with its tables is divided by `python -m scripts.pages PAGE`.
"""

import csv
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import click
from rich.console import Console
from rich.table import Table as PrintedTable

Table: TypeAlias = tuple[Sequence[str], Sequence[Sequence[str]]]
"""Headings, and the cells of each row."""

_MARKS = re.compile(r"\*\*|`|\\(?=\|)|\[([^]]+)\]\([^)]+\)")

TABLES = click.option("--tables", type=Path, help="Folder that gets the tables as CSV files.")


def show_table(
    title: str, headings: Sequence[str], rows: Sequence[Sequence[str]], folder: Path | None = None, name: str = ""
) -> None:
    """Print a table, and write it into a CSV file where a folder is given.

    Args:
        title: Title printed above the table.
        headings: Heading of each column.
        rows: Cells of each row.
        folder: Gets the file; None prints only.
        name: Name of the table: "no sole" is written into no_sole.csv.
    """
    table = PrintedTable(title=title)
    for heading in headings:
        table.add_column(heading, justify="right")
    for cells in rows:
        table.add_row(*cells)
    Console(width=160).print(table)
    if folder is not None:
        write_table(folder, name, headings, rows)


def show_rows(title: str, rows: Sequence[Mapping[str, str]], folder: Path | None = None, name: str = "") -> None:
    """Print a table whose rows have their cells by heading, and write it as `show_table` does.

    Args:
        title: Title printed above the table.
        rows: Cells of each row by heading; the longest row has all headings, and a dash stands for what others lack.
        folder: Gets the file; None prints only.
        name: Name of the table.
    """
    headings = [*max(rows, key=len)]
    show_table(title, headings, [[row.get(heading, "–") for heading in headings] for row in rows], folder, name)


def write_table(folder: Path, name: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> Path:
    """Write a table into the CSV file of its name, without Markdown's marks for bold text, code and links."""
    file = file_of(folder, name)
    folder.mkdir(parents=True, exist_ok=True)
    with file.open("w", encoding="utf-8", newline="") as lines:
        plain = ([_MARKS.sub(r"\1", cell).strip() for cell in cells] for cells in (headings, *rows))
        csv.writer(lines, lineterminator="\n").writerows(plain)
    return file


def file_of(folder: Path, name: str) -> Path:
    """The file of a table by its name."""
    words = re.sub(r"\W+", "_", name.replace("ζ", "zeta"), flags=re.ASCII)
    return folder / f"{words.strip('_').lower()}.csv"


def without_tables(text: str, page: Path, prefix: str = "") -> str:
    """Write the tables of a page's Markdown text into CSV files, and put a link in the place of each.

    Args:
        text: The text. A table is named by the last line before it that is a heading or bold.
        page: The page. Those of docs/feet.md and of docs/tables/feet.md go to docs/tables/feet/.
        prefix: Begins the names of all files.
    """
    folder = (page.parent if page.parent.name == "tables" else page.parent / "tables") / page.stem
    count: Counter[str] = Counter()

    def link(found: re.Match[str]) -> str:
        title = re.findall(r"^(?:#+ |\*\*)([^*\n]+?)(?:\*\*)?$", text[: found.start()], re.MULTILINE)[-1]
        count[title] += 1
        told = title if count[title] == 1 else f"{title}, {count[title]}"
        headings, _, *rows = (re.split(r"(?<!\\)\|", line)[1:-1] for line in found[0].splitlines())
        file = write_table(folder, prefix + told, headings, rows)
        return f"[{told}]({file.relative_to(page.parent).as_posix()})\n"

    linked = re.sub(r"(?:^\|.*\n)+", link, text, flags=re.MULTILINE)
    return re.sub(r"^\*\*(.+)\*\*\n\n(?=\[\1\])", "", linked, flags=re.MULTILINE)


def take_out_tables(page: Path) -> None:
    """Leave links to CSV files in place of a page's tables."""
    page.write_text(without_tables(page.read_text(encoding="utf-8"), page), encoding="utf-8")


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        take_out_tables(Path(argument))
