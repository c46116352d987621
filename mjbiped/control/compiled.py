"""Machine code of a controller's laws, apart from any engine: one calling convention for all that call laws.

Compiling an engine together with each law would take ten times as long as compiling the law. So each law becomes C
functions, whose addresses a `Law` holds and engines call:

| function | arguments | returns |
|---|---|---|
| `torque` | int64 parameters, int64 memory, double t, int64 q, int64 dq, int64 out | nothing |
| `touchdown` | int64 parameters, int64 memory, int64 q_before, int64 q, int64 dq | nothing |
| `slope_estimate` | int64 parameters, int64 memory | double |
| `next_discontinuity` | int64 parameters, int64 memory, double t | double |
| `tick`, `knee_strike` | int64 parameters, int64 memory, double t, int64 q, int64 dq | nothing |

`parameters` is the address of a `Head`, which has the lengths of all arrays; the other integers are addresses of
contiguous floats. So one machine code serves all gains, gaits and robots of a law. `out` holds torques, rates of the
states, and `ROOM` further floats. A law that raises an exception sets `Head.failed`; all later torques are NaN.
"""

from __future__ import annotations

import ctypes
import math
import re
from functools import cache, lru_cache
from importlib import import_module
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.control.controller import ROOM, Controller, Law
from mjbiped.control.functions import in_python, law_of
from mjbiped.errors import InputError
from mjbiped.numerics.blocks import Block, numbers, packed, reader
from mjbiped.numerics.cache import Function, raises, takes_powers

_ADVICE = (
    "A law reads and writes the arrays of floats that it is given, allocates nothing (no list, array or string), and "
    "calls only functions that do the same, of `math` or at the top level of a module. Correct it, or let law() return "
    "None: the walk then runs in plain Python"
)
_OURS = ("mjbiped.", "controllers.")  # tests check the indices of these packages; machine code need not


class LawError(InputError):
    """A controller's laws cannot be compiled; nothing has been computed then."""


class Head(Block):
    """The block at the address of a law's parameters.

    Attributes:
        failed: Not zero once a function has raised an exception.
        parameters: Address of the parameters.
        length: Number of parameters; 0 for parameters in one block.
        memory: Number of floats in the memory.
        angles: Number of the robot's angles, which is also that of its joints.
        values: Number of torques and rates of states.
    """


_head_at = reader(Head)
_block_at: Any = cache(reader)


class MachineCode:
    """The machine code of a law with the parameters of one controller, to be kept while engines call it.

    Attributes:
        law: Addresses, for compiled engines.
    """

    law: Law

    def __init__(self, controller: Controller, law: Law) -> None:
        """Compile the law, or take it from the cache.

        Args:
            controller: The controller.
            law: Its `compilable_law`.

        Raises:
            LawError: The law cannot be compiled.
        """
        given: Any = law.parameters
        self._inner = None if controller.inner is None else as_machine_code(controller.inner)
        if self._inner is not None:
            given = given._replace(inner=[self._inner.law])
        if hasattr(given, "_fields"):
            (values, kept), read, length = packed(given), _block_at(type(given)), 0
        else:
            values, kept, read, length = np.array(given, dtype=np.float64), [], numbers, len(given)
        joints, memory = len(controller.joints), controller.memory_size
        sizes = {"length": length, "memory": memory, "angles": joints, "values": joints + len(controller.states)}
        self._head, _ = packed(Head(failed=0.0, parameters=values, **sizes))
        self._kept: list[object] = [values, kept]
        addresses: Any = {"tick": 0, "parameters": self._head.ctypes.data}
        for name, function in law.functions.items():
            try:
                code = _function(name, function, read)
            except import_module("numba").core.errors.NumbaError as error:
                reason = f"{name} ({function.__name__}){_reason(name, function, error)}. {_ADVICE}"
                raise LawError(f"the laws of {type(controller).__name__} cannot be compiled: {reason}") from error
            self._kept.append(code)
            addresses[name] = code.address
        self.law = Law(**addresses)

    @property
    def failed(self) -> bool:
        """Whether a law has raised an exception; its torques are NaN from then on."""
        return bool(self._head["failed"][0]) or (self._inner is not None and self._inner.failed)


class CalledMethods:
    """C functions that call a controller's functions in plain Python, to be kept while engines call them.

    Attributes:
        law: Addresses, for compiled engines.
        error: Exception that a method has raised, kept because exceptions cannot pass through C. After it no method is
            called, and torques are zero.
    """

    law: Law
    error: BaseException | None = None

    def __init__(self, controller: Controller) -> None:
        """Wrap the functions of a controller."""
        self._failed = ctypes.c_double()  # the first field of a `Head`
        law = in_python(controller)
        self._kept = {name: self._behind(name, each, law, controller) for name, each in law.functions.items()}
        addresses: Any = {name: ctypes.cast(each, ctypes.c_void_p).value for name, each in self._kept.items()}
        self.law = Law(**{"tick": 0, "parameters": ctypes.addressof(self._failed)} | addresses)

    @property
    def failed(self) -> bool:
        """Whether a method has raised an exception."""
        return self.error is not None

    def raised(self) -> BaseException | None:
        """Return and clear the exception that a method has raised; methods are then called again."""
        error, self.error, self._failed.value = self.error, None, 0.0
        return error

    def _behind(self, name: str, function: Function, law: Law, controller: Controller) -> Any:
        """Wrap a function as a C function that works on the engine's arrays, without copies."""
        number, word, n = ctypes.c_double, ctypes.c_int64, len(controller.joints)
        count, memory_of = n + len(controller.states), number * controller.memory_size
        sizes = {"a": n, "o": count + ROOM}
        kinds = [number * sizes[kind] if kind in sizes else None for kind in _TAKEN[name]]

        def call(_parameters: int, memory: int, *given: Any) -> float:
            taken = [each if kind is None else kind.from_address(each) for kind, each in zip(kinds, given, strict=True)]
            if self.error is None:
                try:
                    found = function(law.parameters, memory_of.from_address(memory), *taken)
                    return 0.0 if found is None else float(found)
                except BaseException as error:  # an interruption, too
                    self.error, self._failed.value = error, 1.0
            if name == "torque":
                taken[-1][:count] = [0.0] * count
            return math.nan

        passed = [number if kind is None else word for kind in kinds]
        return ctypes.CFUNCTYPE(number if name in _RETURNING else None, word, word, *passed)(call)


