"""Machine code on disk, in one folder that programs and versions of this project share.

A file's name contains a digest of all that its machine code depends on. Each file is written completely before it gets
its name, so that processes may start at the same time. A file that is damaged, or cannot be read or written, costs the
time of another compilation.
"""

from __future__ import annotations

import os
import shutil
import uuid
import warnings
import zlib
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
def _folder() -> Path:
    """The folder of what this version of Numba compiles; other versions cannot read it."""
    return root() / f"numba-{version('numba')}"


def load(name: str) -> bytes | None:
    """Read what was stored under a name; None if there is nothing, or if it is damaged."""
    file = _folder() / f"{name}.nbc"
    with suppress(OSError, zlib.error):  # whose checksum tells
        data = zlib.decompress(file.read_bytes())
        with suppress(OSError):  # it may belong to somebody else
            file.touch()  # `prune` goes by the time of the last use
        return data
    return None


def store(name: str, data: bytes) -> None:
    """Write data under a name; where that cannot be done, a warning says so."""
    file = _folder() / f"{name}.nbc"
    temporary = file.with_suffix(f".{uuid.uuid4().hex}.nbt")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        prune()
        temporary.write_bytes(zlib.compress(data, 1))
        temporary.replace(file)
    except OSError as error:
        warnings.warn(
            f"machine code cannot be kept in {file.parent} ({error.strerror}), and each program compiles it again; "
            "name another folder by the environment variable NUMBA_CACHE_DIR",
            stacklevel=1,  # of one place each warning is shown once
        )


def is_kept(key: str) -> bool:
    """Whether machine code is noted as kept under a key; if so it is used now."""
    return load(key) is not None  # before the code itself: `prune` deletes the note first


def note_kept(key: str) -> None:
    """Note that machine code is kept under a key, for this process and others."""
    if not is_kept(key):
        store(key, b"")


def clear() -> int:
    """Delete all machine code, and return its size in bytes.

    Raises:
        OSError: Something cannot be deleted.
    """
    size = sum(file.stat().st_size for file in root().rglob("*.nb?"))
    if root().is_dir():
        shutil.rmtree(root())
    return size


@cache
def prune(most: int = MOST) -> None:
    """Delete the files that were not used for longest until no more than `most` bytes are left; once a process."""
    total = 0
    with suppress(OSError):  # another process does the same
        for file in sorted(_folder().parent.rglob("*.nb?"), key=lambda file: file.stat().st_mtime, reverse=True):
            total += file.stat().st_size
            if total > most:
                file.unlink()
