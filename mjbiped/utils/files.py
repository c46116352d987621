"""Files that appear whole or not at all.

A file is written under a temporary name in its folder. The temporary file is removed if the block that writes it
fails, and when the process ends; what a killed process leaves behind is removed after a day, by the next process that
writes into the same folder.
"""

from __future__ import annotations

import atexit
import errno
import os
import re
import secrets
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mjbiped.errors import MjbipedError, RecordError

_UNFINISHED = re.compile(r"\.mjbiped-[0-9a-f]{16}(\.[a-z0-9]{1,8})?", re.IGNORECASE)
_OLD = 86400.0  # s since it was last written to: left behind

_own: dict[Path, int] = {}  # unfinished files, and the process that writes them: a fork inherits the dictionary
_swept: set[Path] = set()


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
    _check_name(path)
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
        raise failure(f"cannot write {path}: {error.strerror or error}") from error


def check_writable(path: Path) -> None:
    """Check that a file can be written, without changing an existing one.

    Raises:
        OSError: It cannot; see `written_whole`.
    """
    path = path.absolute()
    _check_name(path)
    with _unfinished_file(path):
        pass


@contextmanager
def _unfinished_file(path: Path) -> Iterator[Path]:
    """Make an empty file of the same suffix in the same folder, and remove it when the block ends unless it was moved.

    Raises:
        OSError: The folder is missing or cannot be written to.
    """
    _sweep(path.parent)
    name = path.with_name(f".mjbiped-{secrets.token_hex(8)}{path.suffix.lower()}")
    _own[name] = os.getpid()
    try:
        name.touch(exist_ok=False)  # with the permissions of any new file
        yield name
    finally:
        _remove(name)


def remove_unfinished() -> None:
    """Remove the temporary files of this process, before it ends without clean-up."""
    for name, process in list(_own.items()):
        if process == os.getpid():
            with suppress(OSError):
                _remove(name)


atexit.register(remove_unfinished)  # what a second Ctrl-C kept from being removed


def _remove(name: Path) -> None:
    name.unlink(missing_ok=True)
    _own.pop(name, None)


def _check_name(path: Path) -> None:
    """Refuse a path that no file can be moved to.

    Raises:
        OSError: It is a folder, or its name is too long or contains what no name can.
    """
    try:
        there = os.lstat(path)
    except FileNotFoundError:
        return
    except ValueError as error:  # a zero byte, or half of a letter
        raise OSError(errno.EINVAL, f"no file can have this name ({error})") from error
    if stat.S_ISDIR(there.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))


def _sweep(folder: Path) -> None:
    """Remove temporary files that killed processes left in a folder more than a day ago; once for each folder."""
    if folder in _swept:
        return
    _swept.add(folder)
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if not _UNFINISHED.fullmatch(entry.name) or not entry.is_file(follow_symlinks=False):
                continue
            with suppress(OSError):  # another user's
                if Path(entry.path) not in _own and time.time() - entry.stat().st_mtime > _OLD:
                    Path(entry.path).unlink()
