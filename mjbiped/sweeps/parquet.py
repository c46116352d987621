"""A study's table, and the samples of all its walks, as Parquet files, which pandas, Polars, DuckDB, R and others read.

Each finished walk leaves a file of samples, and these are joined into one file when all walks have ended. An
interrupted study thus loses no samples and walks nothing twice. PyArrow is imported where it is used: it is an extra.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mjbiped.records.columns import tables_of
from mjbiped.records.frames import attributes, units_of
from mjbiped.robots.kinds import KINDS
from mjbiped.sweeps.cell import TRAJECTORY, Row
from mjbiped.utils.files import saved

FILE = "trajectories.parquet"
"""A row per sample: `cell` is the walk's number, the others are the columns of `Walk.to_pandas().samples`."""

_PIECES = "trajectories"


def write_table(path: Path, rows: Sequence[Row]) -> Path:
    """Write a study's table as Parquet; the same rows and the same PyArrow give the same bytes.

    Args:
        path: The file.
        rows: One at least, all with the same keys. A column of numbers alone is of numbers; where texts are among
            them (a delay of 0.8 and "none") all are texts, as in the CSV file.

    Returns:
        The file.

    Raises:
        RecordError: The file cannot be written.
    """
    import pyarrow
    from pyarrow import parquet

    table = {}
    for name in rows[0]:
        values = [row[name] for row in rows]
        kinds = {type(value) for value in values if value is not None}
        kind = str if str in kinds else float if float in kinds else None
        table[name] = values if kind is None else [None if value is None else kind(value) for value in values]
    with saved(path) as unfinished:
        parquet.write_table(pyarrow.table(table), unfinished)
    return path


def forget_samples(folder: Path) -> None:
    """Delete the samples that an earlier run kept in a folder."""
    (folder / FILE).unlink(missing_ok=True)
    shutil.rmtree(folder / _PIECES, ignore_errors=True)


def sampled(folder: Path, count: int) -> set[int]:
    """Numbers of the walks of a study of `count` walks whose samples are kept in its folder."""
    if (folder / FILE).is_file():
        return set(range(count))
    return {int(piece.stem) for piece in (folder / _PIECES).glob("*.parquet") if piece.stem.isdecimal()}


def save_samples(folder: Path, rows: Sequence[Row]) -> None:
    """Keep the samples of walks that have ended.

    Raises:
        RecordError: They cannot be written.
    """
    (folder / _PIECES).mkdir(exist_ok=True)
    for row in rows:
        with saved(folder / _PIECES / f"{row['cell']}.parquet") as unfinished:
            write_samples(row, unfinished)


def write_samples(row: Row, file: object) -> None:
    """Write the samples of a walk; one that failed at once has none."""
    import pyarrow
    from pyarrow import parquet

    columns = row.get(TRAJECTORY, {})
    length = len(next(iter(columns.values()), ()))
    parquet.write_table(pyarrow.table({"cell": np.full(length, row["cell"], dtype=np.int64), **columns}), file)


def join_samples(folder: Path, count: int) -> None:
    """Put the samples of all walks into one file, in the order of the walks; one walk is in memory at a time.

    Raises:
        RecordError: It cannot be written.
    """
    import pyarrow
    from pyarrow import parquet

    if (folder / FILE).is_file():
        return
    pieces = [folder / _PIECES / f"{cell}.parquet" for cell in range(count)]
    # controllers differ in the number of their states, robots in that of their angles: what one has not is null
    schema = pyarrow.unify_schemas([parquet.read_schema(piece) for piece in pieces])
    known = {name: unit for kind in KINDS.values() for name, unit in units_of(tables_of(kind).samples).items()}
    units = {name: unit for name, unit in known.items() if name in schema.names}
    schema = schema.with_metadata(attributes(units))
    with saved(folder / FILE) as unfinished, parquet.ParquetWriter(unfinished, schema) as writer:
        for piece in pieces:
            writer.write_table(parquet.read_table(piece, schema=schema))
    shutil.rmtree(folder / _PIECES, ignore_errors=True)
