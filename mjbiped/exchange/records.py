"""Records of walks in the formats of other programs: which there are, and the files that a record becomes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from mjbiped.errors import InputError, shown
from mjbiped.exchange.mcap import write_recording
from mjbiped.exchange.tables import CSV, PARQUET, write_samples, write_touchdowns
from mjbiped.records.record import Walk
from mjbiped.utils.packages import needed

MCAP = ".mcap"
MODULES = {CSV: None, PARQUET: ("pyarrow.parquet", "data"), MCAP: ("mcap_ros2.writer", "ros")}
"""Suffixes of the formats, with the module that each needs, and the extra that has it."""


def export_walk(walk: Walk, path: str | Path) -> None:
    """Write the record of a walk for other programs, in the format that the suffix names.

    Args:
        walk: The walk.
        path: File to write. `.csv` and `.parquet` hold the samples, with the touchdowns in a second file beside it:
            `walk.csv` and `walk_touchdowns.csv`. `.mcap` is a recording of ROS 2 messages (`mjbiped.exchange.mcap`).

    Raises:
        InputError: The suffix is another, the format's extra is not installed, or a recording would have no samples.
        RecordError: A file cannot be written.
    """
    for file, write in parts_of(walk, check_format(Path(path))).values():
        write(file)


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


def parts_of(walk: Walk, path: Path) -> dict[str, tuple[Path, Callable[[Path], None]]]:
    """Return what a record becomes, by kind: files, and the functions that write them."""
    if path.suffix == MCAP:
        return {"record": (path, partial(write_recording, walk))}
    beside = path.with_stem(f"{path.stem}_touchdowns")
    return {
        "record": (path, partial(write_samples, walk)),
        "touchdowns": (beside, partial(write_touchdowns, walk)),
    }
