"""The package's exceptions, how their messages show values, and where in a user's code something went wrong.

`except MjbipedError` catches every error that a user can correct.
"""

from __future__ import annotations

import math
import reprlib
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LONGEST_SHOWN = 80


class MjbipedError(Exception):
    """Base of every exception that mjbiped raises on purpose."""


class InputError(MjbipedError, ValueError):
    """A value from the user is outside its domain; raised before anything is computed."""


class GaitError(MjbipedError):
    """No gait exists, or none was found, for the robot and the request."""


class RecordError(MjbipedError):
    """A record cannot be written, or cannot be read as a walk."""


class RenderError(MjbipedError):
    """Nothing can be drawn: no GL platform, no video encoder, or nothing to show."""


@contextmanager
def prefixed(words: str) -> Iterator[None]:
    """Put words, such as an option's name, before the message of an `InputError` that is raised within."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{words}{error}") from error


class _Short(reprlib.Repr):
    """Shortens values until they fit into a sentence; containers show their first entries."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxtuple = self.maxlist = self.maxdict = self.maxset = self.maxfrozenset = self.maxdeque = 12
        self.maxstring = self.maxlong = self.maxother = LONGEST_SHOWN

    def repr_int(self, x: int, level: int) -> str:
        try:
            return super().repr_int(x, level)
        except ValueError:  # Python writes out no number of more than 4300 digits
            return f"<a whole number of about {math.ceil(x.bit_length() * math.log10(2.0))} digits>"

    def repr1(self, x: object, level: int) -> str:
        try:
            return super().repr1(x, level)
        except Exception:  # a user's object may fail in its own repr, one of a built-in type in its length, too
            return f"<an object of type {type(x).__name__}>"

    def repr_instance(self, x: object, level: int) -> str:
        return " ".join(repr(x).split())


_SHORT = _Short()


def shown(value: object) -> str:
    """Describe a value for an error message, without raising an exception.

    Args:
        value: Anything that a user may have given.

    Returns:
        Its `repr` on one line, with `...` in the middle if it has more than `LONGEST_SHOWN` characters.
    """
    return shortened(_SHORT.repr(value), LONGEST_SHOWN)


def explained(error: BaseException) -> str:
    """Describe an exception of foreign code, without raising one."""
    name = type(error).__name__
    try:
        return f"{name}: {error}".rstrip(": ")
    except Exception:  # its message is foreign code, too
        return f"{name}, whose words cannot be told"


def place_of(error: BaseException, source: type | Path) -> str:
    """Find where in a user's code an error arose: file, line, function and the line's text, in brackets.

    Args:
        error: The exception.
        source: The user's class or file. The last line in it, or in the files of the class's bases, is named;
            otherwise the last one outside this package.

    Returns:
        The place, with a blank before it; empty if none outside this package is known.
    """
    files: set[str | None] = {str(source)}
    if not isinstance(source, Path):
        files = {getattr(sys.modules.get(kind.__module__), "__file__", None) for kind in source.__mro__}
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if not frame.filename.startswith("<") and Path(__file__).parent not in Path(frame.filename).parents
    ]
    chosen = [frame for frame in frames if frame.filename in files] or frames
    if not chosen:
        return ""
    last = chosen[-1]
    text = f": {shortened(last.line, 80)}" if last.line else ""
    within = f", in {last.name}" if last.name != "<module>" else ""
    return f" ({Path(last.filename).name}, line {last.lineno}{within}{text})"


def shortened(text: str, longest: int = 300) -> str:
    """Cut the middle out of a long text, such as a path or the message of another library.

    Args:
        text: The text.
        longest: Greatest number of characters that remain.
    """
    if len(text) <= longest:
        return text
    half = (longest - len(_SHORT.fillvalue)) // 2
    return f"{text[:half]}{_SHORT.fillvalue}{text[-half:]}"
