"""Finished cells on disk: what was walked once is not walked again."""

from __future__ import annotations

import json
from pathlib import Path

from mjbiped.errors import InputError, RecordError
from mjbiped.output import written_whole
from mjbiped.record import Walk
from mjbiped.reproduction.cell import FAILED, Cell, Result


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
        path = self._path(cell)
        try:
            with written_whole(path) as unfinished:
                text = json.dumps({"cell": cell.inputs, "result": result.to_dict()})
                unfinished.write_text(text, encoding="utf-8")
        except OSError as error:
            raise RecordError(f"cannot write {path}: {error.strerror or error}") from error

    def record(self, cell: Cell) -> Walk:
        """The record of a finished cell that kept it.

        Raises:
            RecordError: There is none.
        """
        return Walk.load(self.record_path(cell))

    def record_path(self, cell: Cell) -> Path:
        """File of a cell's record."""
        return self.folder / f"{cell.key}.npz"

    def _path(self, cell: Cell) -> Path:
        return self.folder / f"{cell.key}.json"
