"""Formats of records for other programs, by their suffixes, and what they need."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mjbiped.errors import InputError, shown
from mjbiped.utils.packages import needed

CSV, PARQUET, MCAP = ".csv", ".parquet", ".mcap"

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
