"""Writes the columns of records into docs/tables/columns.md: python -m scripts.columns_page."""

from __future__ import annotations

from pathlib import Path

from mjbiped.records.columns import Tables, tables_of
from mjbiped.robots.kinds import KINDS
from scripts.pages import write_table

PAGE = Path("docs/tables/columns.md")
HEADINGS = ("column", "numbers", "unit", "meaning", "robots")


def rows_of(table: str) -> list[list[str]]:
    """Rows of the page's table of samples or touchdowns."""
    rows: dict[str, list[str]] = {}
    kinds: dict[str, list[str]] = {}
    for kind, robot in KINDS.items():
        numbers = {robot.angles: "angles", robot.joints: "joints", robot.places: "places", (): "1"}
        for name, column in getattr(tables_of(robot), table).items():
            meaning = column.meaning.replace("|", r"\|")
            rows.setdefault(name, [f"`{name}`", numbers[column.parts], column.unit, meaning])
            kinds.setdefault(name, []).append(kind)
    return [[*row, "all" if len(kinds[name]) == len(KINDS) else ", ".join(kinds[name])] for name, row in rows.items()]


if __name__ == "__main__":
    for each in Tables._fields:
        write_table(PAGE, each, HEADINGS, rows_of(each))
