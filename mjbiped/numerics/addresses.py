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


@intrinsic  # type: ignore[untyped-decorator]
def call_torque(_typing: Any, _function: Any, _record: Any, memory: Any, state: Any, values: Any) -> Any:
    """Call the C function at an address, and return the floats that it writes: as many as `values` has.

    Its arguments are a record, an array, the floats of a tuple (time and state), and the address to write to. `values`
    is a tuple, or an array in a record, whose length is part of its type.
    """
    made_of = _floats(range(values.shape[0])) if isinstance(values, types.Array) else values

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        function, record, memory, state, _ = arguments
        given = cgutils.unpack_tuple(builder, state)
        made = cgutils.alloca_once(builder, context.get_value_type(made_of))
        out = builder.ptrtoint(made, cgutils.intp_t)
        _call(builder, function, ir.VoidType(), [record, _data(context, builder, signature, memory), *given, out])
        return builder.load(made)

    return made_of(types.int64, types.int64, memory, _floats(state), values), generate


@intrinsic  # type: ignore[untyped-decorator]
def call_for_nothing(_typing: Any, _function: Any, _record: Any, memory: Any, state: Any) -> Any:
    """Call the C function at an address with a record, an array, and the floats of a tuple; return nothing."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        function, record, memory, state = arguments
        given = cgutils.unpack_tuple(builder, state)
        _call(builder, function, ir.VoidType(), [record, _data(context, builder, signature, memory), *given])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, memory, _floats(state)), generate


def _floats(state: Any) -> Any:
    """The type of a tuple of floats as long as `state`."""
    return types.UniTuple(types.float64, len(state))


@intrinsic  # type: ignore[untyped-decorator]
def floats_at(_typing: Any, memory: Any, _first: Any, values: Any) -> Any:
    """Read floats of an array from an index on, as a tuple as long as `values`."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, arguments[0])
        place = builder.gep(view.data, [arguments[1]])
        return builder.load(builder.bitcast(place, context.get_value_type(values).as_pointer()))

    return values(memory, types.int64, values), generate


@intrinsic  # type: ignore[untyped-decorator]
def call_at(_typing: Any, _function: Any, _record: Any, memory: Any, _t: Any) -> Any:
    """Call the C function at an address with a record, an array and a time, and return its float."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        function, record, memory, t = arguments
        return _call(builder, function, ir.DoubleType(), [record, _data(context, builder, signature, memory), t])

    return types.float64(types.int64, types.int64, memory, types.float64), generate


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


def _data(context: Any, builder: Any, signature: Any, memory: Any) -> Any:
    """The address of an array's first number; the array is the third argument."""
    view = context.make_array(signature.args[2])(context, builder, memory)
    return builder.ptrtoint(view.data, cgutils.intp_t)


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
