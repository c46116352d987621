"""A table of finished walks on disk: an SQLite file that grows row by row, and a CSV file of all rows."""

from __future__ import annotations

import csv
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
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


class Store:
    """An open table of finished walks.

    Attributes:
        folder: Folder of its files.
    """

    def __init__(self, path: Path, columns: Sequence[str], database: sqlite3.Connection) -> None:
        """Wrap an open database; `opened` does so."""
        self.folder = path.parent
        self._path = path
        self._columns = columns
        self._database = database

    def save(self, rows: Sequence[Row]) -> None:
        """Add all rows or none; a row replaces an earlier one with the same key.

        Raises:
            RecordError: The rows cannot be written.
        """
        marks = ", ".join("?" * len(self._columns))
        values = [tuple(row.get(name) for name in self._columns) for row in rows]
        with _explained(self._path), self._database:
            self._database.executemany(f"INSERT OR REPLACE INTO cells VALUES ({marks})", values)

    def rows(self) -> list[Row]:
        """Read all rows, in the order of their keys.

        Raises:
            RecordError: The file is damaged.
        """
        with _explained(self._path):
            return _rows(self._database)

    def export(self) -> Path:
        """Write the table as a CSV file; the same rows are the same bytes.

        Raises:
            RecordError: It cannot be written.
        """
        path = self._path.with_suffix(".csv")
        with saved(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self._columns)
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
    path = folder / f"{name}.sqlite"
    with _exclusive(folder / _LOCK):
        with _explained(path):
            for suffix in (".sqlite", ".sqlite-journal", ".csv", ".parquet") if fresh else ():
                path.with_suffix(suffix).unlink(missing_ok=True)
            database = sqlite3.connect(path)
        with closing(database):
            _begin(database, path, columns, {"format": _FORMAT, **identity})
            yield Store(path, columns, database)


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
        _check_tables(database)
        identity = {kind: json.loads(value) for kind, value in database.execute("SELECT kind, value FROM identity")}
        rows = _rows(database)
        if not all(isinstance(row.get(name), float | int | None) for row in rows for name in KNEES_MEASURES):
            raise ValueError("a measure is no number")
        return rows, identity


def _check_tables(database: sqlite3.Connection) -> None:
    """Refuse a file of somebody else's that holds more than tables: a view can be endless.

    Raises:
        sqlite3.Error: There is such a thing, or the file is damaged.
    """
    if database.execute("SELECT name FROM sqlite_master WHERE type IN ('view', 'trigger')").fetchall():
        raise sqlite3.DatabaseError("it holds a view or a trigger")


def _rows(database: sqlite3.Connection) -> list[Row]:
    """Read all rows, in the order of their keys."""
    found = database.execute("SELECT * FROM cells ORDER BY 1")
    names = [name for name, *_ in found.description]
    return [dict(zip(names, values, strict=True)) for values in found]


def make_folder(folder: Path) -> None:
    """Make a folder and its parents where they are missing.

    Raises:
        InputError: The folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error


@contextmanager
def _exclusive(file: Path) -> Iterator[None]:
    """Lock a file against other processes; the system releases the lock however this one ends.

    Raises:
        InputError: Another process has the lock.
    """
    with ExitStack() as stack:
        try:
            lock = stack.enter_context(closing(sqlite3.connect(file, timeout=0.0)))
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.Error as error:
            why = f"another process is at it, or {file} cannot be written, or is no lock of ours: delete it ({error})"
            raise InputError(f"the table in {file.parent} cannot be taken: {why}") from error
        yield


def _begin(database: sqlite3.Connection, path: Path, columns: Sequence[str], identity: Mapping[str, object]) -> None:
    """Make the tables of a new file, or compare the identity and the columns of an old one."""
    text = {kind: json.dumps(value, sort_keys=True) for kind, value in identity.items()}
    key, *others = (f'"{name}"' for name in columns)
    with _explained(path):
        with database:
            database.execute("BEGIN IMMEDIATE")
            _check_tables(database)
            if not database.execute("SELECT name FROM sqlite_master").fetchall():
                database.execute("CREATE TABLE identity (kind TEXT PRIMARY KEY, value TEXT)")
                # no types: values stay as they are
                database.execute(f"CREATE TABLE cells ({', '.join((f'{key} PRIMARY KEY', *others))})")
                database.executemany("INSERT INTO identity VALUES (?, ?)", text.items())
        differences = _differences(dict(database.execute("SELECT kind, value FROM identity")), text)
        found = [name for _, name, *_ in database.execute("PRAGMA table_info(cells)")]
        if not differences and found != [*columns]:
            raise sqlite3.DatabaseError("its columns are others than they must be: another version of mjbiped made it")
    if differences:
        more = f" and {len(differences) - _SHOWN} more" if len(differences) > _SHOWN else ""
        raise InputError(
            f"the rows in {path.parent} are of another study: {'; '.join(differences[:_SHOWN])}{more}. Name another "
            "--out, undo the change, or delete these rows and begin again with --fresh"
        )


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


def _differences(kept: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Describe the differences between two identities."""
    before, after = (dict(_flat({kind: json.loads(text) for kind, text in each.items()})) for each in (kept, now))
    found = []
    for name in dict.fromkeys((*before, *after)):
        old, new = before.get(name, "nothing"), after.get(name, "nothing")
        if old != new:
            words = _IN_WORDS.get(name, name.replace("controllers.", "the source of the controller ", 1))
            found.append(f"{words} changed" if max(len(old), len(new)) > _LONG else f"{name} was {old}, is {new}")
    # the content of a terrain file changes the cells, and so does all else
    return [each for each in found if len(found) == 1 or not each.startswith(_IN_WORDS["cells"])]


def _flat(table: Mapping[str, object], place: str = "") -> Iterator[tuple[str, str]]:
    """Flatten a nested table to dotted names, with its values as text."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{place}{key}.")
        else:
            yield f"{place}{key}", json.dumps(value)
