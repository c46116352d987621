"""MuJoCo's callbacks are globals of the process: who may install them, and for whom they are shared."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any

import mujoco

from mjbiped.engines.mujoco.compiled.callbacks import Functions
from mjbiped.errors import MjbipedError

CALLBACKS = ("mjcb_control", "mjcb_sensor", "mjcb_contactfilter")
_ONE_THREAD = threading.RLock()  # whose callbacks are installed
_walking: list[object] = []  # those who installed callbacks of their own, the last one innermost
_shared: Functions | None = None  # compiled callbacks that are installed for walks in any thread
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
        with replaced({**chosen, "mju_user_warning": _on_shared_warning}):
            _shared = functions
            try:
                yield
            finally:
                _shared = None


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
