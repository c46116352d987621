"""Formats of other programs: records of walks as tables here, and scenes, robots and recordings in the modules."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from mjbiped.errors import InputError, shown
from mjbiped.records.columns import Columns, Table, attributes, flat_samples, flat_touchdowns, tables_of, units_of
from mjbiped.records.record import Walk
from mjbiped.utils.files import saved
from mjbiped.utils.packages import needed

OWN, CSV, PARQUET, MCAP = ".npz", ".csv", ".parquet", ".mcap"

MODULES: Mapping[str, tuple[str, str] | None] = {
    CSV: None,
    PARQUET: ("pyarrow.parquet", "data"),
    MCAP: ("mcap_ros2.writer", "ros"),
}
"""Suffixes of the formats, with the module that each needs, and the extra that has it."""


def check_format(path: Path) -> Path:
    """Return the path of a record in a foreign format that can be written here.

    Raises:
        InputError: The suffix is unknown, or the extra of its format is not installed.
    """
    if path.suffix not in MODULES:
        raise InputError(f"{shown(str(path))} must end in {' or '.join(MODULES)}")
    if (extra := MODULES[path.suffix]) is not None:
        needed(*extra, f"a file {path.name}")
    return path


def export_walk(walk: Walk, path: str | Path) -> None:
    """Write the record of a walk for other programs, in the format that the suffix names.

    Args:
        walk: The walk.
        path: File to write. `.csv` and `.parquet` hold the samples, with the touchdowns in a second file beside it:
            `walk.csv` and `walk_touchdowns.csv`. `.mcap` is a recording of ROS 2 messages (`mjbiped.exchange.ros`).

    Raises:
        InputError: The suffix is another, the format's extra is not installed, or a recording would have no samples.
        RecordError: A file cannot be written.
    """
    for file, write in parts_of(walk, check_format(Path(path))).values():
        write(file)


def parts_of(walk: Walk, path: Path) -> dict[str, tuple[Path, Callable[[Path], None]]]:
    """Return the files of a record in the format of a path, by kind, each with the function that writes it."""
    if path.suffix == OWN:
        return {"record": (path, walk.save)}
    if path.suffix == MCAP:
        from mjbiped.exchange.ros import write_recording  # for recordings alone

        return {"record": (path, partial(write_recording, walk))}
    samples, touchdowns = tables_of(type(walk.robot))
    beside = path.with_stem(f"{path.stem}_touchdowns")
    return {
        "record": (path, partial(_write, flat_samples(walk), samples)),
        "touchdowns": (beside, partial(_write, flat_touchdowns(walk), touchdowns)),
    }


def _write(table: Table, columns: Columns, path: Path) -> None:
    """Write a flat table: all digits, and in Parquet units that pandas finds in `frame.attrs`."""
    if path.suffix == PARQUET:
        parquet, arrow = (needed(module, "data", "a Parquet file") for module in ("pyarrow.parquet", "pyarrow"))
        with saved(path) as unfinished:
            parquet.write_table(arrow.table(table).replace_schema_metadata(attributes(units_of(columns))), unfinished)
        return
    with saved(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table)
        writer.writerows(zip(*(column.tolist() for column in table.values()), strict=True))
