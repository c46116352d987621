"""Tables of a walk with one number per column, also as data frames of pandas."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.records.columns import Columns, tables_of
from mjbiped.utils.packages import needed

if TYPE_CHECKING:
    import pandas

    from mjbiped.records.record import Walk

Flat = dict[str, NDArray[Any]]
"""Arrays of shape (rows,) by the names of their columns."""

STATE = "controller_state"
"""Prefix of the names of the controller's integrated states, which are numbered from 0."""

_SAME = 1e-9  # s: a sample this near to a touchdown is of its instant


class Frames(NamedTuple):
    """A walk as data frames; `attrs["units"]` of each has the units of its columns.

    Attributes:
        samples: A row per sample.
        touchdowns: A row per support transfer.
    """

    samples: pandas.DataFrame
    touchdowns: pandas.DataFrame


def flat_samples(walk: Walk) -> Flat:
    """Return the samples, one number per column: `step`, `time`, `q_stance`, ..., `controller_state_0`, ...

    `step` counts from 1; a sample at the instant of a touchdown belongs to the step whose stance leg it has.
    """
    states = {f"{STATE}_{number}": state for number, state in enumerate(walk.samples["controller_states"].T)}
    return _flat(tables_of(type(walk.robot)).samples, walk.samples, _steps(walk)) | states


def flat_touchdowns(walk: Walk) -> Flat:
    """Return the touchdowns, one number per column; `step` is the step that the touchdown ends, from 1 on."""
    steps = np.arange(1, walk.steps + 1, dtype=np.int64)
    return _flat(tables_of(type(walk.robot)).touchdowns, walk.touchdowns, steps)


def units_of(columns: Columns) -> dict[str, str]:
    """Return the unit of each flat column; empty for a pure number."""
    units = {"step": ""}
    for name, column in columns.items():
        of_parts = column.unit.split(", ") if ", " in column.unit else [column.unit] * column.width
        units |= zip([f"{name}_{part}" for part in column.parts] or [name], of_parts, strict=True)
    return units


def attributes(units: Mapping[str, str]) -> dict[str, str]:
    """Return the metadata of a Parquet file from which pandas reads units by column, `frame.attrs["units"]`."""
    return {"PANDAS_ATTRS": json.dumps({"units": dict(units)})}


def frames(walk: Walk) -> Frames:
    """Return the walk as data frames; see `Walk.to_pandas`.

    Raises:
        InputError: pandas is not installed.
    """
    pandas = needed("pandas", "data", "to_pandas")
    made, columns_of = [], tables_of(type(walk.robot))
    for table, columns in zip((flat_samples(walk), flat_touchdowns(walk)), columns_of, strict=True):
        frame = pandas.DataFrame(table)
        frame.attrs["units"] = units_of(columns)
        made.append(frame)
    return Frames(*made)


def _steps(walk: Walk) -> NDArray[np.int64]:
    """Return the number of the step of each sample."""
    time, touched = walk.samples["time"], walk.touchdowns
    ended = np.searchsorted(touched["time"], time - _SAME)
    following = np.append(touched["time"], np.inf)[ended]
    begun = (np.abs(following - time) <= _SAME) & (np.append(touched["stance"], -1)[ended] == walk.samples["stance"])
    return np.asarray(1 + ended + begun, dtype=np.int64)


def _flat(columns: Columns, table: Mapping[str, NDArray[Any]], steps: NDArray[np.int64]) -> Flat:
    numbers = (row for name in columns for row in np.atleast_2d(table[name].T))
    return dict(zip(units_of(columns), (steps, *numbers), strict=True))
