"""Files: written whole or not at all, and read if they are regular files of bounded size; tables in Markdown.

A file is written under a temporary name in its folder, and renamed at the end.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from mjbiped.errors import InputError, MjbipedError, RecordError

LONGEST = 16 << 20
"""Greatest size of a text file, bytes; the longest terrain of `mjbiped.utils.domains.SEGMENTS` has a third."""


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Write a file under a temporary name in its folder, and rename it once it is complete.

    Args:
        path: The file; an older one is replaced.

    Yields:
        An empty file of the same suffix, in lower case, to write to. It is removed if the block raises.

    Raises:
        OSError: The folder is missing or cannot be written to, or no file can have this name; raised before the block
            is entered.
    """
    path = path.absolute()  # whatever folder the process works in by then
    with _unfinished_file(path) as unfinished:
        yield unfinished
        unfinished.replace(path)


@contextmanager
def saved(path: Path, failure: type[MjbipedError] = RecordError) -> Iterator[Path]:
    """Write a file as `written_whole` does, and raise an exception of this package if that fails.

    Args:
        path: The file; an older one is replaced.
        failure: The exception.

    Yields:
        An empty file of the same suffix to write to.

    Raises:
        MjbipedError: The file cannot be written.
    """
    try:
        with written_whole(path) as unfinished:
            yield unfinished
    except OSError as error:
        remedy = "; make its folder first" if isinstance(error, FileNotFoundError) else ""
        raise failure(f"cannot write {path}: {error.strerror or error}{remedy}") from error


def check_writable(path: Path) -> None:
    """Check that a file can be written, without changing an existing one.

    Raises:
        OSError: It cannot; see `written_whole`.
    """
    with _unfinished_file(path.absolute()):
        pass


@contextmanager
def _unfinished_file(path: Path) -> Iterator[Path]:
    """Make an empty file of the same suffix in the same folder, and remove it when the block ends unless it was moved.

    Raises:
        OSError: The path is a folder, its folder is missing or cannot be written to, or no file can have this name.
    """
    try:
        if path.is_dir() and not path.is_symlink():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        os.lstat(path)
    except FileNotFoundError:
        pass
    except ValueError as error:  # a zero byte, or half of a letter
        raise OSError(errno.EINVAL, f"no file can have this name ({error})") from error
    name = path.with_name(f".mjbiped-{secrets.token_hex(8)}{path.suffix.lower()}")
    try:
        name.touch(exist_ok=False)  # with the permissions of any new file
        yield name
    finally:
        name.unlink(missing_ok=True)


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


def markdown_table(headings: Sequence[str], rows: Iterable[Sequence[str]], words: int | None = None) -> str:
    """Write a table in Markdown, without a line break at its end.

    Args:
        headings: Heading of each column.
        rows: Cells of each row.
        words: Number of columns, the first ones, that are aligned left; all others are aligned right. None aligns all
            columns left.
    """
    left = len(headings) if words is None else words
    rules = ["---"] * left + ["---:"] * (len(headings) - left)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (headings, rules, *rows))
