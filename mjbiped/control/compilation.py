"""Gives a controller's laws addresses, apart from any engine; see `mjbiped.control.machine_code`."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from functools import lru_cache, partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from mjbiped.control.adapters import LAWS, gives_its_law
from mjbiped.control.controller import Controller, Law
from mjbiped.numerics.jit import (
    CALLED_WITHIN,
    LAW_OPTIONS,
    c_function,
    from_source,
    jitted,
    kept_apart,
    raises,
    takes_powers,
)
from mjbiped.numerics.records import WORD, NotPackableError, Packer, in_one_block

if TYPE_CHECKING:
    from mjbiped.control.machine_code import CompiledLaw

_FAILED = 0  # index in a law's record: not zero once a law has raised an exception


class MachineCode:
    """The machine code of a law with the parameters of one controller, to be kept while engines call it.

    Attributes:
        law: Addresses, for compiled engines.
        block: The same as a record, which a function hands on as one address.
    """

    law: CompiledLaw
    block: Any

    def __init__(
        self,
        law: Law,
        states: int,
        memory_size: int,
        *,
        room: int = 0,
        joints: int = 2,
        idle: int = 0,
    ) -> None:
        """Compile the law, or take it from the cache.

        Args:
            law: The controller's.
            states: Number of its integrated states.
            memory_size: Floats of its memory.
            joints: Number of torques, and of angles.
            room: Least number of rates that `values` has room for, so that one engine serves laws with fewer.
            idle: Number of padding states, which stand before the law's own in the memory that an engine hands over and
                which the law does not see: `torque` gives zeros for their rates, before those of its own states.

        Raises:
            NotPackableError: `can_be_compiled` says no.
            NumbaError: The law cannot be compiled.
        """
        from mjbiped.control.machine_code import CompiledLaw

        packer = Packer()
        packer.add(0.0)  # _FAILED
        made = packer.add(law.parameters)
        self._record = packer.record()
        kind = (made, tuple(packer.classes.items()), joints, states, memory_size, idle)
        self._functions = {name: _function(name, each, *kind) for name, each in law.functions.items()}
        self.law = CompiledLaw(
            **{name: function.address for name, function in self._functions.items()},
            record=self._record.ctypes.data,
            values=(0.0,) * (joints + max(idle + states, room)),
        )
        self.block = in_one_block(SimpleNamespace(**self.law._asdict()))

    @property
    def failed(self) -> bool:
        """Whether a law has raised an exception; its torques are NaN from then on."""
        return bool(self._record[_FAILED])


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
        from mjbiped.control.machine_code import CompiledLaw

        self._failed = ctypes.c_double()  # as a record begins with `_FAILED`
        functions = {
            name: self._behind(name, partial(method, controller), controller)
            for name, method in zip(Law._fields[1:], LAWS, strict=True)
        }
        self._functions = functions  # to be kept alive
        self.law = CompiledLaw(
            **{name: ctypes.cast(function, ctypes.c_void_p).value or 0 for name, function in functions.items()},
            record=ctypes.addressof(self._failed),
            values=(0.0,) * (len(controller.joints) + max(len(controller.states), room)),
        )

    def _behind(self, name: str, method: Callable[..., Any], controller: Controller) -> Any:
        """The C function of a method, with the arguments that `CompiledLaw` says."""
        number, word, joints = ctypes.c_double, ctypes.c_int64, len(controller.joints)
        memory_of, values_of = number * controller.memory_size, number * (joints + len(controller.states))
        times = 0 if name in ("touchdown", "slope_estimate") else 1
        count = floats_taken(name, joints)
        groups = [slice(times + first, times + first + joints) for first in range(0, count - times, joints or 1)]

        def call(_record: int, memory: int, *given: Any) -> float:
            if self.error is None:
                try:
                    held = memory_of.from_address(memory)
                    own: list[Any] = held[:]
                    found = method(own, *given[:times], *(given[group] for group in groups))
                    held[:] = own
                    if name != "torque":
                        return 0.0 if found is None else float(found)
                    values_of.from_address(given[count])[:] = found
                    return 0.0
                except BaseException as error:  # an interruption, too
                    self.error, self._failed.value = error, 1.0
            if name == "torque":
                ctypes.memset(given[count], 0, ctypes.sizeof(values_of))
            return math.nan

        asked = name in ("slope_estimate", "next_discontinuity")
        passed = [number] * (1 if asked else count) + [word] * (name == "torque")
        return ctypes.CFUNCTYPE(number if asked else None, word, word, *passed)(call)


def compilable_law(controller: Controller) -> Law | None:
    """The law that engines compile for a controller, or None where its methods must be called."""
    law = controller.law() if gives_its_law(controller) else None
    return law if law is not None and can_be_compiled(law) else None


def can_be_compiled(law: Law) -> bool:
    """Whether machine code could do what the law does.

    An exception that it raises would lose its message there, and a record holds only numbers, arrays of floats, and
    tuples of these.
    """
    try:
        Packer().add(law.parameters)
    except NotPackableError:
        return False
    return not raises(tuple(law.functions.values()))


def rounds_alike(law: Law) -> bool:
    """Whether the law makes the same bits interpreted and as machine code: it takes no powers."""
    return not takes_powers(tuple(law.functions.values()))


def shape_of(law: Law) -> str:
    """What machine code depends on in the parameters of a law: how they are nested, not their values."""
    packer = Packer()
    return repr((packer.add(law.parameters), _kinds(tuple(packer.classes.items()))))


def floats_taken(name: str, joints: int) -> int:
    """How many floats one of a law's functions takes beside parameters and memory."""
    return {"touchdown": 3 * joints, "slope_estimate": 0, "next_discontinuity": 1}.get(name, 1 + 2 * joints)


