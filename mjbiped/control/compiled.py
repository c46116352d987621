"""Machine code of a controller's laws, apart from any engine: one calling convention for all that call laws.

An engine compiled around a law has to be compiled again with every other law, which takes ten times as long as the law
itself. So each law becomes C functions, and engines call what stands at the addresses that `CompiledLaw` has:

| function | arguments | returns |
|---|---|---|
| `torque` | int64 record, int64 memory, double t, int64 q, int64 dq, int64 out | nothing |
| `touchdown` | int64 record, int64 memory, int64 q_before, int64 q, int64 dq | nothing |
| `slope_estimate` | int64 record, int64 memory | double |
| `next_discontinuity` | int64 record, int64 memory, double t | double |
| `tick`, `knee_strike` | int64 record, int64 memory, double t, int64 q, int64 dq | nothing |

All integers are addresses of contiguous floats. The record is a header of `HEADER` floats, which has the lengths of all
arrays, and behind it the law's parameters: one machine code serves all gains, gaits and robots of a law. `out` has
places for torques, rates of the states, and `ROOM` floats more. A law that raises an exception sets the record's
`FAILED`, and all torques are NaN from then on.
"""

from __future__ import annotations

import ctypes
import hashlib
import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from importlib import import_module
from numbers import Real
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from mjbiped.control.adapters import LAWS, gives_its_law
from mjbiped.control.controller import ROOM, Controller, Law
from mjbiped.control.scalar_laws import on_arrays
from mjbiped.errors import InputError
from mjbiped.numerics.jit import OPTIONS, c_function, described, prepared, raises, renamed, takes_powers
from mjbiped.numerics.records import WORD, in_one_block

(
    FAILED,  # not zero once a law has raised an exception
    COUNT,  # of the parameters
    MEMORY,  # floats of the memory
    OFFSET,  # of the law's first float in the memory that an engine hands over
    ANGLES,  # of the robot, as many as joints
    VALUES,  # torques and rates of states
    HEADER,
) = range(7)
"""Indices in a record, and the number of them."""

_ADVICE = (
    "A law reads and writes the arrays of floats that it is given, allocates nothing (no list, array or string), and "
    "calls only functions that do the same, of `math` or at the top level of a module. Correct it, or let law() return "
    "None: the walk then runs in plain Python"
)


class LawError(InputError):
    """A controller's laws cannot be compiled; nothing has been computed then."""


class CompiledLaw(NamedTuple):
    """Addresses of a law's C functions and of its record.

    Attributes:
        torque: See this module, as for all of the functions.
        touchdown: 0 never.
        slope_estimate: 0 never.
        next_discontinuity: 0 never.
        record: Address of the header and the parameters.
        values: Zeros, at least as many as `torque` writes torques and rates: a tuple's length is part of its type.
        tick: 0: the law has none.
        knee_strike: 0: the law has none.
    """

    torque: int
    touchdown: int
    slope_estimate: int
    next_discontinuity: int
    record: int
    values: tuple[float, ...]
    tick: int = 0
    knee_strike: int = 0


class MachineCode:
    """The machine code of a law with the parameters of one controller, to be kept while engines call it.

    Attributes:
        law: Addresses, for compiled engines.
        block: The same as a NumPy record, which a function hands on as one address.
    """

    law: CompiledLaw
    block: Any

    def __init__(
        self, law: Law, states: int, memory_size: int, *, room: int = 0, joints: int = 2, idle: int = 0
    ) -> None:
        """Compile the law, or take it from the cache.

        Args:
            law: The controller's.
            states: Number of its integrated states.
            memory_size: Floats of its memory.
            joints: Number of torques, and of angles.
            room: Least number of rates that `values` has room for, so that one engine serves laws with fewer.
            idle: Number of padding states, which stand before the law's own in the memory that an engine hands over and
                which the law does not see; their rates are zero, and a law with them has no states of its own.

        Raises:
            NumbaError: The law cannot be compiled.
        """
        head = 0.0, len(law.parameters), memory_size, idle, joints, joints + states
        self._record = np.array([*head, *law.parameters], dtype=np.float64)
        self._functions = {name: _function(name, each) for name, each in law.functions.items()}  # kept alive
        addresses = {name: function.address for name, function in self._functions.items()}
        values = (0.0,) * (joints + max(idle + states, room))
        self.law = CompiledLaw(record=self._record.ctypes.data, values=values, **addresses)
        self.block = in_one_block(SimpleNamespace(**self.law._asdict()))

    @property
    def failed(self) -> bool:
        """Whether a law has raised an exception; its torques are NaN from then on."""
        return bool(self._record[FAILED])


