"""The samples of all walks of a study, in one Parquet file.

While walks are made, each leaves a file of its own; those are joined into one when all have ended. So what has walked
is not lost where the study is broken off, and is not walked again.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from mjbiped.records.columns import tables_of
from mjbiped.records.frames import units_of
from mjbiped.robots.kinds import KINDS
from mjbiped.sweeps.cell import TRAJECTORY, Row
from mjbiped.utils.extras import needed
from mjbiped.utils.files import saved

FILE = "trajectories.parquet"
"""A row per sample: `cell` is the walk's number, the others are the columns of `Walk.to_pandas().samples`."""

_PIECES = "trajectories"
_SUFFIX = ".parquet"


def forget(folder: Path) -> None:
    """Delete what an earlier run kept in a folder."""
    (folder / FILE).unlink(missing_ok=True)
    shutil.rmtree(folder / _PIECES, ignore_errors=True)


class Trajectories:
    """The samples that a study has so far."""

    def __init__(self, folder: Path, count: int) -> None:
        """Look into a folder.

        Args:
            folder: Of the study's table.
            count: Walks of the study.

        Raises:
            InputError: PyArrow is not installed.
        """
        self._arrow = needed("pyarrow", "data", "keeping trajectories")
        self._parquet = needed("pyarrow.parquet", "data", "keeping trajectories")
        self._whole, self._pieces, self._count = folder / FILE, folder / _PIECES, count

    def cells(self) -> set[int]:
        """The walks whose samples are there."""
        if self._whole.is_file():
            return set(range(self._count))
        return {int(piece.stem) for piece in self._pieces.glob(f"*{_SUFFIX}") if piece.stem.isdecimal()}

    def keep(self, rows: Sequence[Row]) -> None:
        """Keep the samples of walks that have ended; those of a walk that failed at once are none.

        Raises:
            RecordError: They cannot be written.
        """
        self._pieces.mkdir(exist_ok=True)
        for row in rows:
            columns = row.get(TRAJECTORY, {})
            length = len(next(iter(columns.values()), ()))
            table = self._arrow.table({"cell": np.full(length, row["cell"], dtype=np.int64), **columns})
            with saved(self._pieces / f"{row['cell']}{_SUFFIX}") as unfinished:
                self._parquet.write_table(table, unfinished)

    def join(self) -> None:
        """Put the samples of all walks into one file, in the order of the walks; one walk is in memory at a time.

        Raises:
            RecordError: It cannot be written.
        """
        if self._whole.is_file():
            return
        pieces = [self._pieces / f"{cell}{_SUFFIX}" for cell in range(self._count)]
        # controllers differ in the number of their states, robots in that of their angles: what one has not is null
        schema = self._arrow.unify_schemas([self._parquet.read_schema(piece) for piece in pieces])
        known = {name: unit for kind in KINDS.values() for name, unit in units_of(tables_of(kind).samples).items()}
        units = {name: unit for name, unit in known.items() if name in schema.names}
        schema = schema.with_metadata({"PANDAS_ATTRS": json.dumps({"units": units})})  # pandas' own name for `attrs`
        with saved(self._whole) as unfinished, self._parquet.ParquetWriter(unfinished, schema) as writer:
            for piece in pieces:
                table = self._parquet.read_table(piece)
                writer.write_table(self._arrow.concat_tables([schema.empty_table(), table], promote_options="default"))
        with suppress(OSError):
            shutil.rmtree(self._pieces)
