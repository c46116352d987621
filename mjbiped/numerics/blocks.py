"""Named numbers for one source that runs as plain Python and as machine code.

A *block* is a `Block`, a dataclass or a `NamedTuple` of numbers, of lists, and of lists of blocks. Plain Python works
on the object itself. Machine code works on a copy in C's memory (`packed`), where a list is an address: so a function
of a block takes one argument. What Python writes as `values[i]` is written `numbers(block.values, count)[i]` for both,
and `legs[i]` is `leg_at(block.legs, i)` with `leg_at = reader(Leg)`. A row of a table is `row(table, index, count)`.
"""

from __future__ import annotations

import ctypes
import dataclasses
from collections.abc import Callable, MutableSequence, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias, TypeVar, get_type_hints

import numpy as np
from numpy.typing import NDArray

Kind = TypeVar("Kind")
Layout: TypeAlias = np.dtype[Any]
Memory: TypeAlias = NDArray[Any]
Numbers: TypeAlias = Sequence[float] | NDArray[np.float64]
"""Floats that are only read."""

Floats: TypeAlias = MutableSequence[float] | NDArray[np.float64]
"""A list of floats, which is an address in machine code."""


class Block:
    """A block whose fields are named where it is made, and nowhere else; all of one kind are made of like values.

    Attributes:
        layout: Layout in C's memory of this kind.
    """

    layout: ClassVar[Layout]
    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Any field."""

        def __setattr__(self, name: str, value: object) -> None:
            """Change a field."""

    def __init__(self, **fields: object) -> None:
        """Let floats be floats in machine code, and all else integers and addresses."""
        vars(self).update(fields)
        kinds = [(name, np.float64 if isinstance(value, float) else np.int64) for name, value in fields.items()]
        layout = np.dtype(kinds)
        assert getattr(type(self), "layout", layout) == layout, "blocks of one kind are alike"
        type(self).layout = layout

    def but(self, **changed: object) -> Self:
        """A copy with other values of some fields."""
        return type(self)(**{**vars(self), **changed})


@cache
def dtype_of(kind: Any) -> Layout:
    """Layout in C's memory of a block, or of a structure of ctypes: integers of 64 bits for all but floats.

    That of a `Block` is known once the first of its kind has been made.
    """
    if issubclass(kind, ctypes.Structure) or hasattr(kind, "layout"):
        layout: Layout = np.dtype(getattr(kind, "layout", kind))
        return layout
    hints = get_type_hints(kind)
    return np.dtype([(name, np.float64 if hints[name] is float else np.int64) for name in _names(kind)])


def _names(kind: type) -> Sequence[str]:
    """Names of the fields of a block."""
    return getattr(kind, "_fields", None) or [field.name for field in dataclasses.fields(kind)]


def packed(block: Any) -> tuple[Memory, list[object]]:
    """A copy of a block for machine code, and what has to live as long as the copy.

    Args:
        block: Its fields are floats, integers, truth values, arrays, sequences of floats, and sequences of blocks. An
            array is not copied: machine code reads and writes the array itself.
    """
    made = np.zeros(1, dtype_of(block.__class__))
    kept: list[object] = []
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


def take_numbers(block: object, made: Memory) -> None:
    """Let a block have the numbers that stand in its copy for machine code."""
    for name, value in zip(made.dtype.names or (), made[0].item(), strict=True):
        if isinstance(getattr(block, name), bool | int | float):
            setattr(block, name, value)


def _in_a_row(value: Any) -> tuple[Memory, list[object]]:
    """The entries of a list one behind the other in C's memory, and what has to live as long as they do."""
    if isinstance(value, np.ndarray):
        return value, []
    if len(value) and not isinstance(value[0], float | int | list):
        parts = [packed(each) for each in value]
        return np.concatenate([part for part, _ in parts]), [each for _, kept in parts for each in kept]
    return np.array(value, dtype=np.float64), []


def numbers(values: object, count: int) -> MutableSequence[float]:  # noqa: ARG001 (machine code needs the count)
    """The floats of a list, or of what stands at an address."""
    return values  # type: ignore[return-value]


def whole_numbers(values: object, count: int) -> Any:  # noqa: ARG001
    """The integers of 32 bits of an array, or of what stands at an address."""
    return values


def octets(values: object, count: int) -> Any:  # noqa: ARG001
    """The bytes of an array, or of what stands at an address."""
    return values


def borrowed(values: Any, count: int) -> MutableSequence[float]:  # noqa: ARG001
    """The floats of an array: for Python, which reads lists faster, a copy; for machine code what stands there."""
    return values.tolist()  # type: ignore[no-any-return]


def give_back(values: Any, changed: Numbers) -> None:
    """Write what was borrowed into its array again, where it is a copy."""
    values[:] = changed


def first(values: Any, count: int) -> Sequence[float]:
    """The first floats of an array: for Python a copy, for machine code what stands there."""
    return tuple(values[:count])


def row(values: Any, index: int, count: int) -> MutableSequence[float]:  # noqa: ARG001 (machine code needs the count)
    """The floats of one row of a table, a list of lists or what stands at an address, whose rows have `count` each."""
    return values[index]  # type: ignore[no-any-return]


def reader(kind: type[Kind]) -> Callable[[Any, int], Kind]:
    """The function (blocks, index) -> one block of a list, or of those at an address one behind the other."""

    def entry(blocks: Sequence[Kind], index: int) -> Kind:
        return blocks[index]

    entry.kind = kind  # type: ignore[attr-defined]  # for `machine`
    return entry


def call(function: Any, *arguments: object) -> None:
    """Call a function, or the C function at an address, for which arrays are addresses."""
    function(*arguments)


def call_for_float(function: Any, *arguments: object) -> float:
    """The float that such a function returns."""
    result: float = function(*arguments)
    return result
