"""A table of finished walks on disk: SQLite that grows row by row, CSV and Parquet of all rows, and the walks' samples.

Where samples are kept, each finished walk leaves a file of them; all are joined when all walks have ended.
"""

from __future__ import annotations

import csv
import json
import shutil
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mjbiped.errors import InputError, RecordError, shortened
from mjbiped.records.columns import attributes, tables_of, units_of
from mjbiped.robots.kinds import KINDS
from mjbiped.studies.cell import KNEES_MEASURES, TRAJECTORY, Row
from mjbiped.utils.files import saved

FILE = "trajectories.parquet"
"""A row per sample: `cell` is the walk's number, the others are the columns of `Walk.to_pandas().samples`."""

_PIECES = "trajectories"
_LOCK = ".running"
_SUFFIXES = (".sqlite", ".sqlite-journal", ".csv", ".parquet")
_FORMAT = 1
_WAY_OUT = "; name another --out, or begin again with --fresh"
_SHOWN = 5  # differences in a message
_LONG = 60  # letters of a value that a message leaves out
_IN_WORDS = {"sources": "mjbiped's source files", "cells": "the content of a terrain file"}
"""Parts of an identity that are digests; those of a user's own controllers are called `controllers.` and the name."""


@dataclass(frozen=True)
class Store:
    """An open table of finished walks.

    Attributes:
        path: The SQLite file.
        columns: Names of the columns; the first is the key.
        database: Connection to the file.
    """

    path: Path
    columns: tuple[str, ...]
    database: sqlite3.Connection

    def save(self, rows: Sequence[Row]) -> None:
        """Add all rows or none; a row replaces an earlier one with the same key.

        Raises:
            RecordError: The rows cannot be written.
        """
        marks = ", ".join("?" * len(self.columns))
        values = [tuple(row.get(name) for name in self.columns) for row in rows]
        with _explained(self.path), self.database:
            self.database.executemany(f"INSERT OR REPLACE INTO cells VALUES ({marks})", values)

    def rows(self) -> list[Row]:
        """Read all rows, in the order of their keys.

        Raises:
            RecordError: The file is damaged.
        """
        with _explained(self.path):
            return _rows(self.database)

    def export(self) -> Path:
        """Write the table as a CSV file; the same rows are the same bytes.

        Raises:
            RecordError: It cannot be written.
        """
        path = self.path.with_suffix(".csv")
        with saved(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.columns)
            writer.writerows(row.values() for row in self.rows())
        return path


@contextmanager
def opened(
    folder: Path, name: str, columns: Sequence[str], identity: Mapping[str, object], *, fresh: bool = False
) -> Iterator[Store]:
    """Open a table or begin one, and keep other processes out.

    Args:
        folder: Folder of the table; it is made if missing.
        name: Name of its files, without their suffixes.
        columns: Names of the columns; no two rows have the same value in the first, the key.
        identity: Everything on which its rows depend, by kind, in plain JSON types; another identity is refused.
        fresh: Delete the rows and the samples that are kept.

    Raises:
        InputError: The folder cannot be made, another process has it, or its rows are of another identity.
        RecordError: The file is no table of mjbiped's, or a damaged one, or cannot be written.
    """
    make_folder(folder)
    path, wanted = folder / f"{name}.sqlite", {"format": _FORMAT, **identity}
    with ExitStack() as stack:
        try:  # the system releases the lock however this process ends
            lock = stack.enter_context(closing(sqlite3.connect(folder / _LOCK, timeout=0.0)))
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.Error as error:
            why = f"{folder / _LOCK} cannot be written, or is no lock of ours: delete it ({error})"
            raise InputError(f"the table in {folder} cannot be taken: another process is at it, or {why}") from error
        with _explained(path):
            if fresh:
                for old in (*(path.with_suffix(suffix) for suffix in _SUFFIXES), folder / FILE):
                    old.unlink(missing_ok=True)
                shutil.rmtree(folder / _PIECES, ignore_errors=True)
            database = stack.enter_context(closing(sqlite3.connect(path)))
            _begin(database, columns, wanted)
            differences = _differences(_identity(database), wanted)
            found = [name for _, name, *_ in database.execute("PRAGMA table_info(cells)")]
            if not differences and found != [*columns]:
                raise ValueError("its columns are others than they must be: another version of mjbiped made it")
        if differences:
            more = f" and {len(differences) - _SHOWN} more" if len(differences) > _SHOWN else ""
            raise InputError(
                f"the rows in {folder} are of another study: {'; '.join(differences[:_SHOWN])}{more}. Name another "
                "--out, undo the change, or delete these rows and begin again with --fresh"
            )
        yield Store(path, tuple(columns), database)


