"""Memory and functions by address, for compiled code; nothing checks bounds or signatures.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

from mjbiped.numerics.records import WORD

# Numba has no types
cgutils: Any = importlib.import_module("numba.core.cgutils")
intrinsic: Any = importlib.import_module("numba.extending").intrinsic
ir: Any = importlib.import_module("llvmlite.ir")
populate_array: Any = importlib.import_module("numba.np.arrayobj").populate_array
types: Any = importlib.import_module("numba").types


@intrinsic  # type: ignore[untyped-decorator]
def word(_typing: Any, _address: Any) -> Any:
    """Read the 64-bit integer at an address."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.load(builder.inttoptr(arguments[0], cgutils.intp_t.as_pointer()))

    return types.int64(types.int64), generate


@intrinsic  # type: ignore[untyped-decorator]
def put_word(_typing: Any, _address: Any, _value: Any) -> Any:
    """Write a 64-bit integer to an address."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        builder.store(arguments[1], builder.inttoptr(arguments[0], cgutils.intp_t.as_pointer()))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), generate


@intrinsic  # type: ignore[untyped-decorator]
def claimed(_typing: Any, _address: Any) -> Any:
    """Read the 64-bit integer at an address and increment it, atomically: no two threads get the same."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        pointer = builder.inttoptr(arguments[0], cgutils.intp_t.as_pointer())
        return builder.atomic_rmw("add", pointer, ir.Constant(cgutils.intp_t, 1), "monotonic")

    return types.int64(types.int64), generate


@intrinsic  # type: ignore[untyped-decorator]
def numbers(_typing: Any, _address: Any, _count: Any) -> Any:
    """A view of a number of floats at an address, as an array."""
    kind = types.Array(types.float64, 1, "C")

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _view(context, builder, kind, arguments[0], [arguments[1]])

    return kind(types.intp, types.intp), generate


@intrinsic  # type: ignore[untyped-decorator]
def array(_typing: Any, _address: Any, shape: Any) -> Any:
    """A view of floats at an address as an array of several dimensions; the shape is a tuple."""
    kind = types.Array(types.float64, len(shape), "C")

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _view(context, builder, kind, arguments[0], cgutils.unpack_tuple(builder, arguments[1]))

    return kind(types.intp, types.UniTuple(types.intp, len(shape))), generate


@intrinsic(prefer_literal=True)  # type: ignore[untyped-decorator]
def call_for_values(_typing: Any, _function: Any, given: Any, values: Any, room: Any) -> Any:
    """Call the C function at an address, and return the floats that it writes, as many as `values` has.

    Its arguments are those of `call`, and the address to write to. `values` is a tuple, or an array in a record, whose
    length is part of its type; the floats begin as zeros. `room` is a number of further floats, known when compiling.
    """
    count, more = (values.shape[0] if isinstance(values, types.Array) else len(values)), room.literal_value
    made_of = types.UniTuple(types.float64, count)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = ir.ArrayType(ir.DoubleType(), count + more)
        made = _place_for(builder, whole)
        found = builder.bitcast(made, context.get_value_type(made_of).as_pointer())
        builder.store(context.get_value_type(made_of)(None), found)
        passed = _passed(context, builder, signature.args[1], arguments[1])
        _call(builder, arguments[0], ir.VoidType(), [*passed, builder.ptrtoint(made, cgutils.intp_t)])
        return builder.load(found)

    return made_of(types.int64, given, values, room), generate


@intrinsic  # type: ignore[untyped-decorator]
def call(_typing: Any, _function: Any, given: Any) -> Any:
    """Call the C function at an address; return nothing.

    Args:
        _function: The address.
        given: A tuple of its arguments. Floats and integers are passed as they are; of arrays, and of tuples of floats,
            which are written to the stack first, the addresses are passed.
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


@intrinsic  # type: ignore[untyped-decorator]
def floats_at(_typing: Any, memory: Any, _first: Any, values: Any) -> Any:
    """Read floats of an array from an index on, as a tuple as long as `values`."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, arguments[0])
        place = builder.gep(view.data, [arguments[1]])
        return builder.load(builder.bitcast(place, context.get_value_type(values).as_pointer()))

    return values(memory, types.int64, values), generate


@intrinsic  # type: ignore[untyped-decorator]
def call_with(_typing: Any, _function: Any, _first: Any, _second: Any) -> Any:
    """Call the C function at an address with two addresses."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        _call(builder, arguments[0], ir.VoidType(), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate


def _call(builder: Any, function: Any, result: Any, arguments: Sequence[Any]) -> Any:
    kind = ir.FunctionType(result, [argument.type for argument in arguments])
    return builder.call(builder.inttoptr(function, kind.as_pointer()), arguments)


def _place_for(builder: Any, kind: Any) -> Any:
    """Make room on the stack; Numba's own way fills it with zeros at each call."""
    with builder.goto_entry_block():
        return builder.alloca(kind)


def _passed(context: Any, builder: Any, kinds: Any, given: Any) -> list[Any]:
    """The arguments in a tuple as a C function takes them; see `call`."""
    passed = []
    for kind, value in zip(kinds, cgutils.unpack_tuple(builder, given), strict=True):
        if isinstance(kind, types.Array):
            data = context.make_array(kind)(context, builder, value).data
            passed.append(builder.ptrtoint(data, cgutils.intp_t))
        elif isinstance(kind, types.BaseTuple):
            place = _place_for(builder, value.type)
            builder.store(value, place)
            passed.append(builder.ptrtoint(place, cgutils.intp_t))
        else:
            passed.append(value)
    return passed


def _view(context: Any, builder: Any, kind: Any, address: Any, shape: Sequence[Any]) -> Any:
    """Make an array that does not own its memory, like `numba.carray`, but without Numba's runtime."""
    strides = [context.get_constant(types.intp, WORD)]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    made = context.make_array(kind)(context, builder)
    populate_array(
        made,
        data=builder.inttoptr(address, made.data.type),
        shape=shape,
        strides=strides,
        itemsize=context.get_constant(types.intp, WORD),
        meminfo=None,
    )
    return made._getvalue()
