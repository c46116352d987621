"""`mjcb_control`, MuJoCo's one callback for all threads of a process, and the physics step as machine code.

MuJoCo calls a C function, which finds a walk by the address of its mjData. For walks in machine code this function is
machine code with a table of the walks. While a walk is interpreted, a function that calls Python is installed in front
of it. Calls with an mjData of no walk are passed on to the callback that was installed before.

`advancing` returns the physics step as machine code.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Protocol, TypeAlias
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco import step
from mjbiped.engines.mujoco.constants import constants_at
from mjbiped.numerics.blocks import call, numbers
from mjbiped.utils.mujoco import mujoco


class Interpreted(Protocol):
    """A walk in plain Python."""

    def on_control(self) -> None:
        """Act for `mjcb_control`; raises nothing, as no exception could pass through C."""


Native: TypeAlias = tuple[Callable[[int, int], object], int]
"""A C function of ctypes, and its address."""

FOREIGN, FARTHEST, PAIRS = range(3)
PLACES = 1 << 14  # for walks in machine code
table = np.zeros(PAIRS + 2 * PLACES, dtype=np.int64)
"""For machine code: the address of another program's `mjcb_control`, the greatest distance of a walk from its place in
the table, and pairs of addresses: an mjData, and the `Constants` of its walk."""

_lock = threading.RLock()  # held while anything of the following changes; collected walks may take it again
_interpreted: WeakValueDictionary[int, Interpreted] = WeakValueDictionary()  # by the addresses of their data
_needed = {False: 0, True: 0}  # how often the function in Python is needed, and the machine code
_native: Native | None = None  # that machine code and its address, once a walk has needed it
_ours: Native | None = None  # which of them stands there
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


def _library() -> Path:
    """MuJoCo's library, which Python's bindings have loaded."""
    (path,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    return path


@cache
def _slot(name: str) -> ctypes.c_void_p:
    """MuJoCo's place for a callback, by its name in C."""
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(_library())), name)


def enter(native: Native | None) -> None:
    """Have our callback act on walks, in any threads, until as many calls of `leave`.

    Args:
        native: `control_callback()` for walks in machine code; None for one in plain Python.
    """
    global _native
    with _lock:
        _native = native or _native
        _needed[native is not None] += 1
        _refresh()
    _here.walks = getattr(_here, "walks", 0) + 1


def leave(native: Native | None) -> None:
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
    """Remove Python callbacks of other programs: MuJoCo's compiler steps models that Python cannot hold."""
    with _lock:
        # in the places of our callbacks MuJoCo's bindings still report the callbacks from before
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


def _addressed(function: Any) -> Native:
    """A C function of ctypes, and its address."""
    return function, ctypes.cast(function, ctypes.c_void_p).value or 0


_CONTROL = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64)
_PYTHON = _addressed(_CONTROL(_control))
_HUSH = _addressed(ctypes.CFUNCTYPE(None, ctypes.c_char_p)(_hush))


TABLE = "mjbiped_walks"
_STAGES = (
    *("mj_checkPos", "mj_checkVel", "mj_fwdPosition", "mj_sensorPos", "mj_fwdVelocity", "mj_sensorVel"),
    *("mj_forwardSkip", "mj_checkAcc", "mj_Euler"),
)


@cache
def define_stages() -> None:
    """Let machine code call MuJoCo's stages by their names, in the library that Python's bindings have loaded."""
    from llvmlite import binding  # Numba's: import it where something is compiled, not before

    from mjbiped.numerics import machine

    ir, kind = machine.ir, machine.types.Array(machine.types.int64, 1, "C")

    def calling(name: str) -> machine.Generate:
        """Generate calls of one of MuJoCo's functions with the addresses of model and data, and integers."""

        def generate(context: Any, builder: Any, _signature: object, arguments: machine.Values) -> Any:
            passed = [*arguments[:2], *(builder.trunc(each, ir.IntType(32)) for each in arguments[2:])]
            signature = ir.FunctionType(ir.VoidType(), [each.type for each in passed])
            builder.call(machine.cgutils.get_or_insert_function(builder.module, signature, name), passed)
            return context.get_dummy_value()

        return generate

    def named_table(context: Any, builder: Any, _signature: object, _arguments: object) -> Any:
        """Generate an array of what is called `TABLE`."""
        size = context.get_constant(machine.types.intp, len(table))
        named = machine.cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), TABLE)
        return machine.owning_nothing(context, builder, kind, builder.ptrtoint(named, ir.IntType(64)), size)

    binding.load_library_permanently(str(_library()))
    binding.add_symbol(TABLE, table.ctypes.data)
    for name in _STAGES:
        machine.defined(getattr(mujoco, name), lambda *_: machine.types.void, calling(name))
    machine.defined(walks, lambda *_: kind, named_table)


def advance(constants: int, model: int, data: int, steps: int, until: float) -> int:
    """`step.advance` by addresses."""
    return step.advance(constants_at(constants, 0), model, data, steps, until)


@cache
def advancing() -> Callable[..., int]:
    """`advance` as machine code."""
    from mjbiped.numerics import machine

    define_stages()
    made: Callable[..., int] = machine.compiled(advance, "int64(int64, int64, int64, int64, float64)")
    return made


def walks() -> NDArray[np.int64]:
    """`callback.table`; in machine code what is called `TABLE`, as what is kept on disk needs."""
    return table


def control_of(model: int, data: int) -> None:
    """`mjcb_control`, by addresses."""
    entries, first = walks(), place_of(data)
    for far in range(entries[FARTHEST] + 1):
        entry = PAIRS + 2 * ((first + far) % PLACES)
        if entries[entry] == data:
            c = constants_at(entries[entry + 1], 0)
            step.on_control(c, numbers(c.time, 1)[0])
            return
    if entries[FOREIGN] != 0:
        call(entries[FOREIGN], model, data)


@cache
def control_callback() -> Native:
    """`mjcb_control` as a C function, and its address, for all walks in machine code."""
    from mjbiped.numerics import machine

    define_stages()
    return _addressed(machine.compiled(control_of, "void(int64, int64)", for_c=True).ctypes)
