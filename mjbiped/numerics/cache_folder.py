"""The folder of machine code on disk: where it is, and how it is kept small."""

from __future__ import annotations

import os
import shutil
import time
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

import platformdirs

MOST = 1_000_000_000
"""Size beyond which the code that was not used for longest is thrown away, bytes; all controllers need 80 MB."""


def root() -> Path:
    """Return the folder of all machine code: in NUMBA_CACHE_DIR if that is set, else in the user's cache.

    A user without a home that can be written to, as in some containers, has it beside this file.
    """
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(named) / "mjbiped"
    usual = platformdirs.user_cache_path("mjbiped") / "machine_code"
    with suppress(OSError):
        usual.mkdir(parents=True, exist_ok=True)
        if os.access(usual, os.W_OK):
            return usual
    return Path(__file__).parent / "__pycache__" / "machine_code"


@cache
def folder() -> Path:
    """Return the folder of what this version of Numba compiles; other versions cannot read it."""
    return root() / f"numba-{version('numba')}"


def is_kept(key: str) -> bool:
    """Whether machine code is noted as kept under a key; if so it is used now."""
    if key not in _kept and _note(key).is_file():
        note_use(str(_note(key)))  # before the code itself: `prune` deletes the note first
        _kept.add(key)
    return key in _kept


def note_kept(key: str) -> None:
    """Note that machine code is kept under a key, for this process and others."""
    if not is_kept(key):
        _kept.add(key)
        with suppress(OSError):  # others then compile it again, as they must where nothing can be written
            _note(key).touch()


_kept: set[str] = set()


def _note(key: str) -> Path:
    return folder() / f"{key[:32]}.nbk"


def clear() -> int:
    """Delete all machine code, and return its size in bytes.

    Raises:
        OSError: Something cannot be deleted.
    """
    size = sum(each for _, each, _ in _files())
    if root().is_dir():
        shutil.rmtree(root())
    return size


@cache
def prune(most: int = MOST) -> None:
    """Delete the files that were not used for longest until no more than `most` bytes are left; once a process."""
    files = sorted(_files())
    excess = sum(size for _, size, _ in files) - most
    for _, size, file in files:
        if excess <= 0:
            return
        with suppress(OSError):  # another process does the same
            file.unlink()
        excess -= size


def note_use(file: str) -> None:
    """Note that a file is used now, in its time of access, which not every file system keeps by itself."""
    with suppress(OSError):  # it may belong to somebody else
        os.utime(file, ns=(time.time_ns(), Path(file).stat().st_mtime_ns))


def _files() -> list[tuple[float, int, Path]]:
    """Time of the last use, size and path of all files."""
    found = []
    for file in root().rglob("*.nb[cik]*"):
        with suppress(OSError):
            status = file.stat()
            found.append((status.st_atime, status.st_size, file))
    return found
