"""A study's table on disk: an SQLite file that rows are added to, and a CSV file of all of them."""

from __future__ import annotations

import csv
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mjbiped.errors import InputError, RecordError
from mjbiped.output import written_whole
from mjbiped.study.cell import MEASURES, Row
from mjbiped.study.plan import Study

DATABASE, TABLE = "study.sqlite", "study.csv"

_LOCK = ".running"
_FORMAT = 1
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

    def __init__(self, folder: Path, columns: Sequence[str], database: sqlite3.Connection) -> None:
        """Take an open file; see `opened`."""
        self.folder = folder
        self.columns = tuple(columns)
        self._database = database

    def done(self) -> set[int]:
        """Indices of the cells that have a row."""
        return {index for (index,) in self._database.execute('SELECT "cell" FROM cells')}

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
        except sqlite3.Error as error:
            raise RecordError(f"cannot write {self.folder / DATABASE}: {error}") from error

    def rows(self) -> list[Row]:
        """All rows, in the order of the cells."""
        found = self._database.execute('SELECT * FROM cells ORDER BY "cell"')
        return [dict(zip(self.columns, values, strict=True)) for values in found]

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
        RecordError: The file is no study's table, or cannot be written.
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
        except (OSError, sqlite3.Error) as error:
            raise RecordError(f"cannot write {path}: {error}") from error
        try:
            columns = columns_of(study)
            _begin(database, path, columns, identity)
            yield Store(folder, columns, database)
        finally:
            database.close()


@contextmanager
def _exclusive(folder: Path) -> Iterator[None]:
    """Keep other processes out; the system lets go of the lock however this one ends.

    Raises:
        InputError: Another one is in.
    """
    lock = sqlite3.connect(folder / _LOCK, isolation_level=None, timeout=0.0)
    try:
        try:
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            raise InputError(
                f"the study in {folder} cannot be taken: another process is at it, or the folder cannot be written "
                f"({error})"
            ) from error
        yield
    finally:
        lock.close()


def _begin(database: sqlite3.Connection, path: Path, columns: Sequence[str], identity: Mapping[str, Any]) -> None:
    """Make the tables, or compare the identity of what is there."""
    text = {key: json.dumps(value, sort_keys=True) for key, value in identity.items()}
    try:
        with _transaction(database):
            empty = not database.execute("SELECT name FROM sqlite_master").fetchall()
            if empty:
                database.execute("CREATE TABLE identity (kind TEXT PRIMARY KEY, value TEXT)")
                database.execute("INSERT INTO identity VALUES ('format', ?)", (str(_FORMAT),))
                database.executemany("INSERT INTO identity VALUES (?, ?)", text.items())
                # no types: a value comes back as what it was
                named = ", ".join(f'"{name}"' + (" INTEGER PRIMARY KEY" if name == "cell" else "") for name in columns)
                database.execute(f"CREATE TABLE cells ({named})")
        kept = dict(database.execute("SELECT kind, value FROM identity"))
    except sqlite3.Error as error:
        raise RecordError(f"{path} is no study's table, or cannot be written: {error}") from error
    if kept.pop("format", None) != str(_FORMAT):
        raise RecordError(f"{path} is a table of another mjbiped's format: name another --out, or begin with --fresh")
    differences = [line for kind in text for line in _differences(kind, kept.get(kind), text[kind])]
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