class CalledMethods:
    """C functions that call a controller's methods in plain Python, to be kept while engines call them.

    Attributes:
        law: Addresses, for compiled engines.
        error: What a method has raised: no exception could pass through C. From then on none is called, and torques are
            zero.
    """

    law: CompiledLaw
    error: BaseException | None = None

    def __init__(self, controller: Controller, *, room: int) -> None:
        """Wrap the methods.

        Args:
            controller: Whose methods they are.
            room: See `MachineCode`.
        """
        self._failed = ctypes.c_double()  # as a record begins
        methods = zip(Law._fields[1:], LAWS, strict=True)
        self._functions = {name: self._behind(name, method, controller) for name, method in methods}  # kept alive
        addresses = {name: ctypes.cast(each, ctypes.c_void_p).value or 0 for name, each in self._functions.items()}
        values = (0.0,) * (len(controller.joints) + max(len(controller.states), room))
        self.law = CompiledLaw(record=ctypes.addressof(self._failed), values=values, **addresses)

    def _behind(self, name: str, method: Callable[..., Any], controller: Controller) -> Any:
        """The C function of a method."""
        number, word, joints = ctypes.c_double, ctypes.c_int64, len(controller.joints)
        memory_of, state_of = number * controller.memory_size, number * joints
        values_of, kinds = number * (joints + len(controller.states)), _TAKEN[name]

        def call(_record: int, memory: int, *given: Any) -> float:
            if self.error is None:
                try:
                    held = memory_of.from_address(memory)
                    own: list[Any] = held[:]
                    state = [
                        each if kind == _TIME else tuple(state_of.from_address(each))
                        for kind, each in zip(kinds, given, strict=True)
                        if kind != _OUT
                    ]
                    found = method(controller, own, *state)
                    held[:] = own
                    if name != "torque":
                        return 0.0 if found is None else float(found)
                    values_of.from_address(given[-1])[:] = found
                    return 0.0
                except BaseException as error:  # an interruption, too
                    self.error, self._failed.value = error, 1.0
            if name == "torque":
                ctypes.memset(given[-1], 0, ctypes.sizeof(values_of))
            return math.nan

        passed = [number if kind == _TIME else word for kind in kinds]
        return ctypes.CFUNCTYPE(number if name in _RETURNING else None, word, word, *passed)(call)


_TIME, _STATE, _OUT = "t", "q", "o"
_TAKEN = {"touchdown": "qqq", "slope_estimate": "", "next_discontinuity": "t", "torque": "tqqo"} | dict.fromkeys(
    ("tick", "knee_strike"), "tqq"
)
"""What a law's functions take beside parameters and memory: a time, arrays with a number for each angle, and `out`."""
_RETURNING = ("slope_estimate", "next_discontinuity")

# in each copy of the functions below the law's function, and `mjbiped.numerics.addresses.numbers`
law: Any = None
numbers: Any = None
_NAN = math.nan


def _torque(record: int, memory: int, t: float, q: int, dq: int, out: int) -> None:
    head = numbers(record, HEADER)
    parameters = numbers(record + WORD * HEADER, int(head[COUNT]))
    own = numbers(memory + WORD * int(head[OFFSET]), int(head[MEMORY]))
    n, values = int(head[ANGLES]), int(head[VALUES])
    given = numbers(out, values + ROOM)
    try:
        law(parameters, own, t, numbers(q, n), numbers(dq, n), given)
    except Exception:  # such as an index out of bounds; it could not pass through C
        head[FAILED] = 1.0
    if head[FAILED] != 0.0:  # be it at a touchdown: the walk goes no further
        for index in range(values):
            given[index] = _NAN


def _touchdown(record: int, memory: int, q_before: int, q: int, dq: int) -> None:
    head = numbers(record, HEADER)
    parameters = numbers(record + WORD * HEADER, int(head[COUNT]))
    own, n = numbers(memory + WORD * int(head[OFFSET]), int(head[MEMORY])), int(head[ANGLES])
    try:
        law(parameters, own, numbers(q_before, n), numbers(q, n), numbers(dq, n))
    except Exception:
        head[FAILED] = 1.0


def _event(record: int, memory: int, t: float, q: int, dq: int) -> None:
    head = numbers(record, HEADER)
    parameters = numbers(record + WORD * HEADER, int(head[COUNT]))
    own, n = numbers(memory + WORD * int(head[OFFSET]), int(head[MEMORY])), int(head[ANGLES])
    try:
        law(parameters, own, t, numbers(q, n), numbers(dq, n))
    except Exception:
        head[FAILED] = 1.0


def _slope_estimate(record: int, memory: int) -> float:
    head, found = numbers(record, HEADER), _NAN
    parameters = numbers(record + WORD * HEADER, int(head[COUNT]))
    try:
        found = float(law(parameters, numbers(memory + WORD * int(head[OFFSET]), int(head[MEMORY]))))
    except Exception:
        head[FAILED] = 1.0
    return found


