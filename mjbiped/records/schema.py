"""Checks of a walk's record, made once when it is read, on which measures and drawings rely.

Records of earlier formats are converted to the current one. Reports, figures and repetitions of a walk use the settings
that are checked here as they are. Of other settings readers use only the text: `mjbiped.walk` checks what it is given
again.
"""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Callable, Mapping
from typing import Any, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.errors import MjbipedError, RecordError, shown
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
"""Table that came with each version of the format. Version 5 brought the outcome "time limit", and version 6 soles."""

FORMAT_VERSION = max(ADDED)

FARTHEST = 1e10
"""Greatest place (m) or angle (rad); MuJoCo treats a state beyond it as diverged."""

OUTCOMES = tuple(outcome.words for outcome in Outcome if outcome is not Outcome.WALKING)
"""All outcomes of a walk, in words."""

LONGEST_HEADER = 32_000_000
"""Greatest number of characters of a record's header; the longest terrain of 100 000 segments takes half of them."""

LONGEST_DESCRIPTION = 3_200_000
"""Greatest number of characters of a controller's description."""

DEEPEST = 40  # levels of nested settings; the engines' own have five
_LONGEST_REASON = 300  # characters
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
    end, settings = header.get("end"), header.get("settings")
    if not _is_numbers(end, 2):
        raise _damaged(f"its end is {shown(end)}; expected a time and a place")
    robot = _checked_settings(settings)
    columns = tables_of(type(robot))
    arrays = _converted(arrays, header["version"], columns)
    tables = {kind: _table(kind, own, arrays, legs=len(robot.bodies.limbs)) for kind, own in columns._asdict().items()}
    states = tables["samples"].get("controller_states")
    if states is None or states.dtype != np.float64 or states.ndim != 2:
        raise _damaged("samples/controller_states must be a column of numbers for each state of the controller")
    times = _checked("pressure_times", arrays, np.float64, (BINS,))
    if (times < 0.0).any() or np.isinf(times).any():
        raise _damaged("pressure_times holds what is no time")
    return {
        **tables,
        "outcome": header["outcome"],
        "end": (float(end[0]), float(end[1])),
        "peak_torque": _checked("peak_torque", arrays, np.float64, (len(robot.joints),)),
        "pressure_times": times,
        "settings": settings,
    }


def _damaged(what: str) -> RecordError:
    """Return the error of a damaged record; its message continues the file's name."""
    return RecordError(f"is a damaged record: {what}")


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
    if header.get("outcome") not in OUTCOMES:
        raise _damaged(f"its outcome is {shown(header.get('outcome'))}; valid are {', '.join(OUTCOMES)}")
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
        choices = legs if name == "stance" else 2
        if column.whole and not ((array >= 0) & (array < choices)).all():
            raise _damaged(f"{kind}/{name} holds other numbers than {' and '.join(map(str, range(choices)))}")
        if column.finite and not np.isfinite(array).all():
            raise _damaged(f"{kind}/{name} holds what is no finite number")
    table = {name.removeprefix(f"{kind}/"): array for name, array in arrays.items() if name.startswith(f"{kind}/")}
    for name, array in table.items():
        if array.shape[:1] != table["time"].shape or array.dtype.kind == "U":
            expected = f"{len(table['time'])} rows of numbers"
            raise _damaged(f"{kind}/{shown(name)} is {_described(array)}; expected {expected}")
    if not (np.abs(table["qpos"]) <= FARTHEST).all():
        raise _damaged(f"{kind}/qpos holds numbers beyond {FARTHEST:g}, where no walk gets to")
    if not (np.diff(table["time"], prepend=0.0) >= 0.0).all():
        raise _damaged("its times do not ascend from 0")
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
    if array.dtype != kind or array.shape[rows:] != shape or array.ndim != len(shape) + rows:
        words = "whole numbers" if kind is np.int64 else "floats"
        raise _damaged(f"{name} is {_described(array)}; expected {words} of shape {shape}{' a row' * rows}")
    return array


def _described(array: NDArray[Any]) -> str:
    """Describe an array's type and shape."""
    return f"of type {array.dtype} and shape {shown(array.shape)}"


def parsed(text: str, longest: int = LONGEST_HEADER) -> Any:
    """Read a JSON text into values that are safe to compute with and to write again.

    Args:
        text: JSON text as it stands in a file.
        longest: Greatest number of characters that it may have.

    Raises:
        ValueError: The text is not JSON, too long or nested too deeply, or holds a text that cannot be written.
    """
    if len(text) > longest:
        raise ValueError(f"it is too long: {len(text)} characters; expected at most {longest}")
    try:
        value = json.loads(text)
        json.dumps(value, ensure_ascii=False).encode()
        depth = _depth(value)
    except RecursionError:
        depth = DEEPEST + 1
    if depth > DEEPEST:
        raise ValueError(f"nested more than {DEEPEST} times")
    return value


def _depth(value: object) -> int:
    """Count the levels of nesting of a JSON value."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(_depth, parts), default=-1)


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


def _checked_settings(settings: object) -> Robot:
    """Check the settings of a header and return the robot that walked.

    Raises:
        RecordError: A setting that every record has is missing, or one is not what readers rely on.
    """
    if not isinstance(settings, dict):
        raise _damaged(f"its settings are {shown(settings)}; expected a table")
    if missing := _ALL - settings.keys():
        raise _damaged(f"its settings lack {', '.join(map(shown, sorted(missing)))}")
    robot = _built("robot", robot_from, settings["robot"])
    _built("terrain", Terrain.from_dict, settings["terrain"])
    _built("scuffing rule", lambda rule: rule is None or ScuffingRule(**rule), settings["scuffing"])
    disturbances = settings.get("disturbances", {})  # readers use the values as they stand there
    if _built("disturbances", Disturbances.from_dict, disturbances).to_dict() != disturbances:
        raise _damaged(f"its disturbances {shown(disturbances)} are not as they would have been written")
    count, source, warnings = 2 * len(robot.angles), settings.get("controller_source"), settings.get("warnings", {})
    texts = source.values() if isinstance(source, dict) and source.keys() == {"class", "sha256"} else [None]
    counts = warnings.values() if isinstance(warnings, dict) else [None]
    for name, holds, expected in (
        ("engine", isinstance(settings["engine"], str), "a name"),
        ("command", isinstance(settings.get("command", ""), str), "a text"),
        ("controller", _is_named(settings["controller"]), "a table with a name"),
        ("controller_source", source is None or all(isinstance(text, str) for text in texts),
         "a class and the digest of its source"),
        ("initial", _is_numbers(settings["initial"], count), f"{count} numbers"),
        ("warnings", all(type(number) is int and number > 0 for number in counts), "numbers of times"),
    ):  # fmt: skip
        if not holds:
            raise _damaged(f"its {name.replace('_', ' ')} is {shown(settings.get(name))}; expected {expected}")
    return robot


def _is_named(controller: object) -> bool:
    return isinstance(controller, dict) and isinstance(controller.get("name"), str)


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
        why = textwrap.shorten(str(error), _LONGEST_REASON, placeholder=" ...")
        raise _damaged(f"its {what} cannot be built: {why}") from error
