"""`mjcb_control`, which is one for all threads of a process: for whom it stands there, and what stood there before.

Walks as machine code share a C function that finds each of them by its userdata: any number of them go on in any
threads. Where a walk is interpreted, a function in Python stands there, which knows the others, too.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
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
_native: Any = None  # the C function, once a walk has needed it
_theirs: dict[str, Any] | None = None  # what somebody else has installed, while ours are there
_standing: dict[str, Any] = {}  # what stands in MuJoCo's places of ours
_NAMES = ("mjcb_control", "mju_user_warning")
_here = threading.local()  # `walks`: number of this thread's that are being stepped


def _refresh() -> None:
    """Put into MuJoCo's places what is needed there now."""
    global _theirs
    wanted: dict[str, Any] | None = None
    if _interpreted or _compiled:
        if _theirs is None:
            _theirs = {name: getattr(mujoco, f"get_{name}")() for name in _NAMES}
            if mujoco.get_mjcb_time() is not None:
                _theirs["mjcb_time"] = mujoco.get_mjcb_time()
        alone = not _interpreted and _theirs["mjcb_control"] is None
        # each mjData counts its own warnings; without a function MuJoCo would write them to a file
        wanted = {"mjcb_control": _native if alone else _control, "mju_user_warning": _hush}
        if "mjcb_time" in _theirs:  # a clock in Python, as dm_control's profiling leaves one behind: it takes no lock
            wanted["mjcb_time"] = None
    elif _theirs is not None:
        wanted, _theirs = _theirs, None
        _standing.clear()
    for name, function in (wanted or {}).items():
        if name not in _standing or _standing[name] is not function:  # else other threads may be calling it now
            getattr(mujoco, f"set_{name}")(function)
            if _theirs is not None:
                _standing[name] = function


@contextmanager
def compiled(native: Any) -> Iterator[None]:
    """Have the C function act on walks as machine code meanwhile; any thread may step them."""
    global _compiled, _native
    with _lock:
        _compiled, _native = _compiled + 1, native
        _refresh()
    try:
        with _walking():
            yield
    finally:
        with _lock:
            _compiled -= 1
            _refresh()


@contextmanager
def interpreted(number: int, walk: Interpreted) -> Iterator[None]:
    """Have Python act on a walk by the number in its userdata meanwhile; other threads wait."""
    with _alone():
        with _lock:
            before = _interpreted.get(number)
            _interpreted[number] = walk
            _refresh()
        try:
            with _walking():
                yield
        finally:
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


@contextmanager
def _walking() -> Iterator[None]:
    """Count a walk of this thread."""
    _here.walks = getattr(_here, "walks", 0) + 1
    try:
        yield
    finally:
        _here.walks -= 1


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
            _native(model._address, data._address)
        return
    theirs = _theirs["mjcb_control"] if _theirs else None
    if theirs is not None:
        theirs(*((model._address, data._address) if hasattr(theirs, "argtypes") else (model, data)))


def _hush(message: str) -> None:
    """`mju_user_warning`."""


def require_none() -> None:
    """Refuse to begin many walks where somebody else's callback is installed.

    Raises:
        MjbipedError: It is.
    """
    standing = _theirs["mjcb_control"] if _theirs is not None else mujoco.get_mjcb_control()
    if standing is not None:
        raise MjbipedError("another mjcb_control of MuJoCo's is installed; remove it before many walks are begun")
