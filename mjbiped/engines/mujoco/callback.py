"""`mjcb_control`, which is one for all threads of a process: for whom it stands there, and what stood there before.

Walks as machine code share a C function that finds each of them by its userdata: any number of them go on in any
threads. Where a walk is interpreted, a function in Python stands there, which knows the others, too.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
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
_NAMES = ("mjcb_control", "mju_user_warning")
"""The second hears warnings, which each mjData counts; without a function MuJoCo would write them to a file."""
_theirs: list[Any] = [None, None]  # what somebody else has installed under these names
_clock: Any = (
    None  # somebody's clock in Python, as dm_control's profiling leaves one behind: it takes no lock, so it rests
)
_NOTHING, _PYTHON, _C = range(3)
_there = _NOTHING  # what of ours stands there
_bound = False  # whether MuJoCo's bindings hold functions of ours in Python
_here = threading.local()  # `walks`: number of this thread's that are being stepped


def _refresh() -> None:
    """Put into MuJoCo's places what is needed there now; other threads may be calling it, so that no place is empty."""
    global _theirs, _clock, _there, _bound
    if _there == _NOTHING:
        _theirs, _clock = [mujoco.get_mjcb_control(), mujoco.get_mju_user_warning()], mujoco.get_mjcb_time()
    wanted = _NOTHING if not (_interpreted or _compiled) else _PYTHON
    if wanted == _PYTHON and not _interpreted and _theirs == [None, None]:
        wanted = _C
    if wanted == _there:
        return
    if _clock is not None:
        mujoco.set_mjcb_time(_clock if wanted == _NOTHING else None)
    if wanted == _C:
        _write(_native[1], _HUSH[1])
    elif wanted == _PYTHON:
        _set(_control, _hush)
        _bound = True
    elif _bound:
        _set(*_theirs)
        _bound = False
    else:
        _write(None, None)
    _there = wanted


def _set(*functions: Any) -> None:
    for name, function in zip(_NAMES, functions, strict=True):
        getattr(mujoco, f"set_{name}")(function)


def _write(control: int | None, warning: int | None) -> None:
    """Put C functions into MuJoCo's places, which costs a tenth of `_set`."""
    slots = _slots()
    slots[0].value, slots[1].value = control, warning


@cache
def _slots() -> list[ctypes.c_void_p]:
    (path,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    library = ctypes.CDLL(str(path))
    return [ctypes.c_void_p.in_dll(library, name) for name in _NAMES]


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
    """Take callbacks in Python away meanwhile, so that MuJoCo can compile a model."""
    with _alone(), _lock, ExitStack() as stack:
        for name in dir(mujoco):
            if name.startswith("get_mjcb_"):
                standing, put = getattr(mujoco, name)(), getattr(mujoco, name.replace("get", "set", 1))
                if standing is not None and not hasattr(standing, "argtypes"):
                    put(None)
                    stack.callback(put, standing)
        yield


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
    theirs = _theirs[0]
    if theirs is not None:
        theirs(*((model._address, data._address) if hasattr(theirs, "argtypes") else (model, data)))


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
    standing = mujoco.get_mjcb_control() if _there == _NOTHING else _theirs[0]
    if standing is not None:
        raise MjbipedError("another mjcb_control of MuJoCo's is installed; remove it before many walks are begun")
