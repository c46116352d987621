"""How compiled callbacks read memory, by address; bounds are the caller's matter."""

from __future__ import annotations

import importlib
from functools import lru_cache
from typing import Any

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.compiled.layout import Layout
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
    register_jitable = importlib.import_module("numba.extending").register_jitable
    addresses: Any = importlib.import_module("mjbiped.numerics.addresses")
    word, numbers, array = addresses.word, addresses.numbers, addresses.array
    numerics, numeric_data, userdata = at.numerics, at.numeric_data, at.userdata
    place, size = events.RECORD, RECORDS_SIZE

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
