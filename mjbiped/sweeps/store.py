"""A table of finished walks on disk: an SQLite file that grows row by row, and a CSV file of all rows."""

from __future__ import annotations

import csv
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mjbiped.errors import InputError, RecordError, shortened
from mjbiped.sweeps.cell import KNEES_MEASURES, Row
from mjbiped.utils.files import saved

_LOCK = ".running"
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
        fresh: Delete the rows that are kept.

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
            for suffix in (".sqlite", ".sqlite-journal", ".csv", ".parquet") if fresh else ():
                path.with_suffix(suffix).unlink(missing_ok=True)
            database = stack.enter_context(closing(sqlite3.connect(path)))
            _begin(database, columns, wanted)
            differences = _differences(_identity(database), json.loads(json.dumps(wanted)))
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


def read_table(path: Path) -> tuple[list[Row], dict[str, Any]]:
    """Read the rows and the identity of a study's table that another process may be writing.

    Args:
        path: Path of the SQLite file.

    Returns:
        The rows in the order of their keys, and the identity that `opened` was given.

    Raises:
        RecordError: The file is no table of mjbiped's, or a damaged one.
    """
    address = f"{path.absolute().as_uri()}?mode=ro"
    with _explained(path, ""), closing(sqlite3.connect(address, uri=True)) as database:
        _tables(database)
        identity, rows = _identity(database), _rows(database)
        if not all(isinstance(row.get(name), float | int | None) for row in rows for name in KNEES_MEASURES):
            raise ValueError("a measure is no number")
        return rows, identity


def make_folder(folder: Path) -> None:
    """Make a folder and its parents where they are missing.

    Raises:
        InputError: The folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error


def _begin(database: sqlite3.Connection, columns: Sequence[str], identity: Mapping[str, object]) -> None:
    """Make the tables of a new file."""
    with database:
        database.execute("BEGIN IMMEDIATE")
        if not _tables(database):
            key, *others = (f'"{name}"' for name in columns)
            database.execute("CREATE TABLE identity (kind TEXT PRIMARY KEY, value TEXT)")
            # no types: values stay as they are
            database.execute(f"CREATE TABLE cells ({', '.join((f'{key} PRIMARY KEY', *others))})")
            texts = ((kind, json.dumps(value, sort_keys=True)) for kind, value in identity.items())
            database.executemany("INSERT INTO identity VALUES (?, ?)", texts)


def _tables(database: sqlite3.Connection) -> list[str]:
    """Names of what a file holds; one with more than tables is somebody else's, and a view in it can be endless.

    Raises:
        ValueError: The file holds a view or a trigger.
    """
    found = dict(database.execute("SELECT name, type FROM sqlite_master"))
    if not {*found.values()} <= {"table", "index"}:
        raise ValueError("it holds a view or a trigger")
    return [*found]


def _identity(database: sqlite3.Connection) -> dict[str, Any]:
    return {kind: json.loads(value) for kind, value in database.execute("SELECT kind, value FROM identity")}


def _rows(database: sqlite3.Connection) -> list[Row]:
    """Read all rows, in the order of their keys."""
    found = database.execute("SELECT * FROM cells ORDER BY 1")
    names = [name for name, *_ in found.description]
    return [dict(zip(names, values, strict=True)) for values in found]


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
    found = []
    for name in changed:
        old, new = before.get(name, "nothing"), after.get(name, "nothing")
        if name == "cells" and len(changed) > 1:  # all else changes the cells, as the content of a terrain file does
            continue
        words = _IN_WORDS.get(name, name.replace("controllers.", "the source of the controller ", 1))
        found.append(f"{words} changed" if max(len(old), len(new)) > _LONG else f"{name} was {old}, is {new}")
    return found


def _flat(table: Mapping[str, object], place: str = "") -> Iterator[tuple[str, str]]:
    """Flatten a nested table to dotted names, with its values as text."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{place}{key}.")
        else:
            yield f"{place}{key}", json.dumps(value)
