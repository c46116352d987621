"""Types of command-line options, which read a value or say what was expected."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from mjbiped.control.loading import FORMS, is_reference
from mjbiped.control.registry import controller_names, parse_reference
from mjbiped.engines.plan import INITIAL_STATES
from mjbiped.errors import InputError, shown
from mjbiped.exchange.formats import MODULES, check_format
from mjbiped.plotting.width import figure_width
from mjbiped.rendering.look import SUFFIXES, look
from mjbiped.robots.kinds import KINDS, NAMED, named
from mjbiped.terrain.files import parse_number
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain, Ends, Words
from mjbiped.utils.files import check_writable

MODEL = ".xml"
"""Suffix of somebody's MJCF that is read as a robot."""


class Kind(click.ParamType):  # type: ignore[type-arg]  # generic in the latest click alone
    """Type of an option whose value a function reads.

    Attributes:
        metavar: Placeholder of a value in the help.
        read: Function that converts the given text; it raises an `InputError` to refuse it.
        expected: Description of a valid value, for the message; if empty, the message is the error's own.
    """

    def __init__(self, metavar: str, read: Callable[[Any], Any], expected: str = "") -> None:
        """Set the attributes."""
        self.name = self.metavar = metavar
        self.read, self.expected = read, expected

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> object:
        """Read a value."""
        try:
            return self.read(value)
        except InputError as error:
            self.fail(f"{shown(value)}; expected {self.expected}." if self.expected else f"{error}.", param, ctx)


class Width(click.Choice):  # type: ignore[type-arg]  # generic in the latest click alone
    """Type of the option that sets the width of all figures until the command ends."""

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> object:
        """Read a width's name."""
        name = super().convert(value, param, ctx)
        if ctx is not None:
            ctx.with_resource(figure_width(name))
        return name


def output(*suffixes: str) -> Kind:
    """Return the type of a file to write, with one of these suffixes, in a folder that can be written to.

    An existing file may be replaced.
    """

    def read(value: Any) -> Path:
        path = Path(value)
        named = shown(str(path))
        if path.suffix not in suffixes:
            raise InputError(f"{named} must end in {' or '.join(suffixes)}")
        try:
            if path.is_dir():
                raise InputError(f"{named} is a folder")
            if not path.parent.is_dir():
                raise InputError(f"{named}: there is no folder {shown(str(path.parent))}; make it first")
            check_writable(path)
        except InputError:
            raise
        except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
            raise InputError(f"{named} cannot be written: {getattr(error, 'strerror', None) or error}") from error
        return path

    return Kind("FILE", read)


def _record(*suffixes: str) -> Kind:
    """Return the type of a file of a walk's record, for this program or with one of these suffixes for others."""
    file = output(".npz", *suffixes)

    def read(value: object) -> Path:
        path: Path = file.read(value)
        return check_format(path) if path.suffix in suffixes else path

    return Kind("FILE", read)


def number(text: object, domain: Domain | Count) -> Any:
    """Read a number from a text, and check it against its domain."""
    return domain.check("", parse_number(text) if isinstance(text, str) else text)


def quantity(domain: Domain | Count | Ends | Words) -> object:
    """Return the type of a number, of two ends, or of a word, in a domain."""
    if isinstance(domain, Words):
        return click.Choice(domain.valid)
    if isinstance(domain, Ends):
        return Kind("X[,X]", lambda value: domain.read("", value), domain.words)
    return Kind("X" if isinstance(domain, Domain) else "N", lambda value: number(value, domain), domain.words)


def optional(domain: Domain | Count) -> Kind:
    """Return the type of a number in a domain, or 'none'."""

    def read(value: object) -> Any:
        return None if str(value).strip().lower() == "none" else number(value, domain)

    return Kind("X|none", read, f"{domain.words}, or 'none'")


def span(domain: Domain) -> Kind:
    """Return the type of two numbers in a domain, the first below the second, such as "0.8..1.6"."""

    def read(value: object) -> tuple[float, float]:
        first, _, second = str(value).partition("..")
        low, high = number(first, domain), number(second, domain)
        if not low < high:
            raise InputError("wrong order")
        return low, high

    return Kind("LOW..HIGH", read, f"two numbers LOW..HIGH, {domain}, the first below the second, as 0.8..1.6")


def pair(value: str, separator: str = "=") -> tuple[str, str]:
    """Split a text such as "ratio=-2" at its separator into two texts, neither of them empty."""
    first, _, second = value.partition(separator)
    if not first.strip() or not second.strip():
        raise InputError("one part is missing")
    return first.strip(), second


