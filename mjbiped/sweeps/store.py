"""A table of finished walks on disk: an SQLite file that grows row by row, and a CSV file of all rows."""

from __future__ import annotations

import csv
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from mjbiped.errors import InputError, RecordError, shortened, shown
from mjbiped.records.schema import OUTCOMES
from mjbiped.sweeps.cell import FAILED, Row
from mjbiped.utils.files import saved

_LOCK = ".running"
_FORMAT = 1
_BROKEN = (sqlite3.Error, UnicodeDecodeError)  # an error's text may hold what stands in a damaged file
_BEGIN = "BEGIN IMMEDIATE"  # a connection's own block ends it: all of it is kept, or none
_IDENTITY = "CREATE TABLE identity (kind TEXT PRIMARY KEY, value TEXT)"
_WAY_OUT = "; name another --out, or begin again with --fresh"
_OTHERS = "its tables are others than they must be, or another version of mjbiped made them"
_SHOWN = 5  # differences in a message
_IN_WORDS = {"sources": "mjbiped's source files", "cells": "the content of a terrain file"}
"""Kinds of an identity that are digests; all else that cells depend on has a kind of its own."""
_OF_CONTROLLERS = "controllers."  # digests too, by the names of the user's own


class Layout(NamedTuple):
    """Columns of a table, and the values they can hold.

    Attributes:
        name: Name of its files, without their suffixes.
        columns: Names of the columns; no two rows have the same value in the first, the key.
        keys: The numbers that can be keys; None: keys are texts.
        numbers: Columns that hold numbers or nothing; others, apart from "outcome" and "error", can hold texts too.
    """

    name: str
    columns: tuple[str, ...]
    keys: range | None
    numbers: frozenset[str]

    def fits(self, name: str, value: Any) -> bool:
        """Whether a value can stand in a column."""
        if name == self.columns[0]:
            return isinstance(value, str) if self.keys is None else type(value) is int and value in self.keys
        if name == "outcome":
            return value in (*OUTCOMES, FAILED)
        if name == "error":
            return isinstance(value, str | None)
        return isinstance(value, float | int | None) or (name not in self.numbers and isinstance(value, str))


class Store:
    """An open table of finished walks.

    Attributes:
        folder: Folder of its files.
    """

    def __init__(self, path: Path, layout: Layout, database: sqlite3.Connection) -> None:
        """Wrap an open database; `opened` does so."""
        self.folder = path.parent
        self._path = path
        self._layout = layout
        self._database = database

    def save(self, rows: Sequence[Row]) -> None:
        """Add all rows or none; a row replaces an earlier one with the same key.

        Raises:
            RecordError: The rows cannot be written.
        """
        marks = ", ".join("?" * len(self._layout.columns))
        values = [tuple(row.get(name) for name in self._layout.columns) for row in rows]
        try:
            with self._database:
                self._database.execute(_BEGIN)
                self._database.executemany(f"INSERT OR REPLACE INTO cells VALUES ({marks})", values)
        except _BROKEN as error:
            raise RecordError(f"cannot write {self._path}: {error}") from error

    def rows(self) -> list[Row]:
        """Read all rows, in the order of their keys.

        Raises:
            RecordError: The file is damaged.
        """
        return self._read(f'ORDER BY "{self._layout.columns[0]}"')

    def row(self, key: Any) -> Row | None:
        """Read the row of a key; None without one.

        Raises:
            RecordError: The file is damaged.
        """
        return next(iter(self._read(f'WHERE "{self._layout.columns[0]}" = ?', key)), None)

    def _read(self, which: str, *values: Any) -> list[Row]:
        """Read some rows, and check every value."""
        try:
            found = self._database.execute(f"SELECT * FROM cells {which}", values).fetchall()
        except _BROKEN as error:
            raise _damaged(self._path, str(error)) from error
        rows = [dict(zip(self._layout.columns, values, strict=True)) for values in found]
        for row in rows:
            wrong = next((name for name, value in row.items() if not self._layout.fits(name, value)), None)
            if wrong is not None:
                place = f"{wrong} of cell {shown(row[self._layout.columns[0]])} is {shown(row[wrong])}"
                raise _damaged(self._path, f"{place}, which no walk here has")
        return rows

    def export(self) -> Path:
        """Write the table as a CSV file; the same rows are the same bytes.

        Raises:
            RecordError: It cannot be written.
        """
        path = self._path.with_suffix(".csv")
        with saved(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self._layout.columns)
            writer.writerows([row[name] for name in self._layout.columns] for row in self.rows())
        return path


@contextmanager
def opened(folder: Path, layout: Layout, identity: Mapping[str, Any], *, fresh: bool = False) -> Iterator[Store]:
    """Open a table or begin one, and keep other processes out.

    Args:
        folder: Folder of the table; it is made if missing.
        layout: Columns of the table.
        identity: Everything on which its rows depend, by kind, in plain JSON types; another identity is refused.
        fresh: Delete the rows that are kept.

    Raises:
        InputError: The folder cannot be made, another process has it, or its rows are of another identity.
        RecordError: The file is no table of mjbiped's, or a damaged one, or cannot be written.
    """
    make_folder(folder)
    path = folder / f"{layout.name}.sqlite"
    with _exclusive(folder):
        try:
            if fresh:
                for file in (
                    path,
                    path.with_name(f"{path.name}-journal"),
                    *map(path.with_suffix, (".csv", ".parquet")),
                ):
                    file.unlink(missing_ok=True)
            database = sqlite3.connect(path, isolation_level=None)
        except (OSError, *_BROKEN) as error:
            raise RecordError(f"cannot write {path}: {error}") from error
        try:
            _begin(database, path, layout.columns, identity)
            yield Store(path, layout, database)
        finally:
            database.close()


