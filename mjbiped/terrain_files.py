"""What users hand to a `Terrain`: numbers, elevation and segment files, text on the command line.

Everything here turns such input into plain Python values or refuses it with an `InputError` that says what was
wrong, what was expected and what to do. Nothing here knows what a terrain is.
"""

from __future__ import annotations

import difflib
import math
import numbers
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from mjbiped.errors import InputError

SEGMENT_KEYS = ("length", "slope_deg", "step")
FILE_SUFFIXES = (".csv", ".toml", ".yaml", ".yml")


class Sample(NamedTuple):
    """One row of an elevation file: x and z in m, and the line of the file that it stands on (1-based)."""

    x: float
    z: float
    line: int


def number(
    what: str, value: object, *, above: float = -math.inf, least: float = -math.inf, most: float = math.inf
) -> float:
    """Check one real number.

    Args:
        what: The value's name and unit, for the message.
        value: Anything; `bool` and text are refused.
        above: The value must be greater than this.
        least: The value must not be less than this.
        most: The value must not be greater than this.

    Returns:
        The value as a plain float; negative zero becomes zero, so that equal terrains are equal bit by bit.

    Raises:
        InputError: Not a number, not finite, or outside the domain.
    """
    limits = ((">", above), (">=", least), ("<=", most))
    domain = " and".join(f" {sign} {bound:g}" for sign, bound in limits if math.isfinite(bound))
    wanted = f"{what} must be a finite number{domain}"
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise InputError(f"{wanted}, got {_shown(value)}")
    try:
        result = float(value) + 0.0
    except OverflowError:
        result = math.inf
    if not (math.isfinite(result) and result > above and least <= result <= most):
        raise InputError(f"{wanted}, got {result!r}")
    return result


def whole_number(what: str, value: object, *, least: int, most: int) -> int:
    """Check one whole number between `least` and `most`, both included.

    Raises:
        InputError: Not an integer, or outside the domain.
    """
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or not least <= int(value) <= most:
        raise InputError(f"{what} must be a whole number from {least} to {most}, got {_shown(value)}")
    return int(value)


def interval(
    what: str, value: object, *, above: float = -math.inf, least: float = -math.inf, most: float = math.inf
) -> tuple[float, float]:
    """Check a range (low, high) with low <= high; each end is checked as by `number`.

    Raises:
        InputError: Not a pair, an end outside the domain, or ends in the wrong order.
    """
    if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != 2:
        raise InputError(f"{what} must be a range (low, high), on the command line low..high, got {_shown(value)}")
    low, high = (number(f"{what}, {end} end", v, above=above, least=least, most=most)
                 for end, v in zip(("low", "high"), value, strict=True))  # fmt: skip
    if low > high:
        raise InputError(f"{what} must have its low end first, got ({low:g}, {high:g}): swap them")
    return low, high


