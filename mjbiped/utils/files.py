"""Files that appear whole or not at all.

What is being written stands beside its place under a name of this package's own. It is removed however the block that
writes it ends, and when the process ends; a process that is killed leaves it behind, and the next one that writes into
the same folder removes it.
"""

from __future__ import annotations

import atexit
import errno
import os
import re
import secrets
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from mjbiped.errors import MjbipedError, RecordError

if sys.platform != "win32":
    import fcntl

_UNFINISHED = re.compile(r"\.mjbiped-[0-9a-f]{16}(\.[a-z0-9]{1,8})?", re.IGNORECASE)
_OLD = 86400.0  # s since it was last written to: taken for left behind where files cannot be locked

_own: dict[Path, int] = {}  # unfinished files, and the process that writes them
_swept: set[Path] = set()


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Write a file under another name beside its place, and move it there once it is complete.

    Args:
        path: Where the file shall stand; an older one is replaced.

    Yields:
        An empty file of the same suffix, in small letters, to write to. It is removed where the block raises.

    Raises:
        OSError: The folder is missing or cannot be written, or no file can have this name; raised before the block is
            entered.
    """
    path = path.absolute()  # whatever folder the process works in by then
    _check_name(path)
    with _unfinished_file(path) as unfinished:
        yield unfinished
        unfinished.replace(path)


@contextmanager
def saved(path: Path, failure: type[MjbipedError] = RecordError) -> Iterator[Path]:
    """Write a file as `written_whole` does, and say so in words where it cannot be written.

    Args:
        path: Where the file shall stand; an older one is replaced.
        failure: What is raised then, of the package's own exceptions.

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
    """Try whether a file can be written, leaving what is there as it is.

    Raises:
        OSError: As `written_whole`.
    """
    path = path.absolute()
    _check_name(path)
    with _unfinished_file(path):
        pass


@contextmanager
def _unfinished_file(path: Path) -> Iterator[Path]:
    """An empty file in the folder of another, of the same suffix; removed when the block ends, if it is still there.

    Raises:
        OSError: The folder is missing or cannot be written.
    """
    _sweep(path.parent)
    with ExitStack() as stack:
        while True:
            name = path.with_name(f".mjbiped-{secrets.token_hex(8)}{path.suffix.lower()}")
            _own[name] = os.getpid()
            stack.callback(_remove, name)
            handle = os.open(name, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)  # as any new file, by the user's umask
            if sys.platform == "win32":
                os.close(handle)  # an open file could not be moved
                break
            stack.callback(os.close, handle)
            if _locked(handle, name):
                break
        yield name


def _locked(handle: int, name: Path) -> bool:
    """Lock a new file for as long as this process lives; whether it is still there.

    A process that looks for what was left behind may have taken it in the moment before.
    """
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)  # the system lets go of it however this process ends
        return name.exists()
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True


def remove_unfinished() -> None:
    """Remove all that this process is writing, for those who end it at once."""
    for name, process in list(_own.items()):
        if process == os.getpid():
            with suppress(OSError):
                _remove(name)


atexit.register(remove_unfinished)  # what a second Ctrl-C kept from being removed


def _remove(name: Path) -> None:
    name.unlink(missing_ok=True)
    _own.pop(name, None)


def _check_name(path: Path) -> None:
    """Refuse a place that no file can be moved to.

    Raises:
        OSError: It is a folder, or its name is too long or holds what no name can.
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
    """Remove what killed processes left unfinished in a folder; once for each folder."""
    if folder in _swept:
        return
    _swept.add(folder)
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _UNFINISHED.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                with suppress(OSError):
                    _remove_if_left(Path(entry.path))


def _remove_if_left(name: Path) -> None:
    """Remove an unfinished file that nobody writes any more: its lock is free, or where there are none it is old.

    Raises:
        OSError: Somebody writes it, or it is another user's.
    """
    handle = os.open(name, os.O_RDWR)
    try:
        age = time.time() - os.fstat(handle).st_mtime
        if sys.platform != "win32":
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return
            except OSError:  # no locks here
                if age < _OLD:
                    return
        elif age < _OLD:
            return
    finally:
        os.close(handle)
    name.unlink()
