"""How compiled callbacks read memory, by address; bounds are the caller's matter."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.compiled.layout import WORD, Layout
from mjbiped.engines.mujoco.scene import RECORDS_SIZE


@lru_cache(maxsize=1)
def memory_access(at: Layout) -> dict[str, Any]:
    """The functions that compiled code reads memory with.

    Args:
        at: Offsets of what `record_of` looks at.

    Returns:
        `word(address)`: the 64-bit integer at an address. `numbers(address, count)` and `array(address, shape)`: the
        floats there, as an array that owns nothing. `four(address)`: the four floats there.
        `record_of(model, data, token)`: address of a walk's record, 0 where it has none for callbacks of this token.
    """
    numba: Any = importlib.import_module("numba")
    cgutils: Any = importlib.import_module("numba.core.cgutils")
    extending: Any = importlib.import_module("numba.extending")
    populate_array: Any = importlib.import_module("numba.np.arrayobj").populate_array
    types, intrinsic, register_jitable = numba.types, extending.intrinsic, extending.register_jitable
    numerics, numeric_data, userdata = at.numerics, at.numeric_data, at.userdata
    place, size = events.RECORD, RECORDS_SIZE

    def view(context: Any, builder: Any, kind: Any, address: Any, shape: Sequence[Any]) -> Any:
        """An array without an owner, as `numba.carray` makes it; that one cannot do without Numba's runtime."""
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

    # Numba's decorators have no types
    @intrinsic  # type: ignore[untyped-decorator]
    def array(_typing: Any, _address: Any, shape: Any) -> Any:
        kind = types.Array(types.float64, len(shape), "C")

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return view(context, builder, kind, arguments[0], cgutils.unpack_tuple(builder, arguments[1]))

        return kind(types.intp, types.UniTuple(types.intp, len(shape))), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def numbers(_typing: Any, _address: Any, _count: Any) -> Any:
        kind = types.Array(types.float64, 1, "C")

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return view(context, builder, kind, arguments[0], [arguments[1]])

        return kind(types.intp, types.intp), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def word(_typing: Any, _address: Any) -> Any:
        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.load(builder.inttoptr(arguments[0], cgutils.intp_t.as_pointer()))

        return types.int64(types.int64), generate

    @register_jitable
    def four(address):  # type: ignore[no-untyped-def]
        x = numbers(address, 4)
        return x[0], x[1], x[2], x[3]

    @register_jitable
    def record_of(model, data, token):  # type: ignore[no-untyped-def]
        if word(model + numerics) < size:
            return 0
        field = numbers(word(model + numeric_data), size)
        if field[0] != token or field[1] != float(model):
            return 0
        which = numbers(word(data + userdata), place + 1)[place]
        if not 0.0 <= which < field[3]:
            return 0
        return int(numbers(int(field[2]), int(field[3]))[int(which)])

    return {"word": word, "numbers": numbers, "array": array, "four": four, "record_of": record_of}
