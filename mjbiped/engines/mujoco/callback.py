"""`mjcb_control`, which is one for all threads of a process: for whom it stands there, and what stood there before.

Walks as machine code share a C function that finds each of them by its userdata: any number of them go on in any
threads. Where a walk is interpreted, a function in Python stands there, which knows the others, too.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Protocol

from mjbiped.engines.mujoco import step
from mjbiped.engines.mujoco.state import MARK
from mjbiped.errors import MjbipedError
from mjbiped.utils.mujoco import mujoco


class Interpreted(Protocol):
    """A walk in plain Python.

    Attributes:
        constants: See `mjbiped.engines.mujoco.state.Constants`.
    """

    constants: Any


stepping = threading.RLock()
"""Held while MuJoCo may call Python: by interpreted steps, and while a model is compiled, for which there must be no
callback in Python (MuJoCo calls it with models that Python cannot hold)."""

_LONGEST_WAIT = 60.0  # for the interpreted walk of another thread, s: longer ones are compiled
_lock = threading.Lock()  # held while anything of the following changes
_interpreted: dict[int, Interpreted] = {}  # by the numbers in their userdata, below zero
_compiled = 0  # number of those who need the C function
_native: Any = None  # the C function and its address, once a walk has needed them
_NAMES = ("mjcb_control", "mju_user_warning", "mjcb_time")
"""MuJoCo's places that matter to a walk. The second hears warnings, which each mjData counts: without a function there,
MuJoCo would write them to a file. A clock in Python, as dm_control's profiling leaves one behind, takes no lock."""
_theirs: Any = None  # somebody else's `mjcb_control`
_before: list[int | None] = []  # addresses that stood in all three places
_NOTHING, _PYTHON, _C = range(3)
_there = _NOTHING  # what of ours stands there
_bound = False  # whether MuJoCo's bindings hold `_control`
_here = threading.local()  # `walks`: number of this thread's that are being stepped


def _refresh() -> None:
    """Put into MuJoCo's places what is needed there now; other threads may be calling it, so that no place is empty.

    Addresses are written past MuJoCo's bindings: a thread that is on its way through these still finds its function.
    """
    global _theirs, _before, _there, _bound
    if _there == _NOTHING:
        _theirs, _before = mujoco.get_mjcb_control(), [_place(name).value for name in _NAMES]
    wanted = _NOTHING if not (_interpreted or _compiled) else _PYTHON
    if wanted == _PYTHON and not _interpreted and _theirs is None:
        wanted = _C
    if wanted == _there:
        return
    if wanted == _C:
        _write(_native[1], _HUSH[1], None)
    elif wanted == _PYTHON:
        mujoco.set_mjcb_control(_control)
        _bound = True
        _write(_place("mjcb_control").value, _HUSH[1], None)
    else:
        if _bound:
            mujoco.set_mjcb_control(_theirs)
            _bound = False
        _write(*_before)
    _there = wanted


def _write(*addresses: int | None) -> None:
    """Put C functions into MuJoCo's places."""
    for name, address in zip(_NAMES, addresses, strict=True):
        _place(name).value = address


@cache
def _place(name: str) -> ctypes.c_void_p:
    """Where MuJoCo keeps the address of one of its callbacks."""
    (path,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(path)), name)


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
def interpreted(number: int, walk: Interpreted) -> Iterator[None]:
    """Have Python act on a walk by the number in its userdata meanwhile; other threads wait."""
    with _alone():
        with _lock:
            before = _interpreted.get(number)
            _interpreted[number] = walk
            _refresh()
        try:
            _here.walks = getattr(_here, "walks", 0) + 1
            yield
        finally:
            _here.walks -= 1
            with _lock:
                if before is None:
                    del _interpreted[number]
                _refresh()


@contextmanager
def _alone() -> Iterator[None]:
    """Hold `stepping`.

    Raises:
        MjbipedError: Another thread has held it for too long, as one that waits for this thread does.
    """
    if not stepping.acquire(timeout=_LONGEST_WAIT):
        raise MjbipedError(
            "another thread of this process is walking in plain Python, and MuJoCo's callbacks are shared by all "
            "threads; let walks run one after another, or all of them by mjbiped.walk_many"
        )
    try:
        yield
    finally:
        stepping.release()


def walking() -> bool:
    """Whether a walk of this thread is being stepped."""
    return getattr(_here, "walks", 0) > 0


@contextmanager
def python_removed() -> Iterator[None]:
    """Take callbacks in Python away meanwhile, so that MuJoCo can compile a model; walks as machine code go on."""
    with _alone(), _lock:
        names = [name.removeprefix("get_") for name in dir(mujoco) if name.startswith("get_mjcb_")]
        in_python = [_place(name) for name in names if _is_python(getattr(mujoco, f"get_{name}")())]
        standing = [place.value for place in in_python]
        for place in in_python:
            place.value = None
        if _there == _PYTHON and _compiled:
            _place("mjcb_control").value = _native[1]
        try:
            yield
        finally:
            for place, address in zip(in_python, standing, strict=True):
                place.value = address


def _is_python(function: Any) -> bool:
    """Whether a callback is a function in Python, and not one of C's."""
    return function is not None and not hasattr(function, "argtypes")


def _control(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """`mjcb_control` in Python."""
    if model.nuserdata > 1 and data.userdata[0] == MARK:
        walk = _interpreted.get(int(data.userdata[1]))
        if walk is not None:
            if walk.constants.data == data._address:  # not a copy
                step.on_control(walk.constants, data.time)
        elif data.userdata[1] > 0.0 and _native is not None:
            _native[0](model._address, data._address)
        return
    if _theirs is not None:
        _theirs(*((model, data) if _is_python(_theirs) else (model._address, data._address)))


def _hush(message: str) -> None:
    """`mju_user_warning`."""


def addressed(function: Any) -> tuple[Any, int]:
    """A C function of ctypes, and its address."""
    return function, ctypes.cast(function, ctypes.c_void_p).value or 0


_HUSH = addressed(ctypes.CFUNCTYPE(None, ctypes.c_char_p)(_hush))


def require_none() -> None:
    """Refuse to begin many walks where somebody else's callback is installed.

    Raises:
        MjbipedError: It is.
    """
    standing = mujoco.get_mjcb_control() if _there == _NOTHING else _theirs
    if standing is not None:
        raise MjbipedError("another mjcb_control of MuJoCo's is installed; remove it before many walks are begun")
