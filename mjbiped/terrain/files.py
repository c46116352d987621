"""Read terrains as users give them: elevation and segment files, and text on the command line.

Input becomes plain Python values, or an `InputError` says what was wrong, what was expected and what to do.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from mjbiped.errors import InputError, shortened, shown
from mjbiped.terrain.profile import check_slope
from mjbiped.terrain.surface import MOST_HEIGHTS, Surface
from mjbiped.utils import domains
from mjbiped.utils.domains import as_float, known_name, parse_number
from mjbiped.utils.files import read_text

Floats: TypeAlias = tuple[float, ...]

SEGMENT_KEYS = ("length", "slope_deg", "step", "lateral_deg")
FILE_SUFFIXES = (".csv", ".asc", ".toml", ".yaml", ".yml")
FILE_KEY = "file"

_GRID_KEYS = ("ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "nodata_value")
_NO_DATA = -9999.0  # of a grid that does not say
_COUNT = domains.Count(2, MOST_HEIGHTS // 2)


class Sample(NamedTuple):
    """One row of an elevation file: x and z in m, and its line in the file (1-based)."""

    x: float
    z: float
    line: int


def read_profile(path: Path) -> tuple[Floats, Floats, Floats, float]:
    """Read an elevation profile from a comma-separated file with the columns x, z in m.

    A header, blank lines and comments from `#` to the end of a line are allowed. x increases strictly; only the two
    ends of a vertical step have the same x.

    Returns:
        Starts (m), heights (m) and slope angles (rad) of the segments that join the samples, and the last x (m).

    Raises:
        InputError: The file cannot be read, or a row is invalid; the message names the line.
    """
    rows = []
    for line, full in enumerate(read_text(path).splitlines(), start=1):
        if row := full.split("#", 1)[0].strip():
            cells = [cell.strip().strip("\"'").strip() for cell in row.split(",")]
            if len(cells) != 2:
                raise InputError(f"line {line}: {len(cells)} column(s) in {shown(row)}; expected x,z in m")
            rows.append((line, cells))
    if rows and [*map(parse_number, rows[0][1])] == [None, None]:
        line, (first, second) = rows.pop(0)
        if first.lower().startswith("z") or second.lower().startswith("x"):
            raise InputError(f"line {line}: the header reads {first}, {second}; expected x first: swap the columns")
    samples = []
    for line, cells in rows:
        x, z = (
            domains.PLACE.check(f"line {line}: {name}", cell if (value := parse_number(cell)) is None else value)
            for name, cell in zip("xz", cells, strict=True)
        )
        samples.append(Sample(x, z, line))
    if len(samples) < 2:
        raise InputError(f"{len(samples)} elevation sample(s); expected at least two rows x,z in m")
    _check_order(samples)
    segments = []
    for here, there in pairwise(samples):
        where = f"lines {here.line} to {there.line}"
        if there.x == here.x:
            domains.STEP.check(f"{where}: the step", there.z - here.z)
            continue
        angle = math.atan2(here.z - there.z, there.x - here.x)
        check_slope(where, angle)
        segments.append((here.x, here.z, angle))
    starts, heights, angles = zip(*segments, strict=True)
    return starts, heights, angles, samples[-1].x


def read_grid(path: Path) -> Surface:
    """Read a surveyed grid, an ESRI ASCII grid: x to the east is forward, y to the north is to the left.

    A header of `ncols`, `nrows`, `xllcorner` and `yllcorner` (or `xllcenter` and `yllcenter`), `cellsize` and
    optionally `NODATA_value`, and a line for each row of heights in m, the northernmost first.

    Raises:
        InputError: The file cannot be read, has a hole, or holds anything else; the message names the line.
    """
    lines = [(number, line.split()) for number, line in enumerate(read_text(path).splitlines(), 1) if line.strip()]
    header: dict[str, float] = {}
    while lines and lines[0][1][0][0].isalpha() and parse_number(lines[0][1][0]) is None:
        line, cells = lines.pop(0)
        key, value = known_name(f"line {line}: header", cells[0].lower(), _GRID_KEYS), parse_number(cells[-1])
        if len(cells) != 2 or value is None:
            raise InputError(f"line {line}: {shown(' '.join(cells))}: expected {key} and a number")
        header[key] = value
    size = domains.STRETCH.check("cellsize", header.get("cellsize", "missing"))
    rows, columns = (_COUNT.check(key, header.get(key, "missing")) for key in ("nrows", "ncols"))
    corner = []
    for axis in "xy":
        if not {f"{axis}llcorner", f"{axis}llcenter"} & {*header}:
            raise InputError(f"the header has neither {axis}llcorner nor {axis}llcenter; give one of them")
        edge = as_float(header.get(f"{axis}llcorner")) + size / 2.0
        corner.append(as_float(header.get(f"{axis}llcenter", edge)))
    if len(lines) != rows:
        raise InputError(f"{len(lines)} rows of heights; the header says {rows}")
    for axis, first, count in zip("xy", corner, (columns, rows), strict=True):
        if not first <= 0.0 < first + (count - 1) * size:
            raise InputError(
                f"the ground reaches from {axis} = {first:.10g} to {first + (count - 1) * size:.10g} m, but the robot "
                f"starts at x = 0, y = 0 and walks along x: subtract the start's {axis} from {axis}llcorner"
            )
    hole = header.get("nodata_value", _NO_DATA)
    heights = [_row_of_grid(line, cells, columns, hole) for line, cells in reversed(lines)]
    return Surface(corner[0], corner[1], size, np.array(heights))


def _row_of_grid(line: int, cells: Sequence[str], columns: int, hole: float) -> list[float]:
    """Heights of a line of a grid, m."""
    if len(cells) != columns:
        raise InputError(f"line {line}: {len(cells)} heights; the header says ncols {columns}")
    heights = []
    for number, cell in enumerate(cells, start=1):
        height = parse_number(cell)
        if height == hole or height != height:
            raise InputError(
                f"line {line}, height {number} of {columns}, is {cell}, which stands for no data (NODATA_value): the "
                "ground has a hole; fill it (with gdal_fillnodata, for example), or cut out a part without holes"
            )
        where = f"line {line}, height {number} of {columns}"
        heights.append(domains.PLACE.check(where, cell if height is None else height))
    return heights


def read_segments(path: Path) -> list[tuple[object, ...]]:
    """Read `segments` from a TOML or YAML file: a list of lists or of tables with `SEGMENT_KEYS`.

    Returns:
        One tuple per segment, of two to four of the keys' values; they are not checked here.

    Raises:
        InputError: The file cannot be read or parsed, or holds anything else; the message names the line or segment.
    """
    text = read_text(path)
    yaml_file = path.suffix.lower() != ".toml"
    content: object = _parse_yaml(text) if yaml_file else parse_toml(text)
    form = f"segments{':' if yaml_file else ' ='} [[length_m, slope_deg, step_m], ...]"
    if not isinstance(content, dict):
        raise InputError(f"holds no table; expected {form}")
    for key in content:
        known_name("key", key, ("segments",))
    segments = content.get("segments")
    if not isinstance(segments, list):
        raise InputError(f"'segments' is {'missing' if segments is None else shown(segments)}; expected {form}")
    return [_read_segment(k, segment, yaml_file) for k, segment in enumerate(segments, start=1)]


def parse_parameters(text: str) -> dict[str, object]:
    """Parse "key=value,key=value" from the command line.

    A value is a whole number, a number, or a range "low..high"; only the value of `FILE_KEY` is a path.

    Returns:
        The values by name: int, float or (low, high), and a text for `FILE_KEY`.

    Raises:
        InputError: An item has no "=", a name is given twice, or a value is not a number.
    """
    parameters: dict[str, object] = {}
    for item in text.split(","):
        key, equals, value = (part.strip() for part in item.partition("="))
        if not key or not equals or not value:
            raise InputError(f"cannot read {shown(item.strip())} in {shown(text)}; expected key=value,key=value")
        if key in parameters:
            raise InputError(f"{shown(key)} is given twice in {shown(text)}; give it once")
        if key == FILE_KEY:
            parameters[key] = value
            continue
        ends = [parse_number(end.strip()) for end in value.split("..", 1)]
        if None in ends:
            raise InputError(f"{shown(key)}: {shown(value)} is no number; expected a number or a range low..high")
        parameters[key] = ends[0] if len(ends) == 1 else tuple(ends)
    return parameters


def parse_toml(text: str) -> dict[str, Any]:
    """Parse TOML.

    Raises:
        InputError: The text is not TOML; the message names the line.
    """
    return _parsed("TOML", tomllib.loads, text)  # type: ignore[no-any-return]


def _parse_yaml(text: str) -> object:
    """Parse YAML; numbers remain texts, whatever tags and quotes they have.

    Raises:
        InputError: The text is not YAML; the message names the line.
    """
    import yaml  # only few users need it

    return _parsed("YAML", lambda text: yaml.load(text, Loader=yaml.BaseLoader), text)


def _parsed(language: str, parse: Callable[[str], Any], text: str) -> Any:
    try:
        return parse(text)
    except Exception as error:  # a code of a letter that there is not is a ValueError or an OverflowError
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError(f"not readable as {language}: {shortened(' '.join(reason.split()))}") from error


def _check_order(samples: Sequence[Sample]) -> None:
    """Check that x ascends, and that two samples at one place are the ends of a step between two pieces of ground."""
    for number, (here, there) in enumerate(pairwise(samples)):
        if there.x < here.x:
            raise InputError(f"line {there.line}: x = {there.x:g} m comes after {here.x:g} m; sort the rows by x")
        if there.x > here.x:
            continue
        if there.z == here.z:
            raise InputError(f"line {there.line}: repeats the sample of line {here.line}; delete one of them")
        if number in (0, len(samples) - 2):
            raise InputError(f"line {there.line}: a vertical step at an end leads to no ground; drop line {here.line}")
        if samples[number + 2].x == here.x:
            raise InputError(
                f"line {samples[number + 2].line}: x = {here.x:g} m stands in three rows; a vertical step has two"
            )


def _read_segment(k: int, segment: object, yaml_file: bool) -> tuple[object, ...]:
    """Convert the k-th segment of a file (1-based), a list or a table, to a tuple."""
    if isinstance(segment, dict):
        if not {*SEGMENT_KEYS[:2]} <= {*segment} <= {*SEGMENT_KEYS}:
            found = shown(", ".join(map(str, segment)))
            raise InputError(f"segment {k} has {found}; expected {', '.join(SEGMENT_KEYS)} (the last two are optional)")
        segment = [segment.get(key, 0) for key in SEGMENT_KEYS]
    if not isinstance(segment, list):
        raise InputError(
            f"segment {k} is {shown(segment)}; expected [length_m, slope_deg, step_m, lateral_deg] or a table"
        )
    if yaml_file:
        segment = [cell if (number := parse_number(cell)) is None else number for cell in segment]
    return tuple(segment)
