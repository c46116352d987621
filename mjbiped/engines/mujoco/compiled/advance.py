"""Steps many simulations to a later tick of their controllers in one call, which lets other threads run.

A *table* says, in words of 64 bits, where the parts of each simulation lie; `advance` works on some of its rows. MuJoCo
itself is called by the address of `mj_step`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, NamedTuple

from mjbiped.engines.mujoco import motors, observation
from mjbiped.engines.mujoco.compiled.callbacks import Native, parts_of
from mjbiped.engines.mujoco.compiled.layout import Layout, layout, library
from mjbiped.engines.mujoco.state import SIZE, State
from mjbiped.numerics.jit import OPTIONS, c_function, described, from_source, prepared
from mjbiped.numerics.records import WORD
from mjbiped.records.rows import Rows

After = Callable[[Any, Any, Any], None]
"""Called with the `State` of a robot now, numbers that are kept for it, and those to be filled."""


class Row(NamedTuple):
    """A simulation in the table, each word an address but one.

    Attributes:
        model: The mjModel.
        data: Its mjData.
        place: Index in userdata to which the inputs are copied before the first step.
        inputs: Floats.
        now: Room for a copy of the state and of the last touchdown's row, as the next tick will find them.
        kept: Floats that `After` keeps from call to call.
        out: Floats that `After` fills.
    """

    model: int
    data: int
    place: int
    inputs: int
    now: int
    kept: int
    out: int


class Sizes(NamedTuple):
    """Numbers of floats.

    Attributes:
        inputs: Of `Row.inputs`.
        kept: Of `Row.kept`.
        out: Of `Row.out`.
    """

    inputs: int
    kept: int
    out: int


@lru_cache(maxsize=1)
def step_address() -> int:
    """Address of `mj_step`.

    Raises:
        UnknownLayoutError: MuJoCo's library is not found.
    """
    return ctypes.cast(library().mj_step, ctypes.c_void_p).value or 0


def advancing(native: Native, after: After, sizes: Sizes) -> Any:
    """The C function for simulations like one, as a ctypes function pointer.

    It takes the table's address, that of the number of the first row, the row behind the last, the address of
    `mj_step`, and the number of ticks to be made (with 0 it only looks). Threads that share the number of the first row
    share the rows.

    A walk that is over, or was reset by MuJoCo, is stepped no more. One that turns out to be over at the last
    tick is stepped once more, so that its own userdata know it.

    Args:
        native: Of one simulation; the others have the same `functions`.
        after: Called for each at last.
        sizes: Of what it works on.

    Raises:
        NumbaError: `after` cannot be compiled.
    """
    return _compile(native.made, native.classes, native.rows, layout(), after, sizes)


_SOURCE = """def advance(table, following, last, mj_step, ticks):
    while True:
        index = claimed(following)
        if index >= last:
            break
        row = table + ROW * index
        model, data, place, inputs, now, kept, out = {words}
        record = record_of(model, data)
        if record == 0:
            continue
        p = numbers(record, SCALARS)
        constants, _, _ = {made}
        u, clock = state_at(word(data + AT_USERDATA)), numbers(data + AT_TIME, 1)
        if ticks and u.running and not u.outcome:
            given, held = numbers(inputs, INPUTS), numbers(word(data + AT_USERDATA) + {WORD} * place, INPUTS)
            for i in range(INPUTS):
                held[i] = given[i]
        for _ in range(ticks):
            while u.running and not u.outcome:
                call_with(mj_step, model, data)
                if not clock[0] <= u.next_control - NOW:  # not where it is no number
                    break
        size = SIZE + constants.touched
        told, source = numbers(now, size), numbers(word(data + AT_USERDATA), size)
        for i in range(size):
            told[i] = source[i]
        seen = state_at(now)
        if u.running and not u.outcome and clock[0] > u.time:
            n = len(constants.places.order)
            line = numbers(now + {WORD} * SIZE, constants.touched)
            observe(
                Parts({parts}), constants, seen, line, clock[0],
                numbers(word(data + AT_QPOS), n), numbers(word(data + AT_QVEL), n),
            )
            if ticks and seen.outcome:
                call_with(mj_step, model, data)
        after(seen, numbers(kept, KEPT), numbers(out, OUT))
    return 0
"""


@lru_cache(maxsize=64)
def _compile(
    made: str, classes: tuple[tuple[str, type], ...], rows: Rows, at: Layout, after: After, sizes: Sizes
) -> Any:
    import numba

    from mjbiped.engines.mujoco.compiled import memory
    from mjbiped.numerics import addresses

    parts, names = parts_of(rows)
    known = (
        prepared((observation.observe, after, *parts.values()), inlined=()),
        described(memory.memory_access.__wrapped__),
        *(made, at, sizes, Row._fields, State._fields_, motors.NOW, OPTIONS, numba.__version__),
        *((kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes),
    )
    space: dict[str, Any] = {
        "SCALARS": made.count("p["),
        "ROW": WORD * len(Row._fields),
        "NOW": motors.NOW,
        "SIZE": SIZE,
        **{key.upper(): value for key, value in sizes._asdict().items()},
        **{f"AT_{key.upper()}": offset for key, offset in at._asdict().items()},
        "observe": observation.observe,
        "Parts": motors.Parts,
        "after": after,
        "call_with": addresses.call_with,
        "claimed": addresses.claimed,
        **parts,
        **dict(classes),
        **memory.memory_access(at),
    }
    words = ", ".join(f"word(row + {WORD * index})" for index in range(len(Row._fields)))
    source = _SOURCE.format(words=words, made=made, parts=names, WORD=WORD)
    word = numba.types.int64
    made_of = partial(c_function, signature=numba.types.int32(*[word] * 5), **OPTIONS)
    compiled = from_source(made_of, "advance", source, space, known)
    _kept.append(compiled)
    return compiled.ctypes


_kept: list[Any] = []  # their machine code lives as long as they do
