"""What a plain Python function does: the functions that it calls, and a description of all that it depends on."""

from __future__ import annotations

import dis
import hashlib
from collections.abc import Callable, Iterator
from functools import lru_cache
from types import CodeType, FunctionType, ModuleType
from typing import Any

Function = Callable[..., Any]


def with_callees(*functions: object) -> list[FunctionType]:
    """Functions and all that they call, directly or indirectly, those that a user has jitted included."""
    found: dict[FunctionType, None] = {}
    waiting = list(functions)
    while waiting:
        each = waiting.pop(0)
        each = getattr(each, "py_func", each)
        if isinstance(each, FunctionType) and each not in found:
            found[each] = None
            waiting += (value for _, value in _named(each))
    return list(found)


def _named(function: FunctionType) -> Iterator[tuple[str, object]]:
    """Global names that a function uses, attributes of modules, and free variables, with their values."""
    code = function.__code__
    for name in code.co_names:
        value = function.__globals__.get(name)
        if isinstance(value, ModuleType):
            yield from ((part, vars(value)[part]) for part in code.co_names if part in vars(value))
        elif value is not None:
            yield name, value
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents


def described(function: FunctionType) -> Any:
    """Everything that determines what a function does: code, defaults, and constant globals and free variables."""
    constants = [(name, _constant(value)) for name, value in _named(function) if not callable(value)]
    defaults = _constant(function.__defaults__ or ())
    return function.__module__, function.__qualname__, _code(function.__code__), defaults, sorted(constants, key=str)


def _constant(value: Any) -> object:
    """Describe a value so that different values have different descriptions; `repr` abridges arrays."""
    if isinstance(value, tuple):
        return type(value).__qualname__, [_constant(part) for part in value]
    if hasattr(value, "tobytes"):
        return value.dtype.str, getattr(value, "shape", ()), hashlib.sha256(value.tobytes()).hexdigest()
    return repr(value)


def _code(code: CodeType) -> object:
    constants = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return code.co_code.hex(), constants, code.co_names, code.co_varnames


@lru_cache(maxsize=64)
def raises(roots: tuple[Function, ...]) -> bool:
    """Whether the functions, or anything that they call, contain a `raise` or `assert`."""
    return any(step.opname == "RAISE_VARARGS" for step in _instructions(roots))


@lru_cache(maxsize=64)
def takes_powers(roots: tuple[Function, ...]) -> bool:
    """Whether the functions, or anything that they call, contain `**`, whose last bit is another in machine code."""
    return any(step.argrepr in ("**", "**=") or step.argval == "pow" for step in _instructions(roots))


def _instructions(roots: tuple[Function, ...]) -> Iterator[dis.Instruction]:
    for part in with_callees(*roots):
        yield from dis.get_instructions(part)
