"""`mjcb_control`, which is one for all threads of a process: who is driven by it, and what stood there before.

MuJoCo calls a C function, which finds a walk by the address of its mjData. That of walks in machine code is machine
code and has a table of them; where a walk is interpreted, one that calls Python stands before it. Data that are of no
walk go to the function that somebody else has installed.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from mjbiped.utils.mujoco import mujoco


class Interpreted(Protocol):
    """A walk in plain Python."""

    def on_control(self) -> None:
        """Act for `mjcb_control`; raises nothing, as no exception could pass through C."""


FOREIGN, FARTHEST, PAIRS = range(3)
PLACES = 1 << 14  # for walks in machine code
table = np.zeros(PAIRS + 2 * PLACES, dtype=np.int64)
"""For machine code: the address of somebody else's `mjcb_control`, how far behind its place a walk can be found, and
pairs of addresses, of an mjData and of its walk's `Constants`."""

_lock = threading.RLock()  # held while anything of the following changes; collected walks may take it again
_interpreted: dict[int, Interpreted] = {}  # by the addresses of their data
_compiled = 0  # number of those who need the machine code
_native: Any = None  # that machine code and its address, once a walk has needed it
_theirs: list[int | None] | None = None  # what stood in MuJoCo's places before ours; None: nothing of ours is there
_here = threading.local()  # `walks`: number of this thread's that are being stepped


def place_of(data: int) -> int:
    """First place in the table for the data at an address."""
    return (data >> 6) % PLACES


def register(data: int, constants: int) -> None:
    """Let machine code find a walk's constants by its data; both are addresses."""
    with _lock:
        far, first = 0, place_of(data)
        while table[PAIRS + 2 * ((first + far) % PLACES)]:
            far += 1
        at = PAIRS + 2 * ((first + far) % PLACES)
        table[FARTHEST] = max(table[FARTHEST], far)
        table[at + 1], table[at] = constants, data  # in this order, for other threads are reading


def forget(data: int) -> None:
    """Take a walk out of the table."""
    with _lock:
        table[PAIRS::2][table[PAIRS::2] == data] = 0


def _refresh() -> None:
    """Write into MuJoCo's places what is needed there now; other threads may be calling it."""
    global _theirs
    slots = _slots()
    if _interpreted or _compiled:
        if _theirs is None:
            _theirs = [slot.value for slot in slots]
            table[FOREIGN] = _theirs[0] or 0
        ours = _PYTHON if _interpreted else _native
        slots[0].value, slots[1].value, slots[2].value = ours[1], _HUSH[1], None
    elif _theirs is not None:
        for slot, before in zip(slots, _theirs, strict=True):
            slot.value = before
        _theirs = None


@cache
def _slots() -> list[ctypes.c_void_p]:
    """MuJoCo's places for our callback, for one that hears warnings, and for a clock.

    Each mjData counts its warnings; without a hearer MuJoCo would write them to a file. A clock in Python, as
    dm_control's profiling leaves one behind, would be called by all threads, and rests.
    """
    (path,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    library = ctypes.CDLL(str(path))
    return [ctypes.c_void_p.in_dll(library, name) for name in ("mjcb_control", "mju_user_warning", "mjcb_time")]


def enter(native: Any) -> None:
    """Have the C function act on walks as machine code, in any threads, until as many calls of `leave`."""
    global _compiled, _native
    with _lock:
        _compiled, _native = _compiled + 1, native
        if _compiled == 1:
            _refresh()
    _here.walks = getattr(_here, "walks", 0) + 1


def leave() -> None:
    """Need the C function no more."""
    global _compiled
    _here.walks -= 1
    with _lock:
        _compiled -= 1
        if _compiled == 0:
            _refresh()


@contextmanager
def compiled(native: Any) -> Iterator[None]:
    """Have the C function act on walks as machine code meanwhile."""
    enter(native)
    try:
        yield
    finally:
        leave()


@contextmanager
def interpreted(data: int, walk: Interpreted) -> Iterator[None]:
    """Have Python act on a walk by the address of its data meanwhile."""
    with _lock:
        before = _interpreted.get(data)
        _interpreted[data] = walk
        _refresh()
    _here.walks = getattr(_here, "walks", 0) + 1
    try:
        yield
    finally:
        _here.walks -= 1
        with _lock:
            if before is None:
                del _interpreted[data]
            _refresh()


def walking() -> bool:
    """Whether a walk of this thread is being stepped."""
    return getattr(_here, "walks", 0) > 0


@contextmanager
def python_removed() -> Iterator[None]:
    """Take somebody else's callbacks in Python away: MuJoCo's compiler steps models that Python cannot hold."""
    with _lock, ExitStack() as stack:
        for name in dir(mujoco):
            if name.startswith("get_mjcb_"):
                standing, put = getattr(mujoco, name)(), getattr(mujoco, name.replace("get", "set", 1))
                if standing is not None and not hasattr(standing, "argtypes"):
                    put(None)
                    stack.callback(put, standing)
        stack.callback(table.__setitem__, FOREIGN, int(table[FOREIGN]))
        table[FOREIGN] = 0
        yield


def _control(model: int, data: int) -> None:
    """`mjcb_control` in Python."""
    walk = _interpreted.get(data)
    if walk is not None:
        walk.on_control()
    elif _native is not None:
        _native[0](model, data)
    elif table[FOREIGN]:
        _CONTROL(int(table[FOREIGN]))(model, data)


def _hush(message: bytes) -> None:
    """`mju_user_warning`."""


def addressed(function: Any) -> tuple[Any, int]:
    """A C function of ctypes, and its address."""
    return function, ctypes.cast(function, ctypes.c_void_p).value or 0


_CONTROL = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64)
_PYTHON = addressed(_CONTROL(_control))
_HUSH = addressed(ctypes.CFUNCTYPE(None, ctypes.c_char_p)(_hush))
