"""A study's table, and the samples of all its walks, as Parquet files, which pandas, Polars, DuckDB, R and others read.

Each finished walk leaves a file of samples, and these are joined into one file when all walks have ended. An
interrupted study thus loses no samples and walks nothing twice.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.records.columns import attributes, tables_of, units_of
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
    arrow, parquet = _modules("a Parquet file")
    table = arrow.table({name: _one_type([row[name] for row in rows]) for name in rows[0]})
    with saved(path) as unfinished:
        parquet.write_table(table, unfinished)
    return path


def _one_type(values: list[object]) -> list[object]:
    """Convert the values of a column to one type; None stays."""
    kinds = {type(value) for value in values if value is not None}
    kind: Any = str if str in kinds else float if float in kinds else None
    return values if kind is None else [None if value is None else kind(value) for value in values]


FILE = "trajectories.parquet"
"""A row per sample: `cell` is the walk's number, the others are the columns of `Walk.to_pandas().samples`."""

_PIECES = "trajectories"


def forget(folder: Path) -> None:
    """Delete the samples that an earlier run kept in a folder."""
    (folder / FILE).unlink(missing_ok=True)
    shutil.rmtree(folder / _PIECES, ignore_errors=True)


class Trajectories:
    """A study's table, with the samples of its walks beside it.

    Attributes:
        folder: Folder of the files.
    """

    def __init__(self, store: Store, count: int) -> None:
        """Open the samples beside a table.

        Args:
            store: The table.
            count: Number of walks of the study.

        Raises:
            InputError: PyArrow is not installed.
        """
        check_installed("keeping trajectories")
        self.folder, self._store, self._count = store.folder, store, count
        self._whole, self._pieces = store.folder / FILE, store.folder / _PIECES

    def cells(self) -> set[int]:
        """Numbers of the walks whose samples are kept."""
        if self._whole.is_file():
            return set(range(self._count))
        return {int(piece.stem) for piece in self._pieces.glob("*.parquet") if piece.stem.isdecimal()}

    def save(self, rows: Sequence[Row]) -> None:
        """Keep the samples of walks that have ended, and then their rows.

        Raises:
            RecordError: They cannot be written.
        """
        self._pieces.mkdir(exist_ok=True)
        for row in rows:
            with saved(self._pieces / f"{row['cell']}.parquet") as unfinished:
                write_samples(row, unfinished)
        self._store.save(rows)

    def join(self) -> None:
        """Put the samples of all walks into one file, in the order of the walks; one walk is in memory at a time.

        Raises:
            RecordError: It cannot be written.
        """
        if self._whole.is_file():
            return
        arrow, parquet = _modules("keeping trajectories")
        pieces = [self._pieces / f"{cell}.parquet" for cell in range(self._count)]
        # controllers differ in the number of their states, robots in that of their angles: what one has not is null
        schema = arrow.unify_schemas([parquet.read_schema(piece) for piece in pieces])
        known = {name: unit for kind in KINDS.values() for name, unit in units_of(tables_of(kind).samples).items()}
        units = {name: unit for name, unit in known.items() if name in schema.names}
        schema = schema.with_metadata(attributes(units))
        with saved(self._whole) as unfinished, parquet.ParquetWriter(unfinished, schema) as writer:
            for piece in pieces:
                table = parquet.read_table(piece)
                writer.write_table(arrow.concat_tables([schema.empty_table(), table], promote_options="default"))
        shutil.rmtree(self._pieces, ignore_errors=True)


def write_samples(row: Row, file: object) -> None:
    """Write the samples of a walk; one that failed at once has none."""
    arrow, parquet = _modules("keeping trajectories")
    columns = row.get(TRAJECTORY, {})
    length = len(next(iter(columns.values()), ()))
    parquet.write_table(arrow.table({"cell": np.full(length, row["cell"], dtype=np.int64), **columns}), file)


def _modules(what: str) -> tuple[Any, Any]:
    """Import PyArrow and its part for Parquet.

    Raises:
        InputError: PyArrow is not installed.
    """
    return needed("pyarrow", "data", what), needed("pyarrow.parquet", "data", what)