def known_name(what: str, name: object, valid: Iterable[str]) -> str:
    """Check that `name` is one of the `valid` names.

    Raises:
        InputError: It is not; the message lists the valid names and suggests the nearest.
    """
    names = tuple(valid)
    if isinstance(name, str) and name in names:
        return name
    near = difflib.get_close_matches(str(name), names, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise InputError(f"unknown {what} {_shown(name)}: valid are {', '.join(names) or 'none'}{hint}")


def read_samples(path: Path) -> list[Sample]:
    """Read an elevation profile from a comma-separated file with the columns x, z in m.

    A header, blank lines and comments from `#` to the end of a line are allowed. x increases strictly, except that
    the two ends of a vertical step repeat it once.

    Returns:
        The samples as they stand in the file; at least two, the first and the last being no steps.

    Raises:
        InputError: The file cannot be read, or a row is not as described; the message names the line.
    """
    samples: list[Sample] = []
    header = False
    for line, full in enumerate(_read_text(path).splitlines(), start=1):
        row = full.split("#", 1)[0].strip()
        if not row:
            continue
        cells = [cell.strip().strip("\"'").strip() for cell in row.split(",")]
        if len(cells) != 2:
            raise InputError(
                f"line {line}: {len(cells)} column(s) in {_shown(row)}; expected two, x and z in m, and a comma"
            )
        values = [_parse_number(cell) for cell in cells]
        if not samples and not header and values == [None, None]:
            header = True
            if cells[0].lower().startswith("z") or cells[1].lower().startswith("x"):
                raise InputError(
                    f"line {line}: the header reads {_shown(row)}; expected x first, then z: swap the columns"
                )
            continue
        x, z = (
            number(f"line {line}: {name} (m)", cell if value is None else value)
            for name, cell, value in zip("xz", cells, values, strict=True)
        )
        _check_order(samples, Sample(x, z, line))
        samples.append(Sample(x, z, line))
    if len(samples) < 2:
        raise InputError(f"{len(samples)} elevation sample(s); expected at least two rows x,z in m")
    if samples[-1].x == samples[-2].x:
        raise InputError(
            f"line {samples[-1].line}: a vertical step at the last sample leads onto no ground; add a sample beyond it"
        )
    if not samples[0].x <= 0.0 < samples[-1].x:
        raise InputError(
            f"the samples reach from x = {samples[0].x:g} m to {samples[-1].x:g} m, but the robot starts at x = 0 and "
            "walks forward; subtract the x of the place where it shall start from all x"
        )
    return samples


def read_segments(path: Path) -> list[tuple[object, ...]]:
    """Read `segments` from a TOML or YAML file: a list of [length, slope_deg, step] or of tables with these keys.

    Returns:
        One tuple (length, slope_deg) or (length, slope_deg, step) per segment; the values are not checked here.

    Raises:
        InputError: The file cannot be read or parsed, or holds anything else; the message names the line or segment.
    """
    import yaml  # here: few need it

    text = _read_text(path)
    yaml_file = path.suffix.lower() != ".toml"
    try:
        content: object = yaml.safe_load(text) if yaml_file else tomllib.loads(text)
    except (yaml.YAMLError, tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"not readable as {'YAML' if yaml_file else 'TOML'}: {reason}") from error
    form = (
        "segments = [[length_m, slope_deg, step_m], ...]"
        if not yaml_file
        else "segments: [[length_m, slope_deg, step_m], ...]"
    )
    if not isinstance(content, dict):
        raise InputError(f"holds no table; expected {form}")
    for key in content:
        known_name("key", key, ("segments",))
    segments = content.get("segments")
    if not isinstance(segments, list):
        raise InputError(f"'segments' is {'missing' if segments is None else _shown(segments)}; expected {form}")
    return [_read_segment(k, segment, yaml_file) for k, segment in enumerate(segments, start=1)]


def parse_parameters(text: str) -> dict[str, Any]:
    """Parse "key=value,key=value" from the command line.

    A value is a whole number, a number, or a range "low..high".

    Returns:
        The values by name: int, float or (low, high).

    Raises:
        InputError: An item without "=", a name given twice, or a value that is no number.
    """
    parameters: dict[str, Any] = {}
    for item in text.split(","):
        key, equals, value = (part.strip() for part in item.partition("="))
        if not key or not equals or not value:
            raise InputError(f"cannot read {_shown(item.strip())} in {_shown(text)}; expected key=value,key=value")
        if key in parameters:
            raise InputError(f"{key} is given twice in {_shown(text)}; give it once")
        ends = [_parse_number(end.strip()) for end in value.split("..", 1)]
        if None in ends:
            raise InputError(f"{key}={value}: {_shown(value)} is no number; expected a number or a range low..high")
        parameters[key] = ends[0] if len(ends) == 1 else tuple(ends)
    return parameters


def _read_text(path: Path) -> str:
    """Read a text file that is not empty."""
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise InputError("there is no such file; check the path and the working folder") from error
    except IsADirectoryError as error:
        raise InputError(f"is a folder; expected a file with one of the suffixes {', '.join(FILE_SUFFIXES)}") from error
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from error
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(f"line {line}: not UTF-8 text; expected a text file, save it as UTF-8") from error
    if "\0" in text:
        raise InputError(f"line {text.count(chr(10), 0, text.index(chr(0))) + 1}: binary data; expected a text file")
    if not text.strip():
        raise InputError("the file is empty")
    return text


def _check_order(samples: Sequence[Sample], new: Sample) -> None:
    """Check that a new elevation sample may follow those already read."""
    if not samples or new.x > samples[-1].x:
        return
    last = samples[-1]
    if new.x < last.x:
        raise InputError(f"line {new.line}: x = {new.x:g} m comes after {last.x:g} m; sort the rows by x")
    if new.z == last.z:
        raise InputError(f"line {new.line}: repeats the sample of line {last.line}; delete one of them")
    if len(samples) == 1:
        raise InputError(
            f"line {new.line}: a vertical step at the first sample has no ground before it; drop line {last.line}"
        )
    if samples[-2].x == new.x:
        raise InputError(
            f"line {new.line}: x = {new.x:g} m stands there three times; a vertical step has two rows, its ends"
        )


def _read_segment(k: int, segment: object, yaml_file: bool) -> tuple[object, ...]:
    """Bring the k-th segment of a file (1-based), a list or a table, into a tuple."""
    if isinstance(segment, dict):
        for key in segment:
            try:
                known_name("key", key, SEGMENT_KEYS)
            except InputError as error:
                raise InputError(f"segment {k}: {error}") from error
        for key in SEGMENT_KEYS[:2]:
            if key not in segment:
                raise InputError(
                    f"segment {k}: {key!r} is missing; a segment has {', '.join(SEGMENT_KEYS)} (step may be left out)"
                )
        segment = [segment[key] for key in SEGMENT_KEYS if key in segment]
    if not isinstance(segment, list):
        raise InputError(f"segment {k} is {_shown(segment)}; expected [length_m, slope_deg, step_m] or a table")
    if yaml_file and any(isinstance(v, str) and _parse_number(v) is not None for v in segment):
        raise InputError(
            f"segment {k}: {_shown(segment)} holds a number as text; YAML wants 1.0e-3 for 1e-3, and no quotes"
        )
    return tuple(segment)


def _parse_number(text: str) -> int | float | None:
    """Return the number that a text spells, None if it spells none."""
    if "_" in text:
        return None
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return None


def _shown(value: object) -> str:
    """Return a value's repr, short enough for a message."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