def as_machine_code(controller: Controller) -> MachineCode | CalledMethods:
    """A controller's laws as machine code, or C functions that call its methods.

    Raises:
        LawError: The laws cannot be compiled.
    """
    law = compilable_law(controller)
    return CalledMethods(controller) if law is None else MachineCode(controller, law)


_TAKEN = {"touchdown": "aaa", "slope_estimate": "", "next_discontinuity": "t", "torque": "taao"}
_TAKEN |= {"tick": "taa", "knee_strike": "taa"}
"""Arguments of a law's functions after parameters and memory: t time, a angles or rates, o `out`."""
_RETURNING = ("slope_estimate", "next_discontinuity")


def _for_c(name: str, law: Function, read: Function) -> Function:
    """Wrap one of a law's functions as a function of its arrays' addresses."""
    nothing = math.nan if name in _RETURNING else None

    def call(head: Head, memory: int, *given: object) -> float | None:
        found = nothing
        arguments = (read(head.parameters, head.length), numbers(memory, head.memory), *given)
        try:
            found = law(*arguments)
        except Exception:  # such as an index out of bounds; exceptions cannot pass through C
            head.failed = 1.0
        return found

    def torque(parameters: int, memory: int, t: float, q: int, dq: int, out: int) -> None:
        head = _head_at(parameters, 0)
        n, values = head.angles, numbers(out, head.values + ROOM)
        call(head, memory, t, numbers(q, n), numbers(dq, n), values)
        if head.failed != 0.0:  # now or in an earlier call: NaN ends the walk
            for index in range(head.values):
                values[index] = math.nan

    def touchdown(parameters: int, memory: int, q_before: int, q: int, dq: int) -> None:
        head, n = _head_at(parameters, 0), _head_at(parameters, 0).angles
        call(head, memory, numbers(q_before, n), numbers(q, n), numbers(dq, n))

    def timed(parameters: int, memory: int, t: float, q: int, dq: int) -> None:
        head, n = _head_at(parameters, 0), _head_at(parameters, 0).angles
        call(head, memory, t, numbers(q, n), numbers(dq, n))

    def slope_estimate(parameters: int, memory: int) -> Any:
        return call(_head_at(parameters, 0), memory)

    def next_discontinuity(parameters: int, memory: int, t: float) -> Any:
        return call(_head_at(parameters, 0), memory, t)

    found = {each.__name__: each for each in (torque, touchdown, slope_estimate, next_discontinuity)}
    return found.get(name, timed)


@lru_cache(maxsize=256)
def _function(name: str, function: Function, read: Function) -> Any:
    """Compile one of a law's C functions; an unchanged one comes from the cache."""
    from mjbiped.numerics.machine import compiled

    passed = ["float64" if kind == "t" else "int64" for kind in _TAKEN[name]]
    signature = f"{'float64' if name in _RETURNING else 'void'}({', '.join(['int64', 'int64', *passed])})"
    ours = function.__module__.startswith(_OURS)
    return compiled(_for_c(name, function, read), signature, for_c=True, checked=not ours)


def compilable_law(controller: Controller) -> Law | None:
    """Return the law that engines compile for a controller, or None where its methods must be called."""
    if controller.inner is not None and compilable_law(controller.inner) is None:
        return None
    law = law_of(controller)
    return law if law is not None and can_be_compiled(law) else None


def can_be_compiled(law: Law) -> bool:
    """Whether machine code could do what the law does.

    Machine code takes parameters that are floats or one block, and would drop the message of an exception.
    """
    given: Any = law.parameters
    flat = isinstance(given, list | tuple | np.ndarray) and all(issubclass(each, Real) for each in {*map(type, given)})
    return (flat or hasattr(given, "_fields")) and not raises(tuple(law.functions.values()))


def rounds_alike(law: Law) -> bool:
    """Whether the law makes the same bits interpreted and as machine code: it takes no powers."""
    return not takes_powers(tuple(law.functions.values()))


def _reason(name: str, function: Function, error: Exception) -> str:
    """Describe why a law cannot be compiled: Numba's message for the law alone, and the line of the source."""
    numba: Any = import_module("numba")  # slow to import, and without types
    array, number = numba.types.Array(numba.types.float64, 1, "C"), numba.types.float64
    alone = numba.njit(_nrt=False)(function)
    try:
        alone.compile((array, array, *(number if kind == "t" else array for kind in _TAKEN[name])))
    except (numba.core.errors.NumbaError, TypeError) as found:  # TypeError: another number of arguments
        error = found
    else:
        if name in _RETURNING:
            return f" returns {alone.nopython_signatures[0].return_type}; expected a float"
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    message = next((line for line in lines if not line.startswith("Failed in")), type(error).__name__).rstrip(".")
    if "NRT required" in message:
        message = "it allocates memory"
    place = re.search(r'(?:File "|at )([^"\n]+?)"?(?:, line | \()(\d+)', str(error))
    return f": {message} (line {place[2]} of {Path(place[1]).name})" if place else f": {message}"
