"""MuJoCo's callbacks are globals of the process: who may install them, and for whom they are shared."""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any

import mujoco
import numpy as np

from mjbiped.engines.mujoco.compiled.callbacks import Functions
from mjbiped.engines.mujoco.compiled.layout import library
from mjbiped.errors import MjbipedError

CALLBACKS = ("mjcb_control", "mjcb_sensor", "mjcb_contactfilter")
NO_CALLBACKS = Functions(None, None, None, math.nan)
"""Of compiled walks that need none: they call the stages of MuJoCo's step themselves."""
_ONE_THREAD = threading.RLock()  # whose callbacks are installed
_walking: list[object] = []  # those who installed callbacks of their own, the last one innermost
_shared: Functions | None = None  # compiled callbacks that are installed for walks in any thread
_warnings = 0  # that MuJoCo gave under `Momentary` callbacks
_stepped = threading.local()  # `on_warning`: of the walk that this thread steps under them


def installed() -> dict[str, Any]:
    """What stands there now, by MuJoCo's names."""
    return {name: getattr(mujoco, f"get_{name}")() for name in (*CALLBACKS, "mju_user_warning")}


@contextmanager
def replaced(chosen: Mapping[str, Any]) -> Iterator[None]:
    """Install callbacks, by MuJoCo's names; what stood there comes back."""
    with ExitStack() as stack:
        for name, callback in chosen.items():
            install = getattr(mujoco, f"set_{name}")
            stack.callback(install, getattr(mujoco, f"get_{name}")())
            install(callback)
        yield


@contextmanager
def python_callbacks_removed() -> Iterator[None]:
    """Take MuJoCo's callbacks in Python away meanwhile: its compiler calls them with models that Python cannot hold.

    Compiled ones stay, and must leave alone what is not theirs, as those of `mjbiped.engines.mujoco.compiled.callbacks`
    do.
    """
    names = [name.removeprefix("get_") for name in dir(mujoco) if name.startswith("get_mjcb_")]
    standing = {name: getattr(mujoco, f"get_{name}")() for name in names}
    with replaced({name: None for name, each in standing.items() if each is not None and not is_compiled(each)}):
        yield


@contextmanager
def own_callbacks(owner: object, chosen: dict[str, Any]) -> Iterator[None]:
    """Install callbacks in this thread alone; what stood there comes back.

    Args:
        owner: Counts as walking meanwhile.
        chosen: Callbacks by MuJoCo's names.
    """
    _walking.append(owner)
    try:
        with replaced(chosen):
            yield
    finally:
        _walking.remove(owner)


@contextmanager
def stepped_under_shared(on_warning: Callable[[str], None]) -> Iterator[None]:
    """Say who is listener what MuJoCo warns of in this thread, under `shared_callbacks`."""
    _stepped.on_warning = on_warning
    try:
        yield
    finally:
        _stepped.on_warning = None


def shared() -> Functions | None:
    """The compiled callbacks that are installed for walks in any thread."""
    return _shared


@contextmanager
def shared_callbacks(functions: Functions) -> Iterator[None]:
    """Install compiled callbacks for all simulations that they belong to: any number of threads may step these.

    New models can be compiled meanwhile, unlike under Python's callbacks: what has no record is left alone.

    Raises:
        MjbipedError: Another thread is walking, or something else's callbacks are installed.
    """
    global _shared
    chosen = {name: getattr(functions, name) for name in CALLBACKS}
    with exclusive():
        require_no_callbacks()
        # a clock in Python, as dm_control's profiling sets it, would be taken away by one thread that compiles a model
        # while another one asks it
        with replaced({**chosen, "mju_user_warning": _on_shared_warning, "mjcb_time": None}):
            _shared = functions
            try:
                yield
            finally:
                _shared = None


class Momentary:
    """Compiled callbacks that are installed for a moment, by their pointers; what stood there comes back.

    Far cheaper than `replaced`: environments do this at every step, so that any number of them, and of walks, can take
    turns. Another thread that walks or steps is waited for. MuJoCo's warnings are counted meanwhile, see `warned`.

    Attributes:
        lock: To be held while they stand there.
        words: For compiled code that installs them itself: of each callback, and of that for warnings, the address of
            MuJoCo's pointer, what is to stand there, and room for what stood there.
    """

    def __init__(self, functions: Functions) -> None:
        """Look where MuJoCo's pointers are.

        Raises:
            UnknownLayoutError: MuJoCo's library is not found.
        """
        self.lock = _ONE_THREAD
        self._functions = functions  # to be kept alive
        self._slots = [ctypes.c_void_p.in_dll(library(), name) for name in (*CALLBACKS, "mju_user_warning")]
        pointers = (*(getattr(functions, name) for name in CALLBACKS), _count_warning)
        self._chosen = [ctypes.cast(pointer, ctypes.c_void_p).value or 0 for pointer in pointers]
        addresses = [ctypes.addressof(slot) for slot in self._slots]
        self.words = np.array([[*pair, 0] for pair in zip(addresses, self._chosen, strict=True)], dtype=np.int64)

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Install them, for all threads.

        Raises:
            MjbipedError: Something else's callbacks are installed.
        """
        with self.lock:
            standing = [slot.value or 0 for slot in self._slots]
            for before, own in zip(standing[:-1], self._chosen, strict=False):
                if before not in (0, own):
                    raise self.refusal()
            try:
                for slot, address in zip(self._slots, self._chosen, strict=True):
                    slot.value = address
                yield
            finally:
                for slot, address in zip(self._slots, standing, strict=True):
                    slot.value = address

    def refusal(self) -> MjbipedError:
        """What to raise where something else's callbacks are installed."""
        return MjbipedError(
            "other callbacks of MuJoCo's are installed; remove them before an environment is stepped, or step it "
            "outside of another walk's controller"
        )


def warned() -> int:
    """How many warnings MuJoCo has given under `Momentary` callbacks so far."""
    return _warnings


@ctypes.CFUNCTYPE(None, ctypes.c_char_p)  # type: ignore[untyped-decorator]
def _count_warning(message: bytes) -> None:  # noqa: ARG001 (MuJoCo gives it)
    """`mju_user_warning` there."""
    global _warnings
    _warnings += 1


def require_no_callbacks() -> None:
    """Refuse to begin many walks where something else's callbacks are installed.

    Raises:
        MjbipedError: They are.
    """
    if any(getattr(mujoco, f"get_{name}")() is not None for name in CALLBACKS):
        raise MjbipedError("other callbacks of MuJoCo's are installed; remove them before many walks are begun")


def _on_shared_warning(message: str) -> None:
    """`mju_user_warning` of many walks: MuJoCo calls it in the thread that steps."""
    listener: Callable[[str], None] | None = getattr(_stepped, "on_warning", None)
    if listener is not None:
        listener(message)


@contextmanager
def exclusive() -> Iterator[None]:
    """Keep other threads from building or stepping a walk meanwhile.

    Raises:
        MjbipedError: Another thread does already.
    """
    if not _ONE_THREAD.acquire(blocking=False):
        raise MjbipedError(
            "another thread of this process is walking, and MuJoCo's callbacks are shared by all threads; "
            "let walks run one after another, or all of them by mjbiped.walk_many"
        )
    try:
        yield
    finally:
        _ONE_THREAD.release()


def walking() -> bool:
    """Whether callbacks are installed; under Python's MuJoCo cannot compile a model."""
    return bool(_walking) or _shared is not None


def is_compiled(callback: Any) -> bool:
    """Whether a callback is a C function's pointer of ctypes."""
    return hasattr(callback, "argtypes")