def read_table(path: Path) -> tuple[list[Row], dict[str, object]]:
    """Read the rows and the identity of a study's table that another process may be writing.

    Returns:
        The rows in the order of their keys, and the identity that `opened` was given.

    Raises:
        RecordError: The file is no table of mjbiped's, or a damaged one.
    """
    address = f"{path.absolute().as_uri()}?mode=ro"
    with _explained(path, ""), closing(sqlite3.connect(address, uri=True)) as database:
        identity, rows = _identity(database), _rows(database)
        if not all(isinstance(row.get(name), float | int | None) for row in rows for name in KNEES_MEASURES):
            raise ValueError("a measure is no number")
        return rows, identity


def make_folder(folder: Path) -> None:
    """Make a folder and its parents where they are missing; an `InputError` says why it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error


def _begin(database: sqlite3.Connection, columns: Sequence[str], identity: Mapping[str, object]) -> None:
    """Make the tables of a new file."""
    with database:
        database.execute("BEGIN IMMEDIATE")
        if not database.execute("SELECT name FROM sqlite_master").fetchall():
            key, *others = (f'"{name}"' for name in columns)
            database.execute("CREATE TABLE identity (kind TEXT PRIMARY KEY, value TEXT)")
            # no types: values stay as they are
            database.execute(f"CREATE TABLE cells ({', '.join((f'{key} PRIMARY KEY', *others))})")
            texts = ((kind, json.dumps(value, sort_keys=True)) for kind, value in identity.items())
            database.executemany("INSERT INTO identity VALUES (?, ?)", texts)


def _rows(database: sqlite3.Connection) -> list[Row]:
    found = database.execute("SELECT * FROM cells ORDER BY 1")
    names = [name for name, *_ in found.description]
    return [dict(zip(names, values, strict=True)) for values in found]


def _identity(database: sqlite3.Connection) -> dict[str, object]:
    return {kind: json.loads(value) for kind, value in database.execute("SELECT kind, value FROM identity")}


@contextmanager
def _explained(path: Path, way_out: str = _WAY_OUT) -> Iterator[None]:
    """Raise what goes wrong with a table as an error that says so, and what to do.

    Raises:
        RecordError: Anything went wrong; a damaged file may hold no text where one is expected.
    """
    try:
        yield
    except (OSError, sqlite3.Error, ValueError, TypeError, RecursionError) as error:
        why = f"{shortened(' '.join(str(error).split()))}{way_out}"
        raise RecordError(f"{path} is no table of mjbiped's, or damaged, or cannot be written: {why}") from error


def _differences(kept: Mapping[str, object], now: Mapping[str, object]) -> list[str]:
    """Describe the differences between two identities."""
    before, after = dict(_flat(kept)), dict(_flat(now))
    changed = [name for name in {**before, **after} if before.get(name) != after.get(name)]
    if len(changed) > 1 and "cells" in changed:  # all else changes the cells, as the content of a terrain file does
        changed.remove("cells")
    found = []
    for name in changed:
        old, new = before.get(name, "nothing"), after.get(name, "nothing")
        words = _IN_WORDS.get(name, name.replace("controllers.", "the source of the controller ", 1))
        found.append(f"{words} changed" if max(len(old), len(new)) > _LONG else f"{name} was {old}, is {new}")
    return found


def _flat(table: Mapping[str, object], place: str = "") -> Iterator[tuple[str, str]]:
    """Flatten a nested table to dotted names, with its values as text."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{place}{key}.")
        else:
            yield f"{place}{key}", json.dumps(value, sort_keys=True)


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
