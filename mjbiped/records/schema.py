"""Checks of a walk's record, made once when it is read, on which measures and drawings rely."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import RecordError, shown
from mjbiped.records.columns import WHOLE_NUMBERS, Column, tables_of
from mjbiped.records.pressure import BINS, unknown
from mjbiped.records.settings import checked_settings, damaged, is_numbers, parsed
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import STALL_TIME, Outcome

FORMAT = "mjbiped walk"
FORMAT_VERSION = 7
"""Version 2 added `normal_force` to touchdowns; 3, the stance knee's motor; 4, the centre of pressure in touchdowns and
its histogram; 5, the outcome "time limit"; 6, soles; 7, contact forces. What an older record lacks is NaN."""

FARTHEST = 1e10
"""Greatest place (m) or angle (rad); MuJoCo treats a state beyond it as diverged."""

OUTCOMES = tuple(outcome.words for outcome in Outcome if outcome is not Outcome.WALKING)
"""All outcomes of a walk, in words."""

_BETWEEN, _LATER = 2.0, 1.0  # a step takes at most this multiple of the stall time, plus this time, s

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
    samples = _table("samples", columns.samples, arrays, header["version"], legs)
    touchdowns = _table("touchdowns", columns.touchdowns, arrays, header["version"], legs)
    states = samples.get("controller_states")
    if states is None or states.dtype != np.float64 or states.ndim != 2:
        raise damaged("samples/controller_states must be a column of numbers for each state of the controller")
    peak = arrays.get("peak_torque")
    if peak is None or peak.dtype != np.float64 or peak.shape != (len(robot.joints),):
        raise RecordError(f"is an incomplete record: it lacks peak_torque, numbers for {', '.join(robot.joints)}")
    times = arrays.get("pressure_times", unknown()) if header["version"] >= 4 else unknown()
    if times.dtype != np.float64 or times.shape != (BINS,) or (times < 0.0).any() or np.isinf(times).any():
        raise damaged(f"pressure_times is {_described(times)}; expected {BINS} times")
    _check_times(robot, [samples["time"], touchdowns["time"], np.array(end[:1])], len(touchdowns["time"]))
    return {
        "samples": samples,
        "touchdowns": touchdowns,
        "outcome": header["outcome"],
        "end": (float(end[0]), float(end[1])),
        "peak_torque": peak,
        "pressure_times": times,
        "settings": settings,
    }


def _header(arrays: Arrays) -> dict[str, Any]:
    """Read the record's header, and check its format, version and outcome.

    Raises:
        RecordError: There is no header, or it is of another format or a newer version.
    """
    written = arrays.get("header")
    try:
        if written is None or written.dtype.kind != "U":
            raise ValueError("there is no text named header")
        header = parsed(str(written))
        named, version = header["format"], header["version"]
    except (KeyError, TypeError, ValueError) as error:
        raise RecordError(f"is no walk's record: it has no header of one ({shown(error)})") from error
    if named != FORMAT:
        raise RecordError(f"is no walk's record but a {shown(named)}")
    if type(version) is not int or version < 1:
        raise RecordError(f"is no walk's record: its version is {shown(version)}")
    if version > FORMAT_VERSION:
        raise RecordError(
            f"is a record of version {version}; this mjbiped reads up to {FORMAT_VERSION}: install a newer one"
        )
    if header.get("outcome") not in OUTCOMES:
        raise damaged(f"its outcome is {shown(header.get('outcome'))}; valid are {', '.join(OUTCOMES)}")
    return dict(header)


def _table(
    kind: str, columns: Mapping[str, Column], arrays: Arrays, version: int, legs: int
) -> dict[str, NDArray[Any]]:
    """Return one of the two tables with the columns of `mjbiped.records.columns`, and any others.

    Raises:
        RecordError: A column is missing, or is not as specified.
    """
    beginning = f"{kind}/"
    table = {name.removeprefix(beginning): array for name, array in arrays.items() if name.startswith(beginning)}
    missing = [name for name, column in columns.items() if name not in table and column.since <= version]
    if missing:
        raise RecordError(f"is an incomplete record: it lacks {', '.join(beginning + name for name in missing)}")
    rows = len(np.atleast_1d(table["time"]))
    for name, array in table.items():
        if array.shape[:1] != (rows,) or array.dtype.kind == "U":
            raise damaged(f"{beginning}{shown(name)} is {_described(array)}; expected {rows} rows of numbers")
    for name, column in columns.items():
        if name in table:
            choices = legs if name == "stance" else 2
            _check_column(f"{beginning}{name}", name in WHOLE_NUMBERS, choices, column, table[name])
        else:
            table[name] = np.full((rows, *column.row), np.nan)
    return table


def _check_column(where: str, whole: bool, choices: int, column: Column, array: NDArray[Any]) -> None:
    """Check a column against its specification.

    Raises:
        RecordError: Its shape, type or a number in it is not as specified.
    """
    expected = np.int64 if whole else np.float64
    if array.shape[1:] != column.row or array.dtype != expected:
        kind = "whole numbers" if whole else "floats"
        raise damaged(f"{where} is {_described(array)}; expected {kind}, {column.width} a row")
    if whole and not ((array >= 0) & (array < choices)).all():
        raise damaged(f"{where} holds other numbers than {' and '.join(map(str, range(choices)))}")
    if column.finite and not np.isfinite(array).all():
        raise damaged(f"{where} holds what is no finite number")
    if where.endswith("/qpos") and not (np.abs(array) <= FARTHEST).all():
        raise damaged(f"{where} holds numbers beyond {FARTHEST:g}, where no walk gets to")


def _described(array: NDArray[Any]) -> str:
    return f"of type {array.dtype} and shape {shown(array.shape)}"


def _check_times(robot: Robot, columns: Sequence[NDArray[np.float64]], steps: int) -> None:
    """Check that times ascend, and that a walk of `steps` steps would not have stalled before them.

    Raises:
        RecordError: Times descend, or are too late.
    """
    latest = (steps + 1) * _BETWEEN * STALL_TIME * math.sqrt(robot.leg_length / robot.gravity) + _LATER
    for time in columns:
        if not (len(time) == 0 or time[0] >= 0.0) or (time[1:] < time[:-1]).any():
            raise damaged("its times do not ascend from 0")
        if len(time) and time[-1] > latest:
            raise damaged(f"it goes on to {time[-1]:g} s, with {steps} steps, where a walk stalls before {latest:g} s")
