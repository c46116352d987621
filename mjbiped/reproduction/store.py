"""Finished cells on disk: what was walked once is not walked again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mjbiped.errors import InputError, RecordError
from mjbiped.records.record import Walk
from mjbiped.reproduction.cell import FAILED, Cell, Result
from mjbiped.utils.files import written_whole


class Store:
    """A folder with a file per finished cell, named by the cell's key; files appear whole or not at all.

    Attributes:
        folder: Where the files are.
    """

    def __init__(self, folder: Path) -> None:
        """Take a folder, and make it if it is not there.

        Raises:
            InputError: It cannot be made.
        """
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error

    def load(self, cell: Cell) -> Result | None:
        """The result of a cell that was finished; None where it was not, or failed, or a file of it is no good."""
        try:
            result = Result.from_dict(json.loads(self._path(cell).read_text(encoding="utf-8"))["result"])
            if cell.record and result.outcome != FAILED:
                self.record(cell)
        except (OSError, ValueError, TypeError, KeyError, RecursionError, RecordError):
            return None
        return None if result.outcome == FAILED else result

    def save(self, cell: Cell, result: Result, walk: Walk | None) -> None:
        """Keep a result, and its record first.

        Raises:
            RecordError: A file cannot be written.
        """
        if walk is not None:
            walk.save(self.record_path(cell))
        self._write(self._path(cell), {"cell": cell.inputs, "result": result.to_dict()})

    def load_numbers(self, key: str) -> list[list[float]] | None:
        """The numbers that were kept under a key; None where there are none, or their file is no good."""
        try:
            rows = json.loads(self._numbers_path(key).read_text(encoding="utf-8"))["numbers"]
            return [[float(value) for value in row] for row in rows]
        except (OSError, ValueError, TypeError, KeyError):
            return None

    def save_numbers(self, key: str, numbers: list[list[float]]) -> None:
        """Keep numbers of many walks, a row each.

        Raises:
            RecordError: The file cannot be written.
        """
        self._write(self._numbers_path(key), {"numbers": numbers})

    def record(self, cell: Cell) -> Walk:
        """The record of a finished cell that kept it.

        Raises:
            RecordError: There is none.
        """
        return Walk.load(self.record_path(cell))

    def record_path(self, cell: Cell) -> Path:
        """File of a cell's record."""
        return self.folder / f"{cell.key}.npz"

    def _write(self, path: Path, content: Any) -> None:
        try:
            with written_whole(path) as unfinished:
                unfinished.write_text(json.dumps(content), encoding="utf-8")
        except OSError as error:
            raise RecordError(f"cannot write {path}: {error.strerror or error}") from error

    def _numbers_path(self, key: str) -> Path:
        return self.folder / f"many_{key}.json"

    def _path(self, cell: Cell) -> Path:
        return self.folder / f"{cell.key}.json"
