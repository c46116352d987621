"""What a function's machine code depends on, where it is kept on disk, and the line that says when it is made.

Programs and versions of this project share one folder. A file's name contains a digest of all that its machine code
depends on. Each file is written completely before it gets its name, so that processes may start at the same time. A
file that is damaged, or cannot be read or written, costs the time of another compilation.
"""

from __future__ import annotations

import dis
import hashlib
import os
import shutil
import sys
import uuid
import warnings
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, lru_cache
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import platformdirs

Function = Callable[..., Any]

MOST = 1_000_000_000
"""Size beyond which the code that was not used for longest is thrown away, bytes; all controllers need 80 MB."""

_wanted = True
_waiting: list[str] = []  # sentences to print if something is compiled, one for each `announced`


def with_callees(*functions: object) -> list[FunctionType]:
    """Functions and all that they call, directly or indirectly, those that a user has jitted included."""
    found: dict[FunctionType, None] = {}
    waiting = list(functions)
    while waiting:
        each = waiting.pop(0)
        each = getattr(each, "py_func", each)
        if isinstance(each, FunctionType) and each not in found:
            found[each] = None
            waiting += (value for _, value in _named(each))
    return list(found)


def _named(function: FunctionType) -> Iterator[tuple[str, object]]:
    """Global names that a function uses, attributes of modules, and free variables, with their values."""
    code = function.__code__
    for name in code.co_names:
        value = function.__globals__.get(name)
        if isinstance(value, ModuleType):
            yield from ((part, vars(value)[part]) for part in code.co_names if part in vars(value))
        elif value is not None:
            yield name, value
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents


def described(function: FunctionType) -> object:
    """Everything that determines what a function does: code, defaults, and constant globals and free variables."""
    constants = [(name, _constant(value)) for name, value in _named(function) if not callable(value)]
    defaults = _constant(function.__defaults__ or ())
    return function.__module__, function.__qualname__, _code(function.__code__), defaults, sorted(constants, key=str)


def _constant(value: Any) -> object:
    """Describe a value so that different values have different descriptions; `repr` abridges arrays."""
    if isinstance(value, tuple):
        return type(value).__qualname__, [_constant(part) for part in value]
    if hasattr(value, "tobytes"):
        return value.dtype.str, getattr(value, "shape", ()), hashlib.sha256(value.tobytes()).hexdigest()
    return repr(value)


def _code(code: CodeType) -> object:
    constants = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return code.co_code.hex(), constants, code.co_names, code.co_varnames


@lru_cache(maxsize=64)
def raises(roots: tuple[Function, ...]) -> bool:
    """Whether the functions, or anything that they call, contain a `raise` or `assert`."""
    return any(step.opname == "RAISE_VARARGS" for step in _instructions(roots))


@lru_cache(maxsize=64)
def takes_powers(roots: tuple[Function, ...]) -> bool:
    """Whether the functions, or anything that they call, contain `**`, whose last bit is another in machine code."""
    return any(step.argrepr in ("**", "**=") or step.argval == "pow" for step in _instructions(roots))


def _instructions(roots: tuple[Function, ...]) -> Iterator[dis.Instruction]:
    for part in with_callees(*roots):
        yield from dis.get_instructions(part)


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


@contextmanager
def announced(what: str, seconds: float) -> Iterator[None]:
    """Print one line on stderr if something has to be compiled within the block, unless `announce` said otherwise.

    Args:
        what: What is compiled, such as "PassiveController for the engine mujoco".
        seconds: How long it takes at most, s.
    """
    sentence = f"compiling {what}, once; it takes some {max(seconds, 1.0):.0f} s ..."
    _waiting.append(sentence)
    try:
        yield
    finally:
        if sentence in _waiting:
            _waiting.remove(sentence)


def announce(*, wanted: bool) -> None:
    """Say whether compilations are announced from now on, as they are unless said otherwise."""
    global _wanted
    _wanted = wanted


def compilation_begins() -> None:
    """Print what waits to be announced."""
    from tqdm.auto import tqdm

    while _waiting:
        sentence = _waiting.pop(0)
        if _wanted:  # above the progress bar of a terminal; elsewhere there is none to be drawn again
            (tqdm.write if sys.stderr.isatty() else print)(sentence, file=sys.stderr)
