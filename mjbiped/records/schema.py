"""Checks of a walk's record, made once when it is read, on which measures and drawings rely.

Records of earlier formats are converted to the current one. Reports, figures and repetitions of a walk use the settings
that are checked here without further checks. Other settings are only shown as text; `mjbiped.walk` checks its arguments
again.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from typing import Any, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.errors import MjbipedError, RecordError, shortened, shown
from mjbiped.records.arrays import LONGEST_DESCRIPTION, parsed
from mjbiped.records.columns import Columns, Table, Tables, tables_of
from mjbiped.records.loads import BINS
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain

Part = TypeVar("Part")

FORMAT = "mjbiped walk"

ADDED: Mapping[int, tuple[str, ...]] = {
    1: (),
    2: ("touchdowns/normal_force",),
    3: ("samples/stance_knee_torque", "touchdowns/stance_knee_torque", "touchdowns/stance_knee_work"),
    4: ("touchdowns/pressure_ahead", "touchdowns/pressure_behind", "pressure_times"),
    5: (),
    6: ("samples/ankle_asked", "touchdowns/sole_bound_time"),
    7: ("touchdowns/contact_force", "touchdowns/intrusion"),
}
"""Tables that came with each version of the format. Version 5 brought the outcome "time limit", and version 6 soles."""

FORMAT_VERSION = max(ADDED)

FARTHEST = 1e10
"""Greatest place (m) or angle (rad); MuJoCo treats a state beyond it as diverged."""

OUTCOMES = tuple(outcome.words for outcome in Outcome if outcome is not Outcome.WALKING)
"""All outcomes of a walk, in words."""

_FELT = ("slip", "friction", "normal_force")  # columns of touchdowns that settings hold of a step without one
_ALL = {"engine", "robot", "controller", "terrain", "initial", "steps", "distance", "sample_period", "scuffing"}


def checked_fields(arrays: Table) -> dict[str, Any]:
    """Check the arrays of a record's file and return the fields of its `Walk`.

    Args:
        arrays: Floats, whole numbers and texts, named as `Walk.save` names them.

    Raises:
        RecordError: They are not a record, or a damaged one, or one of a newer version; the message continues the
            file's name.
    """
    header = _header(arrays)
    end: Any = header.get("end")
    settings = header.get("settings")
    _check(_is_numbers(end, 2), f"its end is {shown(end)}", "a time and a place")
    robot = _checked_settings(settings)
    columns = tables_of(type(robot))
    arrays = _converted(arrays, header["version"], columns)
    tables = {kind: _table(kind, own, arrays, legs=len(robot.bodies.limbs)) for kind, own in columns._asdict().items()}
    states = tables["samples"].get("controller_states", np.empty(0))
    found, expected = "samples/controller_states", "a column of numbers for each state of the controller"
    _check(states.dtype == np.float64 and states.ndim == 2, found, expected)
    times = _checked("pressure_times", arrays, np.float64, (BINS,))
    _check(not ((times < 0.0) | np.isinf(times)).any(), "pressure_times holds what is no time", "times")
    return {
        **tables,
        "outcome": header["outcome"],
        "end": (float(end[0]), float(end[1])),
        "peak_torque": _checked("peak_torque", arrays, np.float64, (len(robot.joints),)),
        "pressure_times": times,
        "settings": settings,
    }


def _check(holds: object, found: str, expected: str) -> None:
    """Refuse a damaged record; the message continues the file's name.

    Raises:
        RecordError: Something does not hold.
    """
    if not holds:
        raise RecordError(f"is a damaged record: {found}; expected {expected}")


def _header(arrays: Table) -> dict[str, Any]:
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
    outcome = header.get("outcome")
    _check(outcome in OUTCOMES, f"its outcome is {shown(outcome)}", f"one of {', '.join(OUTCOMES)}")
    return dict(header)


def _converted(arrays: Table, version: int, tables: Tables) -> Table:
    """Convert the arrays of a record of an earlier version: numbers that did not exist in it are NaN, one a row."""
    rows = {"pressure_times": BINS}
    for kind, columns in tables._asdict().items():
        rows |= dict.fromkeys((f"{kind}/{name}" for name in columns), np.size(arrays.get(f"{kind}/time", ())))
    added = (name for since, names in ADDED.items() if since > version for name in names if name in rows)
    return {**{name: np.full(rows[name], np.nan) for name in added}, **arrays}


def _table(kind: str, columns: Columns, arrays: Table, legs: int) -> Table:
    """Return one of the two tables with the columns of `mjbiped.records.columns`, and any others.

    Raises:
        RecordError: A column is missing, or is not as specified.
    """
    for name, column in columns.items():
        shape = (column.width,) if column.parts else ()
        array = _checked(f"{kind}/{name}", arrays, np.int64 if column.whole else np.float64, shape, rows=True)
        below, numbers = legs if name == "stance" else 2, f"{kind}/{name} holds other numbers"
        _check(not column.whole or ((array >= 0) & (array < below)).all(), numbers, f"whole ones from 0 to {below - 1}")
        _check(not column.finite or np.isfinite(array).all(), numbers, "finite ones")
    table = {name.removeprefix(f"{kind}/"): array for name, array in arrays.items() if name.startswith(f"{kind}/")}
    for name, array in table.items():
        rows = array.shape[:1] == table["time"].shape and array.dtype.kind != "U"
        _check(rows, f"{kind}/{shown(name)} is {_described(array)}", f"{len(table['time'])} rows of numbers")
    _check((np.abs(table["qpos"]) <= FARTHEST).all(), f"{kind}/qpos holds other numbers", f"none beyond {FARTHEST:g}")
    _check((np.diff(table["time"], prepend=0.0) >= 0.0).all(), f"{kind}/time goes back", "times that ascend from 0")
    return table


def _checked(
    name: str, arrays: Table, kind: type[np.float64 | np.int64], shape: tuple[int, ...], *, rows: bool = False
) -> NDArray[Any]:
    """Return an array of the record after a check of its type and its shape, or with `rows` that of each of its rows.

    Raises:
        RecordError: The array is missing, or its type or shape is another.
    """
    if name not in arrays:
        raise RecordError(f"is an incomplete record: it lacks {name}")
    array = arrays[name]
    words = f"{'whole numbers' if kind is np.int64 else 'floats'} of shape {shape}{' a row' * rows}"
    right = array.dtype == kind and array.shape[rows:] == shape and array.ndim == len(shape) + rows
    _check(right, f"{name} is {_described(array)}", words)
    return array


def _described(array: NDArray[Any]) -> str:
    """Describe an array's type and shape."""
    return f"of type {array.dtype} and shape {shown(array.shape)}"


