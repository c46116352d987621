"""MuJoCo's callbacks are globals of the process: what stands there while walks are under way, and for whom.

Walks with compiled callbacks share `callbacks.trampolines`, which find each walk's own functions: any number of them
may be under way, in any threads. Walks with callbacks in Python share a dispatcher in Python. They are made in one
thread at a time, and others wait: while MuJoCo compiles a model, callbacks in Python have to be taken away, for it
calls them with models that Python cannot hold. What somebody else has installed is asked for all other models, and
comes back.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from mjbiped.engines.mujoco.compiled.callbacks import address_of, exchanging, trampolines
from mjbiped.engines.mujoco.compiled.layout import UnknownLayoutError, layout, library
from mjbiped.engines.mujoco.scene import OWNER, RECORDS_SIZE
from mjbiped.errors import MjbipedError
from mjbiped.utils.mujoco import mujoco

CALLBACKS = ("mjcb_control", "mjcb_sensor", "mjcb_contactfilter")
_LONGEST_WAIT = 60.0  # for the interpreted walk of another thread, s: longer ones are compiled
_NAMES = (*CALLBACKS, "mju_user_warning")
_CLOCK = "mjcb_time"
"""Times each stage of a step for `mjData.timer`, a tenth of the step's time: compiled walks are made without it. One in
Python, as dm_control's profiling sets it, is taken away while a model is compiled, too."""
_THEIRS, _TRAMPOLINES, _DISPATCHER, _NOTHING = range(4)  # what can stand in MuJoCo's places


class Driven(Protocol):
    """A walk with callbacks in Python."""

    def on(self, name: str, model: mujoco.MjModel, data: mujoco.MjData, *arguments: int) -> Any:
        """Do what a callback of MuJoCo's, by its name, is to do."""


_lock = threading.RLock()  # held while anything of the following changes
_changed = threading.Condition(_lock)
_compiled = 0  # number of those who need the trampolines
_driven: dict[int, list[Driven]] = {}  # walks in Python by the addresses of their models
_walker: int | None = None  # the thread that walks in Python
_builders = 0  # number of models that are being compiled
_here = _THEIRS
_NONE: dict[str, Any] = dict.fromkeys(_NAMES)
_standing = _NONE  # what somebody else has installed, while something of ours is there
_pointers: Sequence[int | None] = ()  # MuJoCo's, while the trampolines are there
_filled = False  # whether `_fill` put them there
_clock: int | None = None  # MuJoCo's, while it is taken away
_clockless = False
_warnings = 0  # number that MuJoCo has given while ours were there
_heard = threading.local()  # `listeners`: of the warnings of this thread's walks, the innermost last


def _refresh() -> None:
    """Put into MuJoCo's places what is needed there now."""
    global _clock, _clockless
    needed = bool(_compiled or _builders)
    slot = _clock_slot()
    if slot is not None and needed and not _clockless:
        _clock, slot.value, _clockless = slot.value, None, True
    _exchange()
    if slot is not None and not needed and _clockless:
        slot.value, _clockless = _clock, False


def _exchange() -> None:
    """Put the callbacks into MuJoCo's places that are needed there now."""
    global _here, _standing, _pointers
    if _here == _THEIRS:
        _standing = {name: getattr(mujoco, f"get_{name}")() for name in _NAMES}
    if _builders:
        wanted = _TRAMPOLINES if _compiled else _NOTHING
    elif _driven or (_compiled and any(_standing[name] is not None for name in CALLBACKS)):
        wanted = _DISPATCHER
    else:
        wanted = _TRAMPOLINES if _compiled else _THEIRS
    if wanted == _here:
        return
    if _here == _TRAMPOLINES:
        if _filled:
            _note_filled()
        _write_pointers(_pointers)
    elif _here != _THEIRS:
        _set(_standing)
    _here = wanted
    if wanted == _TRAMPOLINES:
        slots, chosen = _slots()
        _pointers = [slot.value for slot in slots]
        _write_pointers(chosen)
    elif wanted == _DISPATCHER:
        _set(dict(zip(_NAMES, (_control, _sensor, _filter, _on_warning), strict=True)))
    elif wanted == _NOTHING:
        _set(dict.fromkeys(CALLBACKS))


