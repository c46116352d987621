"""A study's table, and the samples of all its walks, as Parquet files, which pandas, Polars, DuckDB, R and others read.

Each finished walk leaves a file of samples, and these are joined into one file when all walks have ended. An
interrupted study thus loses no samples and walks nothing twice.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.records.columns import tables_of
from mjbiped.records.frames import attributes, units_of
from mjbiped.robots.kinds import KINDS
from mjbiped.sweeps.cell import TRAJECTORY, Row
from mjbiped.sweeps.store import Store
from mjbiped.utils.files import saved
from mjbiped.utils.packages import needed


def check_installed(what: str) -> None:
    """Refuse an option that needs Parquet where PyArrow is not installed.

    Args:
        what: The option, for the message.

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
    parquet, arrow = (needed(module, "data", "a Parquet file") for module in ("pyarrow.parquet", "pyarrow"))
    table = arrow.table({name: _one_type([row[name] for row in rows]) for name in rows[0]})
    with saved(path) as unfinished:
        parquet.write_table(table, unfinished)
    return path


def _one_type(values: list[Any]) -> list[Any]:
    """Convert the values of a column to one type; None stays."""
    kinds = {type(value) for value in values if value is not None}
    if str in kinds and len(kinds) > 1:
        return [None if value is None else str(value) for value in values]
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    return values


FILE = "trajectories.parquet"
"""A row per sample: `cell` is the walk's number, the others are the columns of `Walk.to_pandas().samples`."""

_PIECES = "trajectories"
_SUFFIX = ".parquet"


def forget(folder: Path) -> None:
    """Delete the samples that an earlier run kept in a folder."""
    (folder / FILE).unlink(missing_ok=True)
    shutil.rmtree(folder / _PIECES, ignore_errors=True)


class Trajectories:
    """A study's table, with the samples of its walks beside it.

    Attributes:
        folder: The table's folder.
    """

    def __init__(self, store: Store, count: int) -> None:
        """Open the samples beside a table.

        Args:
            store: The table.
            count: Number of walks of the study.

        Raises:
            InputError: PyArrow is not installed.
        """
        modules = ("pyarrow", "pyarrow.parquet")
        self._arrow, self._parquet = (needed(module, "data", "keeping trajectories") for module in modules)
        self.folder, self._store, self._count = store.folder, store, count
        self._whole, self._pieces = store.folder / FILE, store.folder / _PIECES

    def cells(self) -> set[int]:
        """Numbers of the walks whose samples are kept."""
        if self._whole.is_file():
            return set(range(self._count))
        return {int(piece.stem) for piece in self._pieces.glob(f"*{_SUFFIX}") if piece.stem.isdecimal()}

    def save(self, rows: Sequence[Row]) -> None:
        """Keep the samples of walks that have ended, and then their rows; a walk that failed at once has no samples.

        Raises:
            RecordError: They cannot be written.
        """
        self._pieces.mkdir(exist_ok=True)
        for row in rows:
            columns = row.get(TRAJECTORY, {})
            length = len(next(iter(columns.values()), ()))
            table = self._arrow.table({"cell": np.full(length, row["cell"], dtype=np.int64), **columns})
            with saved(self._pieces / f"{row['cell']}{_SUFFIX}") as unfinished:
                self._parquet.write_table(table, unfinished)
        self._store.save(rows)

    def join(self) -> None:
        """Put the samples of all walks into one file, in the order of the walks; one walk is in memory at a time.

        Raises:
            RecordError: It cannot be written.
        """
        if self._whole.is_file():
            return
        pieces = [self._pieces / f"{cell}{_SUFFIX}" for cell in range(self._count)]
        # controllers differ in the number of their states, robots in that of their angles: what one has not is null
        schema = self._arrow.unify_schemas([self._parquet.read_schema(piece) for piece in pieces])
        known = {name: unit for kind in KINDS.values() for name, unit in units_of(tables_of(kind).samples).items()}
        units = {name: unit for name, unit in known.items() if name in schema.names}
        schema = schema.with_metadata(attributes(units))
        with saved(self._whole) as unfinished, self._parquet.ParquetWriter(unfinished, schema) as writer:
            for piece in pieces:
                table = self._parquet.read_table(piece)
                writer.write_table(self._arrow.concat_tables([schema.empty_table(), table], promote_options="default"))
        with suppress(OSError):
            shutil.rmtree(self._pieces)
