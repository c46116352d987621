"""How compiled callbacks read memory and call functions by address; bounds and signatures are the caller's matter.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numba
import numpy as np
from numba.extending import register_jitable

from mjbiped.engines.mujoco.compiled.layout import Layout
from mjbiped.engines.mujoco.scene import COUNT, OWNER, RECORDS_SIZE, TABLE
from mjbiped.engines.mujoco.state import Constants, Softness, State
from mjbiped.numerics.addresses import (
    array,
    floats_at,
    intrinsic,
    ir,
    numbers,
    populate_array,
    types,
    word,
)
from mjbiped.utils.mujoco import mujoco

EQ_DATA = int(mujoco.mjNEQDATA)  # floats of an equality constraint

_state: Any = numba.from_dtype(np.dtype(State))


@intrinsic  # type: ignore[untyped-decorator]
def state_at(_typing: Any, _address: Any) -> Any:
    """The `State` at an address."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(_state))

    return _state(types.int64), generate


@intrinsic  # type: ignore[untyped-decorator]
def octets(_typing: Any, _address: Any, _count: Any) -> Any:
    """So many bytes at an address, as an array that owns nothing."""
    kind = types.Array(types.uint8, 1, "C")

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        made = context.make_array(kind)(context, builder)
        data, one = builder.inttoptr(arguments[0], made.data.type), context.get_constant(types.intp, 1)
        populate_array(made, data=data, shape=[arguments[1]], strides=[one], itemsize=one, meminfo=None)
        return made._getvalue()

    return kind(types.intp, types.intp), generate


def _calling(result: Any, count: int) -> Any:
    """A function that calls the C function at an address with two addresses, and with so many 32-bit integers."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Sequence[Any]) -> Any:
        kind = ir.FunctionType(ir.IntType(32), [argument.type for argument in arguments[1:]])
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return result(types.int64, types.int64, types.int64, *[types.int32] * count), generate


@intrinsic  # type: ignore[untyped-decorator]
def call_sensor(_typing: Any, _function: Any, _model: Any, _data: Any, _stage: Any) -> Any:
    """Call the sensor callback at an address."""
    return _calling(types.int32, 1)


@intrinsic  # type: ignore[untyped-decorator]
def call_filter(_typing: Any, _function: Any, _model: Any, _data: Any, _first: Any, _second: Any) -> Any:
    """Call the contact filter at an address."""
    return _calling(types.int32, 2)


def told(values: Any, zeros: tuple[float, ...]) -> tuple[float, ...]:
    """The first numbers of an array as a tuple, as long as `zeros`: `motors.told` for compiled code."""
    found: tuple[float, ...] = floats_at(values, 0, zeros)
    return found


@lru_cache(maxsize=1)
def memory_access(at: Layout) -> dict[str, Any]:
    """The functions that compiled callbacks find a walk's memory with.

    Args:
        at: Offsets in MuJoCo's structs.

    Returns:
        `field_of(model)`: address of a model's own field `scene.RECORDS`, 0 where it has none.
        `record_of(model, data)`: address of a walk's record, 0 where it has none. `softness_at(model, data,
        constants)`: what is written there.
    """

    @register_jitable
    def field_of(model: int) -> int:
        if word(model + at.numerics) < RECORDS_SIZE:
            return 0
        address = word(model + at.numeric_data)
        return address if numbers(address, RECORDS_SIZE)[OWNER] == float(model) else 0

    @register_jitable
    def record_of(model: int, data: int) -> int:
        address = field_of(model)
        if address == 0:
            return 0
        field = numbers(address, RECORDS_SIZE)
        which = state_at(word(data + at.userdata)).record
        if not 0.0 <= which < field[COUNT]:
            return 0
        return int(numbers(int(field[TABLE]), int(field[COUNT]))[int(which)])

    @register_jitable
    def softness_at(model: int, data: int, constants: Constants) -> Softness:
        places = constants.places
        return Softness(
            array(word(model + at.geom_solref), (len(places.risers), 2)),
            array(word(model + at.jnt_solref), (len(places.order), 2)),
            array(word(model + at.eq_solref), (places.locks, 2)),
            array(word(model + at.eq_data), (places.locks, EQ_DATA)),
            octets(word(data + at.eq_active), places.locks),
        )

    return {
        "field_of": field_of,
        "record_of": record_of,
        "softness_at": softness_at,
        "state_at": state_at,
        "numbers": numbers,
        "word": word,
        "array": array,
    }