def _note_filled() -> None:
    """Note what `_fill` has replaced: nothing but what hears warnings, if anything."""
    global _standing, _pointers, _filled
    _, _, words = _exchange_by()
    _standing = {name: getattr(mujoco, f"get_{name}")() for name in _NAMES}
    _pointers, _filled = [*(None for _ in CALLBACKS), int(words[-1]) or None], False


def _write_pointers(addresses: Sequence[int | None]) -> None:
    for slot, address in zip(_slots()[0], addresses, strict=True):
        slot.value = address


def _set(callbacks: dict[str, Any]) -> None:
    for name, callback in callbacks.items():
        getattr(mujoco, f"set_{name}")(callback)


@lru_cache(maxsize=1)
def _slots() -> tuple[list[ctypes.c_void_p], list[int | None]]:
    """MuJoCo's places, and what stands there in compiled walks.

    Raises:
        UnknownLayoutError: MuJoCo's library is not found.
    """
    chosen: list[int | None] = [*map(address_of, trampolines()[1:]), address_of(_on_c_warning)]
    return [ctypes.c_void_p.in_dll(library(), name) for name in _NAMES], chosen


@lru_cache(maxsize=1)
def _clock_slot() -> ctypes.c_void_p | None:
    """MuJoCo's place for its clock; None where its library is not found."""
    try:
        return ctypes.c_void_p.in_dll(library(), _CLOCK)
    except UnknownLayoutError:
        return None


@lru_cache(maxsize=1)
def _exchange_by() -> tuple[Callable[[int, int], int], int, Any]:
    """What fills and empties MuJoCo's places, the address of the addresses that it needs, and who owns these.

    Raises:
        UnknownLayoutError: MuJoCo's library is not found.
    """
    slots, chosen = _slots()
    clock = ctypes.c_void_p.in_dll(library(), _CLOCK)
    words = np.array([*map(ctypes.addressof, (*slots, clock)), *chosen, 0], dtype=np.int64)
    return exchanging(len(slots)), words.ctypes.data, words


def _fill() -> bool:
    """Put the trampolines where nobody has callbacks, as it mostly is; whether that could be done."""
    global _here, _standing, _clock, _clockless, _filled
    if _here != _THEIRS:
        return False
    exchange, words, _ = _exchange_by()
    clock = exchange(words, -1)
    if clock < 0:
        return False
    _here, _standing, _clock, _clockless, _filled = _TRAMPOLINES, _NONE, clock or None, True, True
    return True


def _empty() -> bool:
    """Undo what `_fill` did; whether that could be done."""
    global _here, _clockless, _filled
    if _here != _TRAMPOLINES or not _filled or _builders or not _clockless:
        return False
    exchange, words, _ = _exchange_by()
    exchange(words, _clock or 0)
    _here, _clockless, _filled = _THEIRS, False, False
    return True


def enter() -> None:
    """Have the trampolines stand in MuJoCo's places, until as many calls of `leave`."""
    global _compiled
    with _lock:  # faster than the condition
        _compiled += 1
        if _compiled == 1 and not _fill():
            _refresh()


def leave() -> None:
    """Need the trampolines no more."""
    global _compiled
    with _lock:  # faster than the condition
        _compiled -= 1
        if _compiled == 0 and not _empty():
            _refresh()


@contextmanager
def compiled() -> Iterator[None]:
    """Have the trampolines stand in MuJoCo's places meanwhile; any thread may step compiled walks."""
    enter()
    try:
        yield
    finally:
        leave()


@contextmanager
def in_python(walk: Driven, address: int) -> Iterator[None]:
    """Have callbacks in Python act on a walk's model, by its address.

    Raises:
        MjbipedError: Another thread is walking in Python, and does not end.
    """
    global _walker
    with _changed:
        _wait_for_another_thread()
        _changed.wait_for(lambda: not _builders)  # some milliseconds
        _walker = threading.get_ident()
        _driven.setdefault(address, []).append(walk)
        _refresh()
    try:
        yield
    finally:
        with _changed:
            _driven[address].remove(walk)
            if not _driven[address]:
                del _driven[address]
            if not _driven:
                _walker = None
            _refresh()
            _changed.notify_all()


