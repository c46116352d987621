"""Memory and functions by address, for compiled code; nothing checks bounds or signatures.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

# Numba has no types
cgutils: Any = importlib.import_module("numba.core.cgutils")
intrinsic: Any = importlib.import_module("numba.extending").intrinsic
ir: Any = importlib.import_module("llvmlite.ir")
populate_array: Any = importlib.import_module("numba.np.arrayobj").populate_array
types: Any = importlib.import_module("numba").types

WORD = 8
"""Size of an address and of a float, bytes."""


@intrinsic  # type: ignore[untyped-decorator]
def numbers(_typing: Any, _address: Any, _count: Any) -> Any:
    """A view of a number of floats at an address, as an array."""
    kind = types.Array(types.float64, 1, "C")

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _view(context, builder, kind, arguments[0], [arguments[1]])

    return kind(types.intp, types.intp), generate


@intrinsic  # type: ignore[untyped-decorator]
def call(_typing: Any, _function: Any, given: Any) -> Any:
    """Call the C function at an address; return nothing.

    Args:
        _function: The address.
        given: A tuple of its arguments. Floats and integers are passed as they are; of arrays the addresses are.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        _call(builder, arguments[0], ir.VoidType(), _passed(context, builder, signature.args[1], arguments[1]))
        return context.get_dummy_value()

    return types.void(types.int64, given), generate


@intrinsic  # type: ignore[untyped-decorator]
def call_for_number(_typing: Any, _function: Any, given: Any) -> Any:
    """Call the C function at an address, and return its float; the arguments are those of `call`."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        passed = _passed(context, builder, signature.args[1], arguments[1])
        return _call(builder, arguments[0], ir.DoubleType(), passed)

    return types.float64(types.int64, given), generate


def _call(builder: Any, function: Any, result: Any, arguments: Sequence[Any]) -> Any:
    kind = ir.FunctionType(result, [argument.type for argument in arguments])
    return builder.call(builder.inttoptr(function, kind.as_pointer()), arguments)


def _passed(context: Any, builder: Any, kinds: Any, given: Any) -> list[Any]:
    """The arguments in a tuple as a C function takes them; see `call`."""
    passed = []
    for kind, value in zip(kinds, cgutils.unpack_tuple(builder, given), strict=True):
        if isinstance(kind, types.Array):
            data = context.make_array(kind)(context, builder, value).data
            passed.append(builder.ptrtoint(data, cgutils.intp_t))
        else:
            passed.append(value)
    return passed


def _view(context: Any, builder: Any, kind: Any, address: Any, shape: Sequence[Any]) -> Any:
    """Make an array that does not own its memory, like `numba.carray`, but without Numba's runtime."""
    made, word = context.make_array(kind)(context, builder), context.get_constant(types.intp, WORD)
    data = builder.inttoptr(address, made.data.type)
    populate_array(made, data=data, shape=shape, strides=[word], itemsize=word, meminfo=None)
    return made._getvalue()
