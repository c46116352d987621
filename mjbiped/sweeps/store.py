"""A study's table on disk: an SQLite file that rows are added to, and a CSV file of all of them."""

from __future__ import annotations

import csv
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

from mjbiped.errors import InputError, RecordError, shown
from mjbiped.records.schema import OUTCOMES
from mjbiped.sweeps.cell import FAILED, MEASURES, Row
from mjbiped.sweeps.plan import Study
from mjbiped.utils.files import written_whole

DATABASE, TABLE = "study.sqlite", "study.csv"

_LOCK = ".running"
_FORMAT = 1
_BROKEN = (sqlite3.Error, UnicodeDecodeError)  # an error's text may hold what stands in a damaged file
_IDENTITY = "CREATE TABLE identity (kind TEXT PRIMARY KEY, value TEXT)"
_WAY_OUT = "; name another --out, or begin again with --fresh"
_SHOWN = 5  # differences in a message
_IN_WORDS = {"sources": "mjbiped's source files", "cells": "the content of a terrain file"}
"""Kinds of an identity that are digests; all else that cells depend on has a kind of its own."""


def columns_of(study: Study) -> tuple[str, ...]:
    """Names of the table's columns."""
    return ("cell", *(("sample",) if study.drawn else ()), *study.varied, "outcome", "error", *MEASURES)


