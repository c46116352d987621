"""`mjcb_control`, which is one for all threads of a process: who is driven by it, and what stood there before.

MuJoCo calls a C function, which finds a walk by the address of its mjData. That of walks in machine code is machine
code and has a table of them; where a walk is interpreted, one that calls Python stands before it. Data that are of no
walk go to the function that somebody else has installed.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Protocol
from weakref import WeakValueDictionary

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
_interpreted: WeakValueDictionary[int, Interpreted] = WeakValueDictionary()  # by the addresses of their data
_needed = {False: 0, True: 0}  # how often the function in Python is needed, and the machine code
_native: Any = None  # that machine code and its address, once a walk has needed it
_ours: Any = None  # which of them stands there
_theirs: list[int | None] = []  # what stood in MuJoCo's places before that
# for our callback, for one that hears warnings (each mjData counts its own; without a hearer MuJoCo would write them to
# a file), and for a clock: one in Python, as dm_control's profiling leaves one behind, would be called by all threads
_PLACES = ("mjcb_control", "mju_user_warning", "mjcb_time")
_here = threading.local()  # `walks`: number of this thread's that are being stepped


def place_of(data: int) -> int:
    """First place in the table for the data at an address."""
    return (data >> 6) % PLACES


def register(data: int, walk: Interpreted, constants: int) -> None:
    """Let a walk be found by its data.

    Args:
        data: Address of the mjData.
        walk: The walk, if it is interpreted.
        constants: Address of its constants for machine code; 0: it is interpreted.
    """
    with _lock:
        if not constants:
            _interpreted[data] = walk
            return
        far, first = 0, place_of(data)
        while table[PAIRS + 2 * ((first + far) % PLACES)]:
            far += 1
        at = PAIRS + 2 * ((first + far) % PLACES)
        table[FARTHEST] = max(table[FARTHEST], far)
        table[at + 1], table[at] = constants, data  # in this order, for other threads are reading


def forget(data: int) -> None:
    """Let no walk be found by these data any more."""
    with _lock:
        _interpreted.pop(data, None)
        table[PAIRS::2][table[PAIRS::2] == data] = 0


def _refresh() -> None:
    """Write into MuJoCo's places what is needed there now; other threads may be calling it."""
    global _theirs, _ours
    wanted = _PYTHON if _needed[False] else _native if _needed[True] else None
    if wanted is _ours:
        return
    slots = [_slot(name) for name in _PLACES]
    if _ours is None:
        _theirs = [slot.value for slot in slots]
        table[FOREIGN] = _theirs[0] or 0
    for slot, value in zip(slots, [wanted[1], _HUSH[1], None] if wanted else _theirs, strict=True):
        slot.value = value
    _ours = wanted


@cache
def _slot(name: str) -> ctypes.c_void_p:
    """MuJoCo's place for a callback, by its name in C."""
    (path,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(path)), name)


def enter(native: object) -> None:
    """Have our callback act on walks, in any threads, until as many calls of `leave`.

    Args:
        native: `native.control_callback()` for walks in machine code; None for one in plain Python.
    """
    global _native
    with _lock:
        _native = native or _native
        _needed[native is not None] += 1
        _refresh()
    _here.walks = getattr(_here, "walks", 0) + 1


def leave(native: object) -> None:
    """Need the callback no more."""
    _here.walks -= 1
    with _lock:
        _needed[native is not None] -= 1
        _refresh()


def walking() -> bool:
    """Whether a walk of this thread is being stepped."""
    return getattr(_here, "walks", 0) > 0


@contextmanager
def python_removed() -> Iterator[None]:
    """Take somebody else's callbacks in Python away: MuJoCo's compiler steps models that Python cannot hold."""
    with _lock:
        # what MuJoCo's bindings tell of our places is what stood there before
        names = [name[4:] for name in dir(mujoco) if name.startswith("get_mjcb_")]
        free = {name: getattr(mujoco, f"get_{name}")() for name in names if _ours is None or name not in _PLACES}
        taken = {name: each for name, each in free.items() if each and not hasattr(each, "argtypes")}
        foreign, table[FOREIGN] = int(table[FOREIGN]), 0
        try:
            for name in taken:
                getattr(mujoco, f"set_{name}")(None)
            yield
        finally:
            table[FOREIGN] = foreign
            for name, each in taken.items():
                getattr(mujoco, f"set_{name}")(each)


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