@contextmanager
def python_callbacks_removed() -> Iterator[None]:
    """Take MuJoCo's callbacks in Python away meanwhile, so that it can compile a model.

    The trampolines stay for those who need them.

    Raises:
        MjbipedError: Another thread is walking in Python, and does not end.
    """
    global _builders
    with _changed:
        _wait_for_another_thread()
        _builders += 1
        _refresh()
    names = [name.removeprefix("get_") for name in dir(mujoco) if name.startswith("get_mjcb_")]
    away = CALLBACKS if _clock_slot() is None else (*CALLBACKS, _CLOCK)
    others = {name: getattr(mujoco, f"get_{name}")() for name in names if name not in away}
    others = {name: each for name, each in others.items() if each is not None and not hasattr(each, "argtypes")}
    try:
        _set(dict.fromkeys(others))
        yield
    finally:
        _set(others)
        with _changed:
            _builders -= 1
            _refresh()
            _changed.notify_all()


@lru_cache(maxsize=1)
def learn_layout() -> None:
    """Let MuJoCo compile the models that show its layout, which it cannot beside callbacks in Python.

    Raises:
        UnknownLayoutError: The layout is not understood.
        MjbipedError: Another thread is walking in Python, and does not end.
    """
    with python_callbacks_removed():
        layout()


def _wait_for_another_thread() -> None:
    if not _changed.wait_for(lambda: _walker in (None, threading.get_ident()), _LONGEST_WAIT):
        raise MjbipedError(
            "another thread of this process is walking with callbacks in Python, and MuJoCo's callbacks are "
            "shared by all threads; let walks run one after another, or all of them by mjbiped.walk_many"
        )


def _pass_on(name: str, model: mujoco.MjModel, data: mujoco.MjData, *arguments: int) -> Any:
    """Hand a callback to the walk in Python of this model, to the trampoline, or to who was there before."""
    walks = _driven.get(model._address)
    if walks:
        return walks[-1].on(name, model, data, *arguments)
    if model.nnumericdata >= RECORDS_SIZE and model.numeric_data[OWNER] == model._address:
        return getattr(trampolines(), name)(model._address, data._address, *arguments)
    before = _standing.get(name)
    if before is None:
        return None
    if hasattr(before, "argtypes"):
        return before(model._address, data._address, *arguments)
    return before(model, data, *arguments)


def _control(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    _pass_on("mjcb_control", model, data)


def _sensor(model: mujoco.MjModel, data: mujoco.MjData, stage: int) -> None:
    _pass_on("mjcb_sensor", model, data, stage)


def _filter(model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> int:
    return int(_pass_on("mjcb_contactfilter", model, data, first, second) or 0)


def _on_warning(message: str) -> None:
    """`mju_user_warning`: MuJoCo calls it in the thread that steps."""
    global _warnings
    _warnings += 1
    listeners: list[Callable[[str], None]] = getattr(_heard, "listeners", [])
    if listeners:
        listeners[-1](message)


@ctypes.CFUNCTYPE(None, ctypes.c_char_p)  # type: ignore[untyped-decorator]
def _on_c_warning(message: bytes) -> None:
    _on_warning(message.decode(errors="replace"))


@contextmanager
def heard_by(listener: Callable[[str], None]) -> Iterator[None]:
    """Let MuJoCo's warnings in this thread be told to a listener, where it would write them to the terminal."""
    listeners = _heard.__dict__.setdefault("listeners", [])
    listeners.append(listener)
    try:
        yield
    finally:
        listeners.remove(listener)


def walking() -> bool:
    """Whether a walk is under way in this thread."""
    return bool(getattr(_heard, "listeners", []))


def warned() -> int:
    """Number of warnings that MuJoCo has given under our callbacks so far."""
    return _warnings


def require_no_callbacks() -> None:
    """Refuse to begin many walks where somebody else's callbacks are installed.

    Raises:
        MjbipedError: They are.
    """
    with _changed:
        standing = _standing if _here != _THEIRS else {name: getattr(mujoco, f"get_{name}")() for name in CALLBACKS}
        if any(standing.get(name) is not None for name in CALLBACKS):
            raise MjbipedError("other callbacks of MuJoCo's are installed; remove them before many walks are begun")
