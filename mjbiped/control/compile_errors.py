"""Explanations of why a controller's laws cannot be compiled."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mjbiped.control.compilation import floats_taken
from mjbiped.errors import InputError, shown
from mjbiped.numerics.jit import prepared

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller, Law

_ADVICE = (
    "A law takes and returns plain floats, returns several as a tuple, allocates nothing (no list, array or string), "
    "and calls only functions that do the same, of `math` or at the top level of a module. Correct it, or let law() "
    "return None: the walk then runs in plain Python"
)


class LawError(InputError):
    """A controller's laws cannot be compiled; nothing has been computed then."""


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
        reason = _blame(law, controller.states, len(controller.joints)) or f"together: {_reason(error)}"
        raise LawError(f"the laws of {type(controller).__name__} cannot be compiled: {reason}. {_ADVICE}") from error


def _blame(law: Law, states: Sequence[str], joints: int = 2) -> str:
    """Describe the first law that cannot be compiled by itself, and why; empty if all can."""
    numba: Any = import_module("numba")  # slow to import, and without types
    types = numba.types
    prepared(tuple(law.functions.values()), inlined=())
    try:
        parameters = numba.typeof(law.parameters)
    except ValueError:
        return f"parameters are {shown(law.parameters)}; expected numbers, arrays, tuples and NamedTuples of these"
    memory, number = types.Array(types.float64, 1, "C"), types.float64
    returned = {"torque": joints + len(states), "slope_estimate": 1, "next_discontinuity": 1}
    for name, function in law.functions.items():
        values, alone = returned.get(name, 0), numba.njit(_nrt=False)(function)
        try:
            alone.compile(_passed(function, (parameters, memory, *[number] * floats_taken(name, joints))))
        except (numba.core.errors.NumbaError, TypeError) as error:  # TypeError: another number of arguments
            return f"{name} ({function.__name__}): {_reason(error)}"
        given = alone.nopython_signatures[0].return_type
        parts = tuple(given) if isinstance(given, types.BaseTuple) else () if given == types.none else (given,)
        numbers = all(isinstance(types.unliteral(part), types.Number) for part in parts)
        if not numbers or len(parts) != values or isinstance(given, types.BaseTuple) != (values > 1):
            wanted = {0: "nothing", 1: "a float"}.get(values, f"a tuple of {values} floats")
            return f"{name} ({function.__name__}) returns {given}; expected {wanted}"
    return ""


def _passed(function: Callable[..., Any], kinds: tuple[Any, ...]) -> tuple[Any, ...]:
    """Types of arguments as Numba compiles a function for them: those that go into `*state` are one tuple."""
    code = function.__code__
    if not code.co_flags & inspect.CO_VARARGS:
        return kinds
    star: Any = import_module("numba").types.StarArgTuple
    return *kinds[: code.co_argcount], star.from_types(kinds[code.co_argcount :])


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