def _initial_state(value: str) -> str | tuple[float, ...]:
    if value in INITIAL_STATES:
        return value
    numbers = [parse_number(part) for part in value.split(",")]
    return tuple(domains.check_states("", numbers, (len(numbers) if len(numbers) in _STATES else 4,)).tolist())


def _push(value: str) -> tuple[float, float]:
    time, impulse = pair(value, ":")
    return number(time, domains.TIME), number(impulse, domains.PUSH)


def _model_error(value: str) -> tuple[str, float]:
    name, factor = pair(value)
    return domains.known_name("parameter of the robot", name, _NUMBERS), number(factor, domains.MODEL_ERROR)


def _controller(value: str) -> str:
    names = controller_names()
    if is_reference(value) or value in names:
        return value  # a class of the user's own is loaded later
    hint = domains.nearest(value, names)
    raise InputError(f"{shown(value)}; expected one of {', '.join(names)}, or {FORMS}{hint}")


def _own_controller(value: str) -> str:
    if is_reference(value):
        return value
    raise InputError(f"{shown(value)}; expected {FORMS}; registered controllers are found by themselves")


def _reference(value: object) -> str:
    parse_reference(value)
    return str(value)


def _robot(value: object) -> str:
    text = str(value)
    if text not in NAMED and not text.endswith((".toml", MODEL)):
        raise InputError("unknown robot")
    return text


def _panels(value: str) -> tuple[str, ...]:
    from mjbiped.records.signals import check_panels  # for this option alone

    return check_panels(value.split(","))


def _video_size(value: str) -> tuple[int, int]:
    width, height = (number(part, domains.PIXELS) for part in pair(value.lower(), "x"))
    if width % 2 or height % 2:  # H.264 accepts even numbers only
        raise InputError("odd")
    return width, height


def _of_look(argument: str) -> Callable[[str], str]:
    """Return a function that checks names for an argument of `mjbiped.rendering.look.look`, and returns them."""

    def read(value: str) -> str:
        look(**{argument: value})
        return value

    return read


_PARAMETERS = {name: named(name)[0].parameters() for name in NAMED}
OWNERS = {key: [name for name in NAMED if key in _PARAMETERS[name]] for own in _PARAMETERS.values() for key in own}
"""Names of the robots that have a parameter, by the parameter's name."""
_NUMBERS = [key for key in OWNERS if any(key in kind.numbers() for kind in KINDS.values())]

_STATES = [2 * len(kind.angles) for kind in KINDS.values()]  # how many numbers one has
_PIXELS = f"even pixels from {domains.PIXELS.low} to {domains.PIXELS.high} each"

FOLDER = click.Path(file_okay=False, path_type=Path)  # which need not exist
FOLDER.metavar = "FOLDER"  # type: ignore[attr-defined]  # as `Kind` has it
RECORD = _record(*MODULES)
PANELS = Kind("NAMES", _panels)
PLOT = output(".png", ".pdf", ".svg")
VIDEO = output(*SUFFIXES)
_STATE = f"{', '.join(map(repr, INITIAL_STATES))} or four numbers q1,q2,dq1,dq2 (rad, rad/s)"
INITIAL_STATE = Kind("STATE", _initial_state, _STATE)
SETTING = Kind("NAME=VALUE", pair, "NAME=VALUE, as gain=10")
PUSH = Kind("TIME:IMPULSE", _push, "TIME:IMPULSE in s and N s, as 2:-5")
_FACTORS = f"NAME=FACTOR, as leg_mass=1.2, of {', '.join(_NUMBERS)}, and {domains.MODEL_ERROR.words}"
MODEL_ERROR = Kind("NAME=FACTOR", _model_error, _FACTORS)
CONTROLLER = Kind("NAME", _controller)
OWN_CONTROLLER = Kind("FILE.py:CLASS", _own_controller)
REFERENCE = Kind("GOAL", _reference)
ROBOT = Kind("NAME|FILE", _robot, f"{', '.join(NAMED)}, or a .toml or {MODEL} file")
VIDEO_SIZE = Kind("WxH", _video_size, f"WIDTHxHEIGHT, {_PIXELS}, as 1280x720")
HIDDEN = Kind("NAMES", _of_look("hide"))
VISUAL_FLAG = Kind("NAME", _of_look("flags"))