def _next_discontinuity(record: int, memory: int, t: float) -> float:
    head, found = numbers(record, HEADER), _NAN
    parameters = numbers(record + WORD * HEADER, int(head[COUNT]))
    try:
        found = float(law(parameters, numbers(memory + WORD * int(head[OFFSET]), int(head[MEMORY])), t))
    except Exception:
        head[FAILED] = 1.0
    return found


_OURS = ("mjbiped.controllers.", "controllers.", "mjbiped.control.")  # whose indices tests have checked
_AROUND: tuple[Callable[..., Any], ...] = (_torque, _touchdown, _slope_estimate, _next_discontinuity, _event, _event)


@lru_cache(maxsize=256)
def _function(name: str, function: Callable[..., Any]) -> Any:
    """Compile one of a law's C functions; an unchanged one comes from the cache."""
    from numba import types

    from mjbiped.numerics import addresses

    around = dict(zip(Law._fields[1:], _AROUND, strict=True))[name]
    checked = not function.__module__.startswith(_OURS)
    known = prepared((function,), (function,), checked=checked), described(around)
    digest = hashlib.sha256(repr(known).encode()).hexdigest()
    made = renamed(around, f"{name}_{digest[:16]}", law=function, numbers=addresses.numbers)
    passed = [types.float64 if kind == _TIME else types.int64 for kind in _TAKEN[name]]
    returned = types.float64 if name in _RETURNING else types.void
    return c_function(made, returned(types.int64, types.int64, *passed), **OPTIONS)


def compilable_law(controller: Controller) -> Law | None:
    """Return the law that engines compile for a controller, or None where its methods must be called."""
    law = controller.law() if gives_its_law(controller) else None
    if law is None:
        return None
    law = on_arrays(law)
    return law if can_be_compiled(law) else None


def can_be_compiled(law: Law) -> bool:
    """Whether machine code could do what the law does.

    An exception that it raises would lose its message there, and a record holds only floats.
    """
    given: Any = law.parameters
    if isinstance(given, np.ndarray):
        flat = given.ndim == 1 and given.dtype == np.float64
    else:
        flat = isinstance(given, list | tuple) and all(issubclass(kind, Real) for kind in set(map(type, given)))
    return flat and not raises(tuple(law.functions.values()))


def rounds_alike(law: Law) -> bool:
    """Whether the law makes the same bits interpreted and as machine code: it takes no powers."""
    return not takes_powers(tuple(law.functions.values()))


@contextmanager
def refused_in_words(controller: Controller, law: Law | None) -> Iterator[None]:
    """Explain which law cannot be compiled, why, and where, if the block's compilation fails.

    Args:
        controller: Controller of the laws.
        law: Result of `compilable_law`; None where nothing is compiled.

    Raises:
        LawError: They cannot be compiled. An exception that a running law raised passes unchanged.
    """
    try:
        yield
    except Exception as error:
        if law is None or not isinstance(error, import_module("numba").core.errors.NumbaError):
            raise
        reason = _blame(law) or f"together: {_reason(error)}"
        raise LawError(f"the laws of {type(controller).__name__} cannot be compiled: {reason}. {_ADVICE}") from error


def _blame(law: Law) -> str:
    """Describe the first law that cannot be compiled by itself, and why; empty if all can."""
    numba: Any = import_module("numba")  # slow to import, and without types
    numbers, number = numba.types.Array(numba.types.float64, 1, "C"), numba.types.float64
    for name, function in law.functions.items():
        taken = [number if kind == _TIME else numbers for kind in _TAKEN[name]]
        prepared((function,), (), checked=True)
        alone = numba.njit(_nrt=False)(function)
        try:
            alone.compile((numbers, numbers, *taken))
        except (numba.core.errors.NumbaError, TypeError) as error:  # TypeError: another number of arguments
            return f"{name} ({function.__name__}): {_reason(error)}"
        given = alone.nopython_signatures[0].return_type
        if name in _RETURNING and not isinstance(numba.types.unliteral(given), numba.types.Number):
            return f"{name} ({function.__name__}) returns {given}; expected a float"
        if name not in _RETURNING and given != numba.types.none:
            return f"{name} ({function.__name__}) returns {given}; expected nothing"
    return ""


def _reason(error: Exception) -> str:
    """Return the line of Numba's message that says what is wrong, and the place in the source."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    message = next((line for line in lines if not line.startswith("Failed in")), type(error).__name__).rstrip(".")
    if "NRT required" in message:
        message = "it allocates memory"
    place = re.search(r'File "(?P<file>[^"]+)", line (?P<line>\d+)', str(error)) or re.search(
        r"at (?P<file>\S+) \((?P<line>\d+)\)", str(error)
    )
    return f"{message} (line {place['line']} of {Path(place['file']).name})" if place else message
