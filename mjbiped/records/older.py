"""Records of earlier formats, which are converted to the current one when they are read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.records.columns import Tables
from mjbiped.records.loads import BINS

ADDED: Mapping[int, tuple[str, ...]] = {
    1: (),
    2: ("touchdowns/normal_force",),
    3: ("samples/stance_knee_torque", "touchdowns/stance_knee_torque", "touchdowns/stance_knee_work"),
    4: ("touchdowns/pressure_ahead", "touchdowns/pressure_behind", "pressure_times"),
    5: (),
    6: ("samples/ankle_asked", "touchdowns/sole_bound_time"),
    7: ("touchdowns/contact_force", "touchdowns/intrusion"),
}
"""Arrays that came with each version of the format. Version 5 brought the outcome "time limit", and version 6 soles."""

FORMAT_VERSION = max(ADDED)


def converted(arrays: Mapping[str, NDArray[Any]], version: int, tables: Tables) -> dict[str, NDArray[Any]]:
    """Convert the arrays of a record: numbers that did not exist in its version are NaN.

    Each of these arrays has one number a row.

    Args:
        arrays: Arrays of a record's file by name.
        version: Version of its format.
        tables: Columns of its robot.
    """
    rows = {"pressure_times": BINS}
    for kind, columns in tables._asdict().items():
        rows |= dict.fromkeys((f"{kind}/{name}" for name in columns), np.size(arrays.get(f"{kind}/time", ())))
    added = (name for since, names in ADDED.items() if since > version for name in names if name in rows)
    return {**{name: np.full(rows[name], np.nan) for name in added}, **arrays}