def described(controller: object) -> dict[str, Any]:
    """Return a controller's description as it reads after saving and loading a record.

    Args:
        controller: Name and parameters of the controller.

    Raises:
        ValueError: A record with this description could not be read.
    """
    if not _is_named(controller):
        raise ValueError(f"it gives {shown(controller)}; expected a table with a name")
    whole = {"settings": {"controller": controller}}  # as deep as it stands there
    try:
        read: dict[str, Any] = parsed(json.dumps(whole), LONGEST_DESCRIPTION)["settings"]["controller"]
    except (TypeError, RecursionError) as error:
        raise ValueError(f"these are no plain JSON types: {error}") from error
    return read


def _checked_settings(settings: Any) -> Robot:
    """Check the settings of a header and return the robot that walked.

    Raises:
        RecordError: A setting that every record has is missing, or one is not what readers rely on.
    """
    _check(isinstance(settings, dict), f"its settings are {shown(settings)}", "a table")
    missing = ", ".join(map(shown, sorted(_ALL - settings.keys())))
    _check(not missing, f"its settings lack {missing}", "all of a walk")
    robot = _built("robot", robot_from, settings["robot"])
    _built("terrain", Terrain.from_dict, settings["terrain"])
    _built("scuffing rule", lambda rule: rule is None or ScuffingRule(**rule), settings["scuffing"])
    disturbances = settings.get("disturbances", {})  # readers use the values as they stand there
    known = _built("disturbances", Disturbances.from_dict, disturbances).to_dict()
    count, source, warnings = 2 * len(robot.angles), settings.get("controller_source"), settings.get("warnings", {})
    felt = settings.get("unfinished_step", {})
    texts = source.values() if isinstance(source, dict) and source.keys() == {"class", "sha256"} else [None]
    counts = warnings.values() if isinstance(warnings, dict) else [None]
    for name, holds, expected in (
        ("disturbances", known == disturbances, "them as they would have been written"),
        ("engine", isinstance(settings["engine"], str), "a name"),
        ("command", isinstance(settings.get("command", ""), str), "a text"),
        ("controller", _is_named(settings["controller"]), "a table with a name"),
        ("controller_source", source is None or all(isinstance(text, str) for text in texts),
         "a class and the digest of its source"),
        ("initial", _is_numbers(settings["initial"], count), f"{count} numbers"),
        ("unfinished_step", felt == {} or _is_felt(felt), f"numbers for {', '.join(_FELT)}"),
        ("warnings", all(type(number) is int and number > 0 for number in counts), "numbers of times"),
    ):  # fmt: skip
        _check(holds, f"its {name.replace('_', ' ')} is {shown(settings.get(name))}", expected)
    return robot


def _is_named(controller: object) -> bool:
    return isinstance(controller, dict) and isinstance(controller.get("name"), str)


def _is_felt(values: object) -> bool:
    """Whether a value is what an engine's `step_under_way` gives."""
    return isinstance(values, dict) and values.keys() == {*_FELT} and _is_numbers([*values.values()], len(_FELT))


def _is_numbers(values: object, count: int) -> TypeGuard[list[float]]:
    """Whether a value is a list of `count` finite numbers."""
    return (
        isinstance(values, list)
        and len(values) == count
        and all(type(value) in (int, float) and abs(value) <= sys.float_info.max for value in values)
    )


def _built(what: str, build: Callable[[Any], Part], described: object) -> Part:
    """Build a part of a walk from its description.

    Raises:
        RecordError: It cannot be built.
    """
    try:
        return build(described)
    except (MjbipedError, TypeError, ValueError, ArithmeticError) as error:
        raise RecordError(f"is a damaged record: its {what} cannot be built: {shortened(str(error))}") from error
