"""Checks of a walk's record, made once when it is read, on which measures and drawings rely."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import RecordError, shown
from mjbiped.records.columns import Columns, tables_of
from mjbiped.records.loads import BINS
from mjbiped.records.older import FORMAT_VERSION, converted
from mjbiped.records.settings import checked_settings, damaged, is_numbers, parsed
from mjbiped.rules.termination import Outcome

FORMAT = "mjbiped walk"

FARTHEST = 1e10
"""Greatest place (m) or angle (rad); MuJoCo treats a state beyond it as diverged."""

OUTCOMES = tuple(outcome.words for outcome in Outcome if outcome is not Outcome.WALKING)
"""All outcomes of a walk, in words."""

Arrays = Mapping[str, NDArray[Any]]


def checked_fields(arrays: Arrays) -> dict[str, Any]:
    """Check the arrays of a record's file and return the fields of its `Walk`.

    Args:
        arrays: Floats, whole numbers and texts, named as `Walk.save` names them.

    Raises:
        RecordError: They are not a record, or a damaged one, or one of a newer version; the message continues the
            file's name.
    """
    header = _header(arrays)
    end, settings = header.get("end"), header.get("settings")
    if not is_numbers(end, 2):
        raise damaged(f"its end is {shown(end)}; expected a time and a place")
    robot = checked_settings(settings)
    columns, legs = tables_of(type(robot)), len(robot.bodies.limbs)
    arrays = converted(arrays, header["version"], columns)
    tables = {kind: _table(kind, own, arrays, legs) for kind, own in columns._asdict().items()}
    states = tables["samples"].get("controller_states")
    if states is None or states.dtype != np.float64 or states.ndim != 2:
        raise damaged("samples/controller_states must be a column of numbers for each state of the controller")
    times = _checked("pressure_times", np.dtype((np.float64, (BINS,))), arrays, rows=False)
    if (times < 0.0).any() or np.isinf(times).any():
        raise damaged("pressure_times holds what is no time")
    return {
        **tables,
        "outcome": header["outcome"],
        "end": (float(end[0]), float(end[1])),
        "peak_torque": _checked("peak_torque", np.dtype((np.float64, (len(robot.joints),))), arrays, rows=False),
        "pressure_times": times,
        "settings": settings,
    }


def _header(arrays: Arrays) -> dict[str, Any]:
    """Read the record's header, and check its format, version and outcome.

    Raises:
        RecordError: There is no header, or it is of another format or a newer version.
    """
    try:
        header = parsed(str(arrays["header"]))
        named, version = header["format"], header["version"]
    except (KeyError, TypeError, ValueError) as error:
        raise RecordError(f"is no walk's record: it has no header of one ({shown(error)})") from error
    if named != FORMAT or type(version) is not int or version < 1:
        raise RecordError(f"is no walk's record but a {shown(named)} of version {shown(version)}")
    if version > FORMAT_VERSION:
        raise RecordError(
            f"is a record of version {version}; this mjbiped reads up to {FORMAT_VERSION}: install a newer one"
        )
    if header.get("outcome") not in OUTCOMES:
        raise damaged(f"its outcome is {shown(header.get('outcome'))}; valid are {', '.join(OUTCOMES)}")
    return dict(header)


def _table(kind: str, columns: Columns, arrays: Arrays, legs: int) -> dict[str, NDArray[Any]]:
    """Return one of the two tables with the columns of `mjbiped.records.columns`, and any others.

    Raises:
        RecordError: A column is missing, or is not as specified.
    """
    for name, column in columns.items():
        row = np.dtype((np.int64 if column.whole else np.float64, (len(column.parts),) if column.parts else ()))
        array = _checked(f"{kind}/{name}", row, arrays)
        choices = legs if name == "stance" else 2
        if column.whole and not ((array >= 0) & (array < choices)).all():
            raise damaged(f"{kind}/{name} holds other numbers than {' and '.join(map(str, range(choices)))}")
        if column.finite and not np.isfinite(array).all():
            raise damaged(f"{kind}/{name} holds what is no finite number")
    table = {name.removeprefix(f"{kind}/"): array for name, array in arrays.items() if name.startswith(f"{kind}/")}
    for name, array in table.items():
        if array.shape[:1] != table["time"].shape or array.dtype.kind == "U":
            raise damaged(f"{kind}/{shown(name)} is {_described(array)}; expected {len(table['time'])} rows of numbers")
    if not (np.abs(table["qpos"]) <= FARTHEST).all():
        raise damaged(f"{kind}/qpos holds numbers beyond {FARTHEST:g}, where no walk gets to")
    if not (np.diff(table["time"], prepend=0.0) >= 0.0).all():
        raise damaged("its times do not ascend from 0")
    return table


def _checked(name: str, kind: np.dtype[Any], arrays: Arrays, *, rows: bool = True) -> NDArray[Any]:
    """Return an array after a check of its type.

    Args:
        name: Name of the array.
        kind: Type of the array, or of each of its rows.
        arrays: Arrays of the record by name.
        rows: Whether the array has rows.

    Raises:
        RecordError: The array is missing, or its type or shape is another.
    """
    if name not in arrays:
        raise RecordError(f"is an incomplete record: it lacks {name}")
    array = arrays[name]
    if array.dtype != kind.base or array.shape[rows:] != kind.shape or array.ndim != len(kind.shape) + rows:
        words = "whole numbers" if kind.base.kind == "i" else "floats"
        raise damaged(f"{name} is {_described(array)}; expected {words} of shape {kind.shape}{' a row' * rows}")
    return array


def _described(array: NDArray[Any]) -> str:
    return f"of type {array.dtype} and shape {shown(array.shape)}"
