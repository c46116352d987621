"""Samples and touchdowns of a walk as CSV and Parquet files, one number per column."""

from __future__ import annotations

import csv
from pathlib import Path

from mjbiped.exchange.formats import PARQUET
from mjbiped.records.columns import Columns, tables_of
from mjbiped.records.frames import Flat, attributes, flat_samples, flat_touchdowns, units_of
from mjbiped.records.record import Walk
from mjbiped.utils.files import saved
from mjbiped.utils.packages import needed


def write_samples(walk: Walk, path: Path) -> None:
    """Write the samples of a walk, as the suffix `.csv` or `.parquet` says; `Walk.to_pandas` explains the columns.

    Raises:
        InputError: PyArrow is not installed.
        RecordError: The file cannot be written.
    """
    _write(path, flat_samples(walk), tables_of(type(walk.robot)).samples)


def write_touchdowns(walk: Walk, path: Path) -> None:
    """Write the touchdowns of a walk, as `write_samples` writes the samples."""
    _write(path, flat_touchdowns(walk), tables_of(type(walk.robot)).touchdowns)


def _write(path: Path, table: Flat, columns: Columns) -> None:
    """Write a table: all digits, and in Parquet units that pandas finds in `frame.attrs`."""
    if path.suffix == PARQUET:
        parquet, arrow = (needed(module, "data", "a Parquet file") for module in ("pyarrow.parquet", "pyarrow"))
        with saved(path) as unfinished:
            parquet.write_table(arrow.table(table).replace_schema_metadata(attributes(units_of(columns))), unfinished)
        return
    with saved(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table)
        writer.writerows(zip(*(column.tolist() for column in table.values()), strict=True))
