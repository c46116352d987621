"""Finished walks of the reproduction, kept on disk: what was walked once is not walked again."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

from mjbiped.errors import RecordError
from mjbiped.records.record import Walk
from mjbiped.reproduction.cell import KEY_DIGITS, Cell, Result, measured
from mjbiped.sweeps.cell import FAILED, Row
from mjbiped.sweeps.run import walk_cells
from mjbiped.sweeps.store import Layout, Store, opened

LAYOUT = Layout("walks", ("key", "inputs", "result"), lambda _, value: isinstance(value, str))
"""Of the table: a cell's key (it holds all that the walk depends on), its inputs and its result as JSON."""


class Walks:
    """A folder with a table of finished cells, and a file for each record that is kept, named by the cell's key.

    Attributes:
        folder: Where they are.
    """

    def __init__(self, store: Store) -> None:
        """Take an open table; see `opened_walks`."""
        self.folder = store.folder
        self._store = store

    def results(
        self, cells: Iterable[Cell], *, workers: int | None = None, progress: bool = False
    ) -> dict[str, Result]:
        """Walk all cells that are not kept yet, and keep each when it has ended.

        The results do not depend on the number of workers. A cell that fails is a result with an error's text, and is
        tried again the next time.

        Args:
            cells: Any number; equal ones are walked once.
            workers: Processes; one for each core unless given.
            progress: Show a progress bar (never where the output is not a terminal).

        Returns:
            The result of each cell, by its key.

        Raises:
            RecordError: The table is damaged, or a file cannot be written.
            MjbipedError: A process died, of lack of memory perhaps; what had ended is kept.
            KeyboardInterrupt: Ctrl-C; what had ended is kept.
        """
        wanted = {cell.key: cell for cell in cells}
        kept = self._kept(wanted)
        todo = [cell for key, cell in wanted.items() if key not in kept or kept[key].outcome == FAILED]
        # MuJoCo's take the longest, and longer the more steps they have
        todo.sort(key=lambda cell: (cell.engine != "mujoco", -(cell.steps or 0)))
        ended = len(wanted) - len(todo)
        walk_cells(partial(_walked, self.folder), todo, self._store, ended=ended, workers=workers, progress=progress)
        return self._kept(wanted)

    def record(self, cell: Cell) -> Walk:
        """The record of a finished cell that kept it.

        Raises:
            RecordError: There is none.
        """
        return Walk.load(record_path(self.folder, cell))

    def _kept(self, cells: Mapping[str, Cell]) -> dict[str, Result]:
        """The results of the cells that have ended, those apart of which something is no good."""
        found = {}
        for key, cell in cells.items():
            row = self._store.row(key) or {"result": ""}
            with suppress(ValueError, RecursionError, RecordError):
                result = Result.from_dict(json.loads(row["result"]))
                if cell.record and result.outcome != FAILED:
                    self.record(cell)
                found[key] = result
        return found


@contextmanager
def opened_walks(folder: Path, *, fresh: bool = False) -> Iterator[Walks]:
    """Take a folder for finished walks; no other process can meanwhile.

    Args:
        folder: Made if it is not there.
        fresh: Delete the walks that are there.

    Raises:
        InputError: The folder cannot be made, or another process has it.
        RecordError: The table is damaged, or cannot be written.
    """
    with opened(folder, LAYOUT, {}, fresh=fresh) as store:
        if fresh:
            for file in folder.glob(f"{'[0-9a-f]' * KEY_DIGITS}.npz"):
                file.unlink()
        yield Walks(store)


def record_path(folder: Path, cell: Cell) -> Path:
    """File of a cell's record."""
    return folder / f"{cell.key}.npz"


def _walked(folder: Path, cell: Cell) -> Row:
    """Let a cell walk, and keep its record; its row."""
    result, record = measured(cell)
    if record is not None:
        record.save(record_path(folder, cell))
    return {"key": cell.key, "inputs": json.dumps(cell.inputs), "result": json.dumps(result.to_dict())}
