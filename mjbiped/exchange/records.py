"""Records of walks in the formats of other programs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from mjbiped.exchange.formats import MCAP, check_format
from mjbiped.exchange.mcap import write_recording
from mjbiped.exchange.tables import write_samples, write_touchdowns
from mjbiped.records.record import Walk


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


def parts_of(walk: Walk, path: Path) -> dict[str, tuple[Path, Callable[[Path], None]]]:
    """Return what a record becomes, by kind: files, and the functions that write them."""
    if path.suffix == MCAP:
        return {"record": (path, partial(write_recording, walk))}
    beside = path.with_stem(f"{path.stem}_touchdowns")
    return {
        "record": (path, partial(write_samples, walk)),
        "touchdowns": (beside, partial(write_touchdowns, walk)),
    }
