"""Tables as Parquet files, which pandas, Polars, DuckDB, R and others read with their types."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mjbiped.sweeps.cell import Row
from mjbiped.utils.extras import needed
from mjbiped.utils.files import saved


def check_installed(what: str) -> None:
    """Refuse what needs Parquet where it cannot be written.

    Args:
        what: Is asked for, for the message.

    Raises:
        InputError: PyArrow is not installed.
    """
    needed("pyarrow.parquet", "data", what)


def write_table(path: Path, rows: Sequence[Row]) -> Path:
    """Write a study's table; the same rows and the same PyArrow give the same bytes.

    Args:
        path: The file.
        rows: One at least, all with the same keys. A column of numbers alone is of numbers; where texts are among
            them (a delay of 0.8 and "none") all are texts, as in the CSV file.

    Returns:
        The file.

    Raises:
        InputError: PyArrow is not installed.
        RecordError: The file cannot be written.
    """
    parquet = needed("pyarrow.parquet", "data", "a Parquet file")
    arrow = needed("pyarrow", "data", "a Parquet file")
    table = arrow.table({name: _one_type([row[name] for row in rows]) for name in rows[0]})
    with saved(path) as unfinished:
        parquet.write_table(table, unfinished)
    return path


def _one_type(values: list[Any]) -> list[Any]:
    """Values of a column, all of one type; None stays."""
    kinds = {type(value) for value in values if value is not None}
    if str in kinds and len(kinds) > 1:
        return [None if value is None else str(value) for value in values]
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    return values
