"""Compiles a controller's laws, by themselves; see `mjbiped.control.machine_code`."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

from mjbiped.control.adapters import gives_its_law
from mjbiped.control.controller import Controller, Law
from mjbiped.numerics.jit import c_function, called_within, from_source, jitted, kept_apart, options, raises
from mjbiped.numerics.records import WORD, NotPackableError, Packer

if TYPE_CHECKING:
    from mjbiped.control.machine_code import CompiledLaw

_FAILED = 0  # index in a law's record: not zero once a law has raised an exception


class MachineCode:
    """The machine code of a law with the parameters of one controller, to be kept while engines call it.

    Attributes:
        law: Addresses, for compiled engines.
    """

    law: CompiledLaw

    def __init__(
        self,
        law: Law,
        states: int,
        memory_size: int,
        *,
        contract: bool,
        room: int = 0,
        joints: int = 2,
        idle: int = 0,
    ) -> None:
        """Compile the law, or take it from the cache.

        Args:
            law: The controller's.
            states: Number of its integrated states.
            memory_size: Floats of its memory.
            contract: Whether products and sums may be made in one operation, with one rounding: faster, and not bitwise
                what plain Python computes.
            joints: Number of torques, and of angles.
            room: So many rates `values` has room for at least, that one engine may serve laws with fewer.
            idle: So many numbers stand before the law's own in the memory that an engine hands over, states that the
                law knows nothing of: `torque` gives zeros for their rates, before those of its own states.

        Raises:
            NotPackableError: `can_be_compiled` says no.
            NumbaError: The law cannot be compiled.
        """
        from mjbiped.control.machine_code import CompiledLaw

        packer = Packer()
        packer.add(0.0)  # _FAILED
        made = packer.add(law.parameters)
        self._record = packer.record()
        kind = (made, tuple(packer.classes.items()), joints, states, memory_size, contract, idle)
        self._functions = {name: _function(name, each, *kind) for name, each in law.functions.items()}
        self.law = CompiledLaw(
            **{name: function.address for name, function in self._functions.items()},
            record=self._record.ctypes.data,
            values=(0.0,) * (joints + max(idle + states, room)),
        )

    @property
    def failed(self) -> bool:
        """Whether a law has raised an exception; its torques are no numbers since."""
        return bool(self._record[_FAILED])


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


@lru_cache(maxsize=256)
def _function(
    name: str,
    law: Callable[..., Any],
    made: str,
    classes: tuple[tuple[str, type], ...],
    joints: int,
    states: int,
    memory_size: int,
    contract: bool,
    idle: int,
) -> Any:
    """One of the C functions, for one kind of law and parameters. What did not change is not compiled again."""
    import numba

    from mjbiped.numerics import addresses

    values, q, dq = joints + states, _numbered("q", joints), _numbered("dq", joints)
    state, postures = f"t, {q}, {dq}", f"{_numbered('before', joints)}, {q}, {dq}"
    values_of = ", ".join(f"value_{index}" for index in range(values))  # unpacked: their number is looked at
    given = [f"value_{index}" for index in range(values)]
    given[joints:joints] = ["0.0"] * idle
    written = "; ".join(f"o[{index}] = float({value})" for index, value in enumerate(given))
    memory = f"numbers(m + {WORD * idle}, {memory_size})" if idle else f"numbers(m, {memory_size})"
    # once a law has failed, be it at a touchdown, no torque is a number: the walk goes no further
    lost = f"if numbers(record, 1)[{_FAILED}] != 0.0: o[:] = NAN"
    arguments, before, call, after = {
        "torque": (
            f"{state}, out",
            f"o = numbers(out, {len(given)})",
            f"{values_of} = law(parameters(record), {memory}, {state}); {written}",
            lost,
        ),
        "tick": (state, "pass", f"law(parameters(record), {memory}, {state})", "pass"),
        "knee_strike": (state, "pass", f"law(parameters(record), {memory}, {state})", "pass"),
        "touchdown": (postures, "pass", f"law(parameters(record), {memory}, {postures})", "pass"),
        "slope_estimate": (
            "t",
            "x = NAN",
            f"x = float(law(parameters(record), {memory}))",
            "return x",
        ),
        "next_discontinuity": (
            "t",
            "x = NAN",
            f"x = float(law(parameters(record), {memory}, t))",
            "return x",
        ),
    }[name]
    made_law, digest = kept_apart(law, contract, _strange(classes))
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
        "parameters": unpacking(made, classes, contract),
    }
    word, number = numba.types.int64, numba.types.float64
    signature = {
        "torque": numba.types.void(word, word, *[number] * (1 + 2 * joints), word),
        "touchdown": numba.types.void(word, word, *[number] * (3 * joints)),
        "tick": numba.types.void(word, word, *[number] * (1 + 2 * joints)),
        "knee_strike": numba.types.void(word, word, *[number] * (1 + 2 * joints)),
    }.get(name, number(word, word, number))
    known = (digest, made, _kinds(classes), contract)
    return from_source(partial(c_function, signature=signature, **options(contract)), name, source, space, known)


def _numbered(name: str, count: int) -> str:
    """A parameter for each of the robot's angles."""
    return ", ".join(f"{name}{index + 1}" for index in range(count))


@lru_cache(maxsize=256)
def unpacking(made: str, classes: tuple[tuple[str, type], ...], contract: bool) -> Any:
    """A compiled function that makes a law's parameters of the address of their record."""
    from mjbiped.numerics import addresses

    source = f"""def parameters(record):
    p = numbers(record, {made.count("p[") + 1})
    return {made}
"""
    space = {"numbers": addresses.numbers, "array": addresses.array, **dict(classes)}
    return from_source(
        partial(jitted, **called_within(contract)), "parameters", source, space, (_kinds(classes), contract)
    )


def _kinds(classes: tuple[tuple[str, type], ...]) -> list[tuple[str, str, Any]]:
    """What tells the classes of parameters from others."""
    return [(kind.__module__, kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes]


def _strange(classes: tuple[tuple[str, type], ...]) -> tuple[str, ...]:
    """Those of the classes that a program without the user's module cannot import, as what is kept of them asks for."""
    names = (f"{kind.__module__}.{kind.__qualname__}" for _, kind in classes)
    return tuple(name for name in names if not name.startswith(("mjbiped.", "controllers.")))
