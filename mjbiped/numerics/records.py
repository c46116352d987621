"""Parameters of a walk for compiled code, packed into one block of numbers."""

from __future__ import annotations

from dataclasses import fields
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

WORD = 8
"""Size of an address and of a float, bytes."""


class NotPackableError(TypeError):
    """Parameters contain something other than numbers, arrays of floats, and tuples of these."""


class Shared:
    """An array that is not copied into the record: the record holds its address, and compiled code writes to it.

    Attributes:
        array: Contiguous floats; the caller keeps it alive.
    """

    def __init__(self, array: NDArray[np.float64]) -> None:
        """Share an array.

        Raises:
            NotPackableError: The array is not contiguous, or not of floats.
        """
        if not (array.dtype == np.float64 and array.flags.c_contiguous):
            raise NotPackableError("a shared array must be contiguous and of floats")
        self.array = array


def in_one_block(values: Any) -> Any:
    """Numbers, arrays and groups of them as the fields of one NumPy record.

    Compiled code reads and writes the fields by their names, as plain Python does those of the values given; it hands a
    record on as one address, where an array is seven arguments. Plain Python is slower with a record.

    Args:
        values: A dataclass or a namespace of numbers, sequences of floats, arrays, and namespaces of these.
    """
    names = list(vars(values)) if isinstance(values, SimpleNamespace) else [field.name for field in fields(values)]
    parts = {name: getattr(values, name) for name in names}
    arrays = {
        name: np.asarray(in_one_block(part) if isinstance(part, SimpleNamespace) else part)
        for name, part in parts.items()
    }
    block = np.zeros(1, np.dtype([(name, array.dtype, array.shape) for name, array in arrays.items()], align=True))
    for name, array in arrays.items():
        block[name] = array
    return block.view(np.recarray)[0]


class Packer:
    """Packs values into numbers, with the expressions that rebuild the values in compiled code.

    Attributes:
        classes: The NamedTuples found, by the names that the expressions give them.
    """

    def __init__(self) -> None:
        """Begin an empty record."""
        self.classes: dict[str, type] = {}
        self._numbers: list[float] = []
        self._arrays: list[tuple[int, NDArray[np.float64]]] = []

    def add(self, value: Any) -> str:
        """Add a value to the record.

        Args:
            value: A number, an array of floats, a shared array, or a tuple or NamedTuple of these.

        Returns:
            The expression that rebuilds it, where `record` is the record's address, `p` its numbers, and
            `array(address, shape)` the array at an address.

        Raises:
            NotPackableError: The value contains something else.
        """
        if isinstance(value, tuple):
            parts = [self.add(part) for part in value]
            if hasattr(value, "_fields"):
                name = next((name for name, kind in self.classes.items() if kind is type(value)), "")
                if not name:
                    name = f"class_{len(self.classes)}"
                    self.classes[name] = type(value)
                return f"{name}({', '.join(parts)})"
            return f"({''.join(part + ', ' for part in parts)})"
        array = value.array if isinstance(value, Shared) else value
        if isinstance(array, np.ndarray) and array.dtype == np.float64 and array.ndim > 0:
            first = len(self._numbers)
            self._numbers += [float(array.ctypes.data), *map(float, array.shape)]  # addresses have 48 bits
            shape = "".join(f"int(p[{first + 1 + axis}]), " for axis in range(array.ndim))
            if array is not value:
                return f"array(int(p[{first}]), ({shape}))"
            self._arrays.append((first, array))  # the address within the record is filled in by `record`
            return f"array(record + {WORD} * int(p[{first}]), ({shape}))"
        self._numbers.append(0.0)
        place = f"p[{len(self._numbers) - 1}]"
        if isinstance(value, bool | np.bool_):
            expression = f"({place} != 0.0)"
        elif isinstance(value, int | np.integer) and abs(int(value)) < 1 << 53:
            expression = f"int({place})"
        elif isinstance(value, float | np.float64):
            expression = place
        else:
            raise NotPackableError(f"{type(value).__name__} {value!r}")
        self._numbers[-1] = float(value)
        return expression

    def record(self) -> NDArray[np.float64]:
        """The numbers, followed by the arrays."""
        numbers = list(self._numbers)
        for first, array in self._arrays:
            numbers[first] = float(len(numbers))
            numbers += array.ravel().tolist()
        return np.array(numbers, dtype=np.float64)
