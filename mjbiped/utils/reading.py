"""Read files that a user names: regular files of bounded size; anything else is refused."""

from __future__ import annotations

import stat
from pathlib import Path

from mjbiped.errors import InputError

LONGEST = 16 << 20
"""Greatest size of a text file, bytes; the longest terrain of `mjbiped.utils.domains.SEGMENTS` has a third."""


def require_file(path: Path) -> None:
    """Refuse anything but a regular file before it is opened: a pipe waits for a writer, a device has no end.

    Raises:
        InputError: The path is not a regular file; the message continues the file's name.
    """
    try:
        kind = path.stat().st_mode
    except FileNotFoundError as error:
        raise InputError("there is no such file; check the path and the working folder") from error
    except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
        raise InputError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from error
    if stat.S_ISDIR(kind):
        raise InputError("is a folder; expected a file")
    if not stat.S_ISREG(kind):
        raise InputError("is a device or a pipe; expected a file")


def read_bytes(path: Path) -> bytes:
    """Read a file of up to `LONGEST` bytes.

    Raises:
        InputError: The file cannot be read, is not regular, or is longer; the message continues the file's name.
    """
    require_file(path)
    try:
        with path.open("rb") as stream:
            data = stream.read(LONGEST + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from error
    if len(data) > LONGEST:
        raise InputError(f"is longer than {LONGEST >> 20} MiB; expected a shorter file")
    return data


def read_text(path: Path) -> str:
    """Read a text file.

    Raises:
        InputError: The file is empty or not UTF-8 text, or `read_bytes` refuses it.
    """
    data = read_bytes(path)
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
