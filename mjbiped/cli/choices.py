"""Types of command-line options, which read a value or say what was expected."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from mjbiped.engines.plan import INITIAL_STATES
from mjbiped.errors import InputError, shown
from mjbiped.exchange import MODULES, check_format
from mjbiped.rendering import SUFFIXES
from mjbiped.robots.kinds import NAMED
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain, Ends, Words, parse_number
from mjbiped.utils.files import check_writable

MODEL = ".xml"
"""Suffix of somebody's MJCF that is read as a robot."""


class Choice(click.ParamType):  # type: ignore[type-arg]  # generic in the latest click alone
    """Type of an option whose value a function reads.

    Attributes:
        metavar: Placeholder of a value in the help.
        read: Function that converts the given text; it raises an `InputError` to refuse it.
        expected: Description of a valid value, for the message; if empty, the message is the error's own.
    """

    def __init__(self, metavar: str, read: Callable[[Any], object] = str, expected: str = "") -> None:
        """Set the attributes."""
        self.name = self.metavar = metavar
        self.read, self.expected = read, expected

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> object:
        """Read a value."""
        try:
            return self.read(value)
        except InputError as error:
            self.fail(f"{shown(value)}; expected {self.expected}." if self.expected else f"{error}.", param, ctx)


def number(text: str, domain: Domain | Count) -> Any:
    """Read a number from a text, and check it against its domain."""
    return domain.check("", parse_number(text))


def quantity(valid: Any, *, optional: bool) -> Any:
    """Return the type of an option whose values are in a domain, or 'none' where that is allowed.

    Args:
        valid: A domain; a type of click's is returned as it is.
        optional: Whether 'none' is allowed.
    """
    if isinstance(valid, Words):
        return click.Choice(valid.valid)
    if not isinstance(valid, Domain | Count | Ends):
        return valid

    def read(value: object) -> Any:
        if optional and str(value).strip().lower() == "none":
            return None
        if not isinstance(value, str):
            return valid.check("", value)
        numbers = [parse_number(part) for part in value.split(",")]
        return valid.check("", numbers if len(numbers) > 1 else numbers[0])

    none = ("|none", ", or 'none'") if optional else ("", "")
    return Choice(_METAVARS[type(valid)] + none[0], read, valid.words + none[1])


_METAVARS = {Domain: "X", Count: "N", Ends: "X[,X]"}


def span(domain: Domain) -> Choice:
    """Return the type of two numbers in a domain, the first below the second, such as "0.8..1.6"."""

    def read(value: str) -> tuple[float, float]:
        low, high = (number(part, domain) for part in pair(value, ".."))
        if not low < high:
            raise InputError("wrong order")
        return low, high

    return Choice("LOW..HIGH", read, f"two numbers LOW..HIGH, {domain}, the first below the second, as 0.8..1.6")


def output(*suffixes: str) -> Choice:
    """Return the type of a file to write, with one of these suffixes, in a folder that can be written to.

    An existing file may be replaced.
    """
    return Choice("FILE", lambda value: to_write(Path(value), *suffixes))


def to_write(path: Path, *suffixes: str) -> Path:
    """Return the path of a file to write, as `output` describes it.

    Raises:
        InputError: The file cannot be written, or needs an extra that is not installed.
    """
    named = shown(str(path))
    if path.suffix not in suffixes:
        raise InputError(f"{named} must end in {' or '.join(suffixes)}")
    try:
        check_writable(path)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError | NotADirectoryError) and not path.parent.is_dir()
        reason = f"there is no folder {shown(str(path.parent))}; make it first" if missing else error.strerror
        raise InputError(f"{named} cannot be written: {reason}") from error
    return check_format(path) if path.suffix in MODULES else path


def pair(value: str, separator: str = "=") -> tuple[str, str]:
    """Split a text such as "ratio=-2" at its separator into two texts, neither of them empty."""
    first, _, second = value.partition(separator)
    if not first.strip() or not second.strip():
        raise InputError("one part is missing")
    return first.strip(), second


def _initial_state(value: str) -> str | tuple[float, ...]:
    if value in INITIAL_STATES:
        return value
    return tuple(domains.check_states("", [parse_number(part) for part in value.split(",")], (None,)).tolist())


def _push(value: str) -> tuple[float, float]:
    time, impulse = pair(value, ":")
    return number(time, domains.TIME), number(impulse, domains.PUSH)


def _model_error(value: str) -> tuple[str, float]:
    name, factor = pair(value)
    return name, number(factor, domains.MODEL_ERROR)


def _robot(value: str) -> str:
    if value not in NAMED and not value.endswith((".toml", MODEL)):
        raise InputError("unknown robot")
    return value


def _video_size(value: str) -> str:
    if any(number(part, domains.PIXELS) % 2 for part in pair(value.lower(), "x")):  # H.264 accepts even numbers only
        raise InputError("odd")
    return value.lower()


_PIXELS = f"even pixels from {domains.PIXELS.low} to {domains.PIXELS.high} each"

FILE = click.Path(path_type=Path)


def _panels(value: str) -> tuple[str, ...]:
    from mjbiped.records.signals import check_panels  # for this option alone

    return check_panels(value.split(","))


PANELS = Choice("NAMES", _panels)
FOLDER = click.Path(file_okay=False, path_type=Path)  # which need not exist
FOLDER.metavar = "FOLDER"  # type: ignore[attr-defined]  # as `Choice` has it
RECORD = output(".npz", *MODULES)
DATA = output(".npz")
PLOT = output(".png", ".pdf", ".svg")
VIDEO = output(*SUFFIXES)
_STATE = f"{', '.join(map(repr, INITIAL_STATES))} or four numbers q1,q2,dq1,dq2 (rad, rad/s)"
INITIAL_STATE = Choice("STATE", _initial_state, _STATE)
SETTING = Choice("NAME=VALUE", pair, "NAME=VALUE, as gain=10")
PUSH = Choice("TIME:IMPULSE", _push, "TIME:IMPULSE in s and N s, as 2:-5")
MODEL_ERROR = Choice("NAME=FACTOR", _model_error, f"NAME=FACTOR, as leg_mass=1.2, with {domains.MODEL_ERROR.words}")
CONTROLLER = Choice("NAME")
OWN_CONTROLLER = Choice("FILE.py:CLASS")
REFERENCE = Choice("GOAL")
ROBOT = Choice("NAME|FILE", _robot, f"{', '.join(NAMED)}, or a .toml or {MODEL} file")
VIDEO_SIZE = Choice("WxH", _video_size, f"WIDTHxHEIGHT, {_PIXELS}, as 1280x720")
