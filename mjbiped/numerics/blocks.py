"""Named numbers for one source that runs as plain Python and as machine code.

A *block* is a dataclass of numbers, of lists, and of lists of blocks. Plain Python works on the object itself. Machine
code works on a copy in C's memory (`packed`), where a list is an address: so a function of a block takes one argument.
What Python writes as `values[i]` is written `numbers(block.values, count)[i]` for both, and `legs[i]` is
`leg_at(block.legs, i)` with `leg_at = reader(Leg)`. A row of a table is `row(table, index, count)`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, get_type_hints

import numpy as np
from numpy.typing import NDArray

Floats = Sequence[float]
"""A list of floats, which is an address in machine code."""


@cache
def dtype_of(kind: Any) -> np.dtype[Any]:
    """Layout in C's memory of a dataclass: integers of 64 bits, truth values and addresses too, and floats."""
    hints = get_type_hints(kind)
    words = [(field.name, np.float64 if hints[field.name] is float else np.int64) for field in dataclasses.fields(kind)]
    return np.dtype(words, align=True)


def packed(block: Any) -> tuple[NDArray[Any], list[Any]]:
    """A copy of a block for machine code, and what has to live as long as the copy.

    Args:
        block: A dataclass of floats, integers, truth values, arrays, sequences of floats, and sequences of blocks. An
            array is not copied: machine code reads and writes the array itself, which must be contiguous.
    """
    kind: Any = type(block)
    made, kept = np.zeros(1, dtype_of(kind)), []
    for name in made.dtype.names or ():
        value = getattr(block, name)
        if not isinstance(value, bool | int | float | np.number):
            array, below = _in_a_row(value)
            kept += [array, *below]
            value = array.ctypes.data
        made[name] = value
    return made, kept


def share_arrays(block: Any) -> None:
    """Make arrays of a block's lists of floats, on which Python and machine code then work both (`packed`)."""
    for field in dataclasses.fields(block):
        value = getattr(block, field.name)
        if isinstance(value, list) and value and isinstance(value[0], float | int | list):
            setattr(block, field.name, np.array(value, dtype=np.float64))


def take_numbers(block: Any, made: NDArray[Any]) -> None:
    """Let a block have the numbers that stand in its copy for machine code."""
    for name, value in zip(made.dtype.names or (), made[0].item(), strict=True):
        if isinstance(getattr(block, name), bool | int | float):
            setattr(block, name, value)


def _in_a_row(value: Any) -> tuple[NDArray[Any], list[Any]]:
    """The entries of a list one behind the other in C's memory, and what has to live as long as they do."""
    if isinstance(value, np.ndarray):
        assert value.flags.c_contiguous
        return value, []
    if len(value) and dataclasses.is_dataclass(value[0]):
        parts = [packed(each) for each in value]
        return np.concatenate([part for part, _ in parts]), [each for _, kept in parts for each in kept]
    return np.array(value, dtype=np.float64), []


def numbers(values: Any, count: int) -> Any:  # noqa: ARG001 (machine code needs the count)
    """The floats of a list, or of what stands at an address."""
    return values


def row(values: Any, index: int, count: int) -> Any:  # noqa: ARG001 (machine code needs the count)
    """The floats of one row of a table, a list of lists or what stands at an address, whose rows have `count` each."""
    return values[index]


def reader(kind: type) -> Callable[[Any, int], Any]:
    """The function (blocks, index) -> one block of a list, or of those at an address one behind the other."""

    def entry(blocks: Any, index: int) -> Any:
        return blocks[index]

    entry.meant = kind  # type: ignore[attr-defined]  # see `machine.compiled`
    return entry


def call(function: Any, *arguments: Any) -> None:
    """Call a function, or the C function at an address, for which arrays are addresses."""
    function(*arguments)


def call_for_float(function: Any, *arguments: Any) -> float:
    """The float that such a function returns."""
    result: float = function(*arguments)
    return result


_meant: tuple[Any, ...] = (numbers, row, call, call_for_float)
for _each in _meant:
    _each.meant = None  # what they mean in machine code stands in `machine`