def read_table(path: Path) -> tuple[list[Row], dict[str, Any]]:
    """Read the rows and the identity of a table that another process may be writing.

    Args:
        path: Path of the SQLite file.

    Returns:
        The rows in the order of their keys, and the identity that `opened` was given.

    Raises:
        RecordError: The file is no table of mjbiped's, or a damaged one.
    """
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as database:
            _check_tables(database)
            identity = {kind: json.loads(value) for kind, value in database.execute("SELECT kind, value FROM identity")}
            found = database.execute("SELECT * FROM cells ORDER BY 1")
            names = [name for name, *_ in found.description]
            rows = [dict(zip(names, values, strict=True)) for values in found]
    except (*_BROKEN, ValueError, TypeError, RecursionError) as error:
        raise RecordError(f"{path} is no table of mjbiped's, or a damaged one: {error}") from error
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


@contextmanager
def _exclusive(folder: Path) -> Iterator[None]:
    """Lock a folder against other processes; the system releases the lock however this one ends.

    Raises:
        InputError: Another process has the lock.
    """
    with ExitStack() as stack:
        try:
            lock = stack.enter_context(closing(sqlite3.connect(folder / _LOCK, isolation_level=None, timeout=0.0)))
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            raise InputError(
                f"the table in {folder} cannot be taken: another process is at it, or the folder cannot be written "
                f"({error})"
            ) from error
        except _BROKEN as error:
            raise InputError(
                f"the table in {folder} cannot be taken: {folder / _LOCK} is no lock of ours ({error}); delete it"
            ) from error
        yield


def _begin(database: sqlite3.Connection, path: Path, columns: Sequence[str], identity: Mapping[str, Any]) -> None:
    """Make the tables of a new file, or check those of an old one and compare its identity."""
    text = {key: json.dumps(value, sort_keys=True) for key, value in identity.items()}
    made = _statements(columns)
    try:
        with database:
            database.execute(_BEGIN)
            empty = not database.execute("SELECT name FROM sqlite_master").fetchall()
            if empty:
                for statement in made:
                    database.execute(statement)
                database.execute("INSERT INTO identity VALUES ('format', ?)", (str(_FORMAT),))
                database.executemany("INSERT INTO identity VALUES (?, ?)", text.items())
        found = _check_tables(database)
        kept = dict(database.execute("SELECT kind, value FROM identity"))
        health = database.execute("PRAGMA quick_check").fetchall()
    except _BROKEN as error:
        raise RecordError(f"{path} is no table of mjbiped's, or cannot be written: {error}{_WAY_OUT}") from error
    if health != [("ok",)]:
        raise _damaged(path, str(health[0][0]))
    if kept.pop("format", None) != str(_FORMAT):
        raise RecordError(f"{path} is a table of another mjbiped's format{_WAY_OUT}")
    try:
        differences = [line for kind in text for line in _differences(kind, kept.get(kind), text[kind])]
    except (TypeError, ValueError, RecursionError) as error:
        raise _damaged(path, f"it does not tell what its rows are of ({shown(error)})") from error
    if len(differences) > 1:  # the content of a file follows from the others
        differences = [line for line in differences if not line.startswith(_IN_WORDS["cells"])]
    if differences:
        more = f" and {len(differences) - _SHOWN} more" if len(differences) > _SHOWN else ""
        raise InputError(
            f"the rows in {path.parent} are of another study: {'; '.join(differences[:_SHOWN])}{more}. Name another "
            "--out, undo the change, or delete these rows and begin again with --fresh"
        )
    if found != made:
        raise _damaged(path, _OTHERS)


def _statements(columns: Sequence[str]) -> list[str]:
    """The statements that make the tables of a file."""
    key, *others = (f'"{name}"' for name in columns)
    # no types: values stay as they are
    return [_IDENTITY, f"CREATE TABLE cells ({', '.join((f'{key} PRIMARY KEY', *others))})"]


def _check_tables(database: sqlite3.Connection) -> list[str]:
    """Refuse a file that holds anything but two plain tables, before they are read: a view can be without end.

    Returns:
        The statements that made the tables.

    Raises:
        sqlite3.Error: There is something else, or the file is damaged.
    """
    found = [sql for (sql,) in database.execute("SELECT sql FROM sqlite_master WHERE sql NOT NULL ORDER BY rowid")]
    columns = [name for _, name, *_ in database.execute("PRAGMA table_info(cells)")]
    if not columns or found != _statements(columns):
        raise sqlite3.DatabaseError(_OTHERS)
    return found


def _damaged(path: Path, why: str) -> RecordError:
    return RecordError(f"{path} is damaged: {shortened(' '.join(why.split()))}{_WAY_OUT}")


def _differences(kind: str, kept: str | None, now: str) -> Iterator[str]:
    """Describe the differences between two values of an identity."""
    if kept == now:
        return
    before, after = _flat(kind, json.loads(kept or "null")), _flat(kind, json.loads(now))
    for name in dict.fromkeys((*before, *after)):
        old, new = before.get(name, "nothing"), after.get(name, "nothing")
        if old != new:
            long = max(len(old), len(new)) > 60
            words = _IN_WORDS.get(name, name)
            if name.startswith(_OF_CONTROLLERS):
                words = f"the source of the controller {name.removeprefix(_OF_CONTROLLERS)}"
            yield f"{words} changed" if long else f"{name} was {old}, is {new}"


def _flat(name: str, value: Any) -> dict[str, str]:
    """Flatten a nested table to dotted names, with its values as text."""
    if not isinstance(value, dict):
        return {name: json.dumps(value)}
    return {key: text for inner, each in value.items() for key, text in _flat(f"{name}.{inner}", each).items()}