class Store:
    """The rows of a study that have ended.

    Attributes:
        folder: Where they are.
        columns: Of the table.
    """

    def __init__(self, folder: Path, study: Study, database: sqlite3.Connection) -> None:
        """Take an open file; see `opened`."""
        self.folder = folder
        self.columns = columns_of(study)
        self._cells = len(study.cells)
        self._database = database

    def done(self) -> set[int]:
        """Indices of the cells that have a row.

        Raises:
            RecordError: The file is damaged.
        """
        return {row["cell"] for row in self.rows()}

    def save(self, rows: Sequence[Row]) -> None:
        """Add rows, all of them or none.

        Raises:
            RecordError: They cannot be written.
        """
        marks = ", ".join("?" * len(self.columns))
        values = [tuple(row.get(name) for name in self.columns) for row in rows]
        try:
            with _transaction(self._database):
                self._database.executemany(f"INSERT INTO cells VALUES ({marks})", values)
        except _BROKEN as error:
            raise RecordError(f"cannot write {self.folder / DATABASE}: {error}") from error

    def rows(self) -> list[Row]:
        """All rows, in the order of the cells.

        Raises:
            RecordError: The file is damaged.
        """
        try:
            found = self._database.execute('SELECT * FROM cells ORDER BY "cell"').fetchall()
        except _BROKEN as error:
            raise _damaged(self.folder / DATABASE, str(error)) from error
        rows = [dict(zip(self.columns, values, strict=True)) for values in found]
        for row in rows:
            wrong = next((name for name, value in row.items() if not self._fits(name, value)), None)
            if wrong is not None:
                place = f"{wrong} of cell {shown(row['cell'])} is {shown(row[wrong])}"
                raise _damaged(self.folder / DATABASE, f"{place}, which no walk of this study has")
        return rows

    def _fits(self, name: str, value: Any) -> bool:
        """Whether a value can stand in a column."""
        if name == "cell":
            return value in range(self._cells)
        if name == "outcome":
            return value in (*OUTCOMES, FAILED)
        if name == "error":
            return isinstance(value, str | None)
        return isinstance(value, float | int | None) or (name not in MEASURES and isinstance(value, str))

    def export(self) -> Path:
        """Write the table as a CSV file; the same rows are the same bytes.

        Raises:
            RecordError: It cannot be written.
        """
        path = self.folder / TABLE
        try:
            with written_whole(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(self.columns)
                writer.writerows([row[name] for name in self.columns] for row in self.rows())
        except OSError as error:
            raise RecordError(f"cannot write {path}: {error.strerror or error}") from error
        return path


@contextmanager
def opened(folder: Path, study: Study, identity: Mapping[str, Any], *, fresh: bool = False) -> Iterator[Store]:
    """Open a study's table, or begin one; no other process can meanwhile.

    Args:
        folder: Where it is; made if it is not there.
        study: What the table is of.
        identity: All that its rows depend on, in plain JSON types by kind; rows of another identity are refused.
        fresh: Delete the rows that are there.

    Raises:
        InputError: The folder cannot be made, another process has it, or its rows are of another identity.
        RecordError: The file is no study's table, or a damaged one, or cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error
    path = folder / DATABASE
    with _exclusive(folder):
        try:
            if fresh:
                for file in (path, path.with_name(f"{path.name}-journal"), folder / TABLE):
                    file.unlink(missing_ok=True)
            database = sqlite3.connect(path, isolation_level=None)
        except (OSError, *_BROKEN) as error:
            raise RecordError(f"cannot write {path}: {error}") from error
        try:
            _begin(database, path, columns_of(study), identity)
            yield Store(folder, study, database)
        finally:
            database.close()


@contextmanager
def _exclusive(folder: Path) -> Iterator[None]:
    """Keep other processes out; the system lets go of the lock however this one ends.

    Raises:
        InputError: Another one is in.
    """
    with ExitStack() as stack:
        try:
            lock = stack.enter_context(closing(sqlite3.connect(folder / _LOCK, isolation_level=None, timeout=0.0)))
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            raise InputError(
                f"the study in {folder} cannot be taken: another process is at it, or the folder cannot be written "
                f"({error})"
            ) from error
        except _BROKEN as error:
            raise InputError(
                f"the study in {folder} cannot be taken: {folder / _LOCK} is no lock of ours ({error}); delete it"
            ) from error
        yield


def _begin(database: sqlite3.Connection, path: Path, columns: Sequence[str], identity: Mapping[str, Any]) -> None:
    """Make the tables, or compare the identity of what is there."""
    text = {key: json.dumps(value, sort_keys=True) for key, value in identity.items()}
    # no types: a value comes back as what it was
    named = ", ".join(f'"{name}"' + (" INTEGER PRIMARY KEY" if name == "cell" else "") for name in columns)
    made = [_IDENTITY, f"CREATE TABLE cells ({named})"]
    try:
        with _transaction(database):
            empty = not database.execute("SELECT name FROM sqlite_master").fetchall()
            if empty:
                for statement in made:
                    database.execute(statement)
                database.execute("INSERT INTO identity VALUES ('format', ?)", (str(_FORMAT),))
                database.executemany("INSERT INTO identity VALUES (?, ?)", text.items())
        kept = dict(database.execute("SELECT kind, value FROM identity"))
        found = [sql for (sql,) in database.execute("SELECT sql FROM sqlite_master WHERE sql NOT NULL ORDER BY rowid")]
        health = database.execute("PRAGMA quick_check").fetchall()
    except _BROKEN as error:
        raise RecordError(f"{path} is no study's table, or cannot be written: {error}{_WAY_OUT}") from error
    if health != [("ok",)]:
        raise _damaged(path, str(health[0][0]))
    if kept.pop("format", None) != str(_FORMAT):
        raise RecordError(f"{path} is a table of another mjbiped's format{_WAY_OUT}")
    try:
        differences = [line for kind in text for line in _differences(kind, kept.get(kind), text[kind])]
    except (TypeError, ValueError, RecursionError) as error:
        raise _damaged(path, f"it does not tell its study ({shown(error)})") from error
    if len(differences) > 1:
        differences = [
            line for line in differences if not line.startswith(_IN_WORDS["cells"])
        ]  # follows from the others
    if differences:
        more = f" and {len(differences) - _SHOWN} more" if len(differences) > _SHOWN else ""
        raise InputError(
            f"the rows in {path.parent} are of another study: {'; '.join(differences[:_SHOWN])}{more}. Name another "
            "--out, undo the change, or delete these rows and begin again with --fresh"
        )
    if found != made:
        raise _damaged(path, "its tables are others than this study's")


def _damaged(path: Path, why: str) -> RecordError:
    return RecordError(f"{path} is damaged: {' '.join(why.split())}{_WAY_OUT}")


def _differences(kind: str, kept: str | None, now: str) -> Iterator[str]:
    """What differs, in words."""
    if kept == now:
        return
    before, after = _flat(kind, json.loads(kept or "null")), _flat(kind, json.loads(now))
    for name in dict.fromkeys((*before, *after)):
        old, new = before.get(name, "nothing"), after.get(name, "nothing")
        if old != new:
            long = max(len(old), len(new)) > 60
            yield f"{_IN_WORDS.get(name, name)} changed" if long else f"{name} was {old}, is {new}"


def _flat(name: str, value: Any) -> dict[str, str]:
    """A nested table by dotted names, its values as text."""
    if not isinstance(value, dict):
        return {name: json.dumps(value)}
    return {key: text for inner, each in value.items() for key, text in _flat(f"{name}.{inner}", each).items()}


@contextmanager
def _transaction(database: sqlite3.Connection) -> Iterator[None]:
    database.execute("BEGIN IMMEDIATE")
    try:
        yield
    except BaseException:
        database.rollback()
        raise
    database.commit()


def as_column(rows: Iterable[Row], name: str) -> list[Any]:
    """A column of the table."""
    return [row[name] for row in rows]
