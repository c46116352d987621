"""The walk's step as machine code: MuJoCo's stages by their names, and `mjcb_control` as a C function.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from mjbiped.engines.mujoco import step
from mjbiped.engines.mujoco.callback import FARTHEST, FOREIGN, PAIRS, PLACES, addressed, place_of, table
from mjbiped.engines.mujoco.constants import constants_at
from mjbiped.numerics import machine
from mjbiped.numerics.blocks import call, numbers, reader
from mjbiped.utils.mujoco import mujoco

llvm: Any = importlib.import_module("llvmlite.binding")
TABLE = "mjbiped_walks"
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
    llvm.add_symbol(TABLE, table.ctypes.data)
    machine.defined(walks, lambda *_: machine.types.int64, _address_of_table)


def _address_of_table(_context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
    """Generate the address of what is called `TABLE`."""
    ir = machine.ir
    named = machine.cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), TABLE)
    return builder.ptrtoint(named, ir.IntType(64))


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


def walks() -> int:
    """Address of `callback.table`; in machine code that of the name `TABLE`, as what is kept on disk needs."""
    return int(table.ctypes.data)


def control_of(model: int, data: int) -> None:
    """`mjcb_control`, by addresses."""
    at, first = walks(), place_of(data)
    for far in range(word_at(at, FARTHEST).value + 1):
        entry = PAIRS + 2 * ((first + far) % PLACES)
        if word_at(at, entry).value == data:
            c = constants_at(word_at(at, entry + 1).value, 0)
            step.on_control(c, numbers(c.time, 1)[0])
            return
    foreign = word_at(at, FOREIGN).value
    if foreign != 0:
        call(foreign, model, data)


@cache
def control_callback() -> Any:
    """`mjcb_control` as a C function, and its address, for all walks in machine code."""
    define_stages()
    return addressed(machine.compiled(control_of, "void(int64, int64)", for_c=True).ctypes)


class Word(NamedTuple):
    """A word in C's memory.

    Attributes:
        value: As an integer.
    """

    value: int


word_at = reader(Word)
