"""The walk's step as machine code: MuJoCo's stages by their names, and `mjcb_control` as a C function.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import ctypes
import importlib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from mjbiped.engines.mujoco import step
from mjbiped.engines.mujoco.callback import addressed
from mjbiped.engines.mujoco.state import MARK, constants_at, state_at
from mjbiped.numerics import machine
from mjbiped.numerics.blocks import numbers, reader
from mjbiped.utils.mujoco import mujoco

llvm: Any = importlib.import_module("llvmlite.binding")
VELOCITY = int(mujoco.mjtStage.mjSTAGE_VEL)

_STAGES = {
    step.check: (("mj_checkPos",), ("mj_checkVel",)),
    step.position: (("mj_fwdPosition",), ("mj_sensorPos",)),
    step.velocity: (("mj_fwdVelocity",), ("mj_sensorVel",)),
    step.forward_from_velocity: (("mj_forwardSkip", VELOCITY, 0),),
    step.integrate: (("mj_checkAcc",), ("mj_Euler",)),
}


@cache
def define_stages() -> None:
    """Let machine code call MuJoCo's stages by their names, in the library that Python's bindings have loaded."""
    (library,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    llvm.load_library_permanently(str(library))
    for stage, calls in _STAGES.items():
        machine.defined(stage, lambda *_: machine.types.void, _calling(calls))


def _calling(calls: Any) -> Any:
    """Generate calls of MuJoCo's functions with model, data, and integers."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        ir = machine.ir
        whole = ir.IntType(32)
        for name, *more in calls:
            kind = ir.FunctionType(ir.VoidType(), [*(each.type for each in arguments), *[whole] * len(more)])
            function = machine.cgutils.get_or_insert_function(builder.module, kind, name)
            builder.call(function, [*arguments, *(whole(each) for each in more)])
        return context.get_dummy_value()

    return generate


def advance(constants: int, model: int, data: int, steps: int, until: float) -> int:
    """`step.advance` by addresses."""
    return step.advance(constants_at(constants, 0), model, data, steps, until)


@cache
def advancing() -> Any:
    """`advance` as machine code."""
    define_stages()
    return machine.compiled(advance, "int64(int64, int64, int64, int64, float64)")


def place_of_userdata(data: mujoco.MjData) -> int:
    """Where the address of its userdata stands in an mjData, words of 64 bits from its beginning.

    An empty array has the address of the one behind it, and the addresses stand in the order of the arrays: so the last
    one counts of those that are the same.
    """

    def word(index: int) -> int:
        return ctypes.c_int64.from_address(data._address + 8 * index).value

    sought, index = data.userdata.ctypes.data, 0
    while word(index) != sought:
        index += 1
    while word(index + 1) == sought:
        index += 1
    return index


@cache
def control_callback(userdata: int) -> Any:
    """`mjcb_control` as a C function, and its address, for all walks in machine code; other models are left alone.

    Args:
        userdata: See `place_of_userdata`.
    """
    define_stages()

    def on_control(model: int, data: int) -> None:  # noqa: ARG001 (MuJoCo gives both)
        u = state_at(word_at(data, userdata).value, 0)
        if u.mark == MARK and u.walk > 0.0:
            c = constants_at(int(u.walk), 0)
            if c.data == data:
                step.on_control(c, numbers(c.time, 1)[0])

    return addressed(machine.compiled(on_control, "void(int64, int64)", for_c=True).ctypes)


class Word(NamedTuple):
    """A word in C's memory.

    Attributes:
        value: As an integer.
    """

    value: int


word_at = reader(Word)