@lru_cache(maxsize=256)
def _function(
    name: str,
    law: Callable[..., Any],
    made: str,
    classes: tuple[tuple[str, type], ...],
    joints: int,
    states: int,
    memory_size: int,
    idle: int,
) -> Any:
    """Compile one of a law's C functions for one kind of parameters; unchanged functions come from the cache."""
    import numba

    from mjbiped.numerics import addresses

    values, q, dq = joints + states, _numbered("q", joints), _numbered("dq", joints)
    given = [f"value_{index}" for index in range(values)]
    values_of = ", ".join(given) + "," * (values == 1)  # unpacked: their number is looked at
    given[joints:joints] = ["0.0"] * idle
    written = "; ".join(f"o[{index}] = float({value})" for index, value in enumerate(given))
    memory = f"numbers(m + {WORD * idle}, {memory_size})" if idle else f"numbers(m, {memory_size})"
    state, postures = f"t, {q}, {dq}", f"{_numbered('before', joints)}, {q}, {dq}"
    taken = {"touchdown": postures, "slope_estimate": "", "next_discontinuity": "t"}.get(name, state)
    call = f"law(parameters(record), {memory}, {taken})"
    types: Any = numba.types
    word, number, returned = types.int64, types.float64, types.void
    arguments, before, after = taken or "t", "pass", "pass"
    passed = [number] * floats_taken(name, joints)
    if name == "torque":
        arguments, before = f"{state}, out", f"o = numbers(out, {len(given)})"
        call = f"{values_of} = {call}; {written}"
        # once a law has failed, be it at a touchdown, no torque is a number: the walk goes no further
        after = f"if numbers(record, 1)[{_FAILED}] != 0.0: o[:] = NAN"
        passed.append(word)
    elif name in ("slope_estimate", "next_discontinuity"):
        before, call, after, returned, passed = "x = NAN", f"x = float({call})", "return x", number, [number]
    made_law, digest = kept_apart(law, _strange(classes))
    source = f"""def {name}(record, m, {arguments}):
    {before}
    try:
        {call}
    except Exception:  # such as an index into a tuple; it could not pass through C
        numbers(record, 1)[{_FAILED}] = 1.0
    {after}
"""
    space: dict[str, Any] = {
        "NAN": float("nan"),
        "numbers": addresses.numbers,
        "law": made_law,
        "parameters": unpacking(made, classes),
    }
    signature = returned(word, word, *passed)
    known = (digest, made, _kinds(classes))
    return from_source(partial(c_function, signature=signature, **LAW_OPTIONS), name, source, space, known)


def _numbered(name: str, count: int) -> str:
    """Names of one parameter for each of the robot's angles, separated by commas."""
    return ", ".join(f"{name}{index + 1}" for index in range(count))


@lru_cache(maxsize=256)
def unpacking(made: str, classes: tuple[tuple[str, type], ...]) -> Any:
    """Compile the function that reads a law's parameters from the address of their record."""
    from mjbiped.numerics import addresses

    source = f"""def parameters(record):
    p = numbers(record, {made.count("p[") + 1})
    return {made}
"""
    space = {"numbers": addresses.numbers, "array": addresses.array, **dict(classes)}
    return from_source(partial(jitted, **CALLED_WITHIN), "parameters", source, space, _kinds(classes))


def _kinds(classes: tuple[tuple[str, type], ...]) -> list[tuple[str, str, Any]]:
    """Modules, names and fields of the classes of parameters, by which compiled code is told apart."""
    return [(kind.__module__, kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes]


def _strange(classes: tuple[tuple[str, type], ...]) -> tuple[str, ...]:
    """Names of the classes that a program without the user's module cannot import when it reads the cache."""
    names = (f"{kind.__module__}.{kind.__qualname__}" for _, kind in classes)
    return tuple(name for name in names if not name.startswith(("mjbiped.", "controllers.")))
