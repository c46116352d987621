"""The page of a record's columns shows the columns that records have."""

from pathlib import Path

import pytest
from documentation import text

from mjbiped.records.columns import Tables
from scripts.columns_page import HEADINGS, rows_of
from scripts.pages import write_table


@pytest.mark.parametrize("table", Tables._fields)
def test_the_page_is_as_the_script_writes_it(table: str, tmp_path: Path) -> None:
    page = tmp_path / "columns.md"
    page.write_text(text("docs/tables/columns.md"), encoding="utf-8")
    write_table(page, table, HEADINGS, rows_of(table))
    assert page.read_text(encoding="utf-8") == text("docs/tables/columns.md"), "run python -m scripts.columns_page"
