"""Steps many simulations to their controllers' next ticks in one call, which lets other threads run.

A *table* says, in words of 64 bits, where the parts of each simulation lie; `advance` works on some of its rows. MuJoCo
itself is called by the address of `mj_step`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, NamedTuple

from mjbiped.engines.mujoco import callbacks
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.compiled.callbacks import Native
from mjbiped.engines.mujoco.compiled.layout import Layout, layout, library
from mjbiped.engines.mujoco.compiled.memory import memory_access
from mjbiped.engines.mujoco.compiled.registry import CALLBACKS
from mjbiped.numerics.jit import c_function, described, from_source, options, prepared
from mjbiped.numerics.records import WORD

After = Callable[[Any, Any, Any], None]
"""Called with what is known of a robot now, numbers that are kept for it, and those to be filled; plain numbers."""


class Row(NamedTuple):
    """A simulation in the table, each word an address but one.

    Attributes:
        model: The mjModel.
        data: Its mjData.
        place: Index in userdata to which the inputs are copied before the first step.
        inputs: Floats.
        now: Room for a copy of the userdata up to the controller's memory, as the next tick will find it.
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
    `mj_step`, whether steps are made (with 0 it only looks), and what it installs meanwhile: the address of
    `registry.Momentary.words`, or 0 where its callbacks stand already. It returns 1, and does nothing, where something
    else's callbacks stand there. Threads that share the number of the first row share the rows.

    A walk that is over, or was reset by MuJoCo, is stepped no more. One that turns out to be over at the end of the
    control period is stepped once more, so that its own userdata know it.

    Args:
        native: Of one simulation; the others have the same `functions`.
        after: Called for each at last.
        sizes: Of what it works on.

    Raises:
        NumbaError: `after` cannot be compiled.
    """
    return _compile(native.made, native.classes, layout(), native.functions.token, after, sizes)


@lru_cache(maxsize=64)
def _compile(
    made: str, classes: tuple[tuple[str, type], ...], at: Layout, token: float, after: After, sizes: Sizes
) -> Any:
    import numba

    from mjbiped.numerics import addresses

    known = (
        prepared((callbacks.take_in, after), inlined=()),
        described(memory_access.__wrapped__),
        *(made, at, token, sizes, Row._fields, numba.__version__),
        *(events.CONTROLLER_MEMORY, events.RECORD, events.RUNNING, events.OUTCOME, events.NEXT_CONTROL, callbacks.NOW),
        *((kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes),
    )
    words = ", ".join(f"word(row + {WORD * index})" for index in range(len(Row._fields)))
    source = f"""def advance(table, following, last, mj_step, stepped, installed):
    if installed != 0:
        for each in range(CALLBACKS):
            standing = word(word(installed + {3 * WORD} * each))
            if standing != 0 and standing != word(installed + {3 * WORD} * each + {WORD}):
                return 1
        for each in range(CALLBACKS + 1):
            slot = word(installed + {3 * WORD} * each)
            put_word(installed + {3 * WORD} * each + {2 * WORD}, word(slot))
            put_word(slot, word(installed + {3 * WORD} * each + {WORD}))
    while True:
        index = claimed(following)
        if index >= last:
            break
        row = table + {WORD * len(Row._fields)} * index
        model, data, place, inputs, now, kept, out = {words}
        record = record_of(model, data, TOKEN)
        if record == 0:
            continue
        p = numbers(record, SCALARS)
        constants, _, _ = {made}
        u = numbers(word(data + AT_USERDATA), MEMORY)
        clock = numbers(data + AT_TIME, 1)
        if stepped and u[RUNNING] != 0.0 and u[OUTCOME] == 0.0:
            given, held = numbers(inputs, INPUTS), numbers(word(data + AT_USERDATA) + {WORD} * place, INPUTS)
            for i in range(INPUTS):
                held[i] = given[i]
            while True:
                call_with(mj_step, model, data)
                waits = clock[0] <= u[NEXT_CONTROL] - NOW  # false where it is no number
                if not waits or u[RUNNING] == 0.0 or u[OUTCOME] != 0.0:
                    break
        told = numbers(now, MEMORY)
        for i in range(MEMORY):
            told[i] = u[i]
        if u[RUNNING] != 0.0 and u[OUTCOME] == 0.0 and clock[0] > u[TIME]:
            state = State(four(word(data + AT_QPOS)), four(word(data + AT_QVEL)))
            take_in(constants, told, clock[0], state)
            if stepped and told[OUTCOME] != 0.0:
                call_with(mj_step, model, data)
        after(told, numbers(kept, KEPT), numbers(out, OUT))
    if installed != 0:
        for each in range(CALLBACKS + 1):
            put_word(word(installed + {3 * WORD} * each), word(installed + {3 * WORD} * each + {2 * WORD}))
    return 0
"""
    space: dict[str, Any] = {
        "TOKEN": token,
        "SCALARS": made.count("p["),
        "MEMORY": events.CONTROLLER_MEMORY,
        "RUNNING": events.RUNNING,
        "OUTCOME": events.OUTCOME,
        "TIME": events.TIME,
        "NEXT_CONTROL": events.NEXT_CONTROL,
        "NOW": callbacks.NOW,
        "INPUTS": sizes.inputs,
        "KEPT": sizes.kept,
        "OUT": sizes.out,
        "State": events.State,
        "take_in": callbacks.take_in,
        "after": after,
        "CALLBACKS": len(CALLBACKS),
        "call_with": addresses.call_with,
        "claimed": addresses.claimed,
        "put_word": addresses.put_word,
        **{f"AT_{key.upper()}": offset for key, offset in at._asdict().items()},
        **dict(classes),
        **memory_access(at),
    }
    word = numba.types.int64
    signature = numba.types.int32(*[word] * 6)
    made_of = partial(c_function, signature=signature, **options(contract=False))
    compiled = from_source(made_of, "advance", source, space, known)
    _kept.append(compiled)
    return compiled.ctypes


_kept: list[Any] = []  # their machine code lives as long as they do
