"""The walk's step as machine code: MuJoCo's stages by their names, and `mjcb_control` as a C function.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path
from typing import Any

from mjbiped.engines.mujoco import step
from mjbiped.engines.mujoco.callback import FARTHEST, FOREIGN, PAIRS, PLACES, addressed, place_of, table
from mjbiped.engines.mujoco.constants import constants_at
from mjbiped.numerics import machine
from mjbiped.numerics.blocks import call, numbers
from mjbiped.utils.mujoco import mujoco

llvm: Any = importlib.import_module("llvmlite.binding")
TABLE = "mjbiped_walks"
_STAGES = (
    *("mj_checkPos", "mj_checkVel", "mj_fwdPosition", "mj_sensorPos", "mj_fwdVelocity", "mj_sensorVel"),
    *("mj_forwardSkip", "mj_checkAcc", "mj_Euler"),
)


@cache
def define_stages() -> None:
    """Let machine code call MuJoCo's stages by their names, in the library that Python's bindings have loaded."""
    (library,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    llvm.load_library_permanently(str(library))
    for name in _STAGES:
        machine.defined(getattr(mujoco, name), lambda *_: machine.types.void, _calling(name))
    llvm.add_symbol(TABLE, table.ctypes.data)
    machine.defined(walks, lambda *_: _table_kind(), _named_table)


def _table_kind() -> Any:
    return machine.types.Array(machine.types.int64, 1, "C")


def _named_table(context: Any, builder: Any, _signature: object, _arguments: object) -> Any:
    """Generate an array of what is called `TABLE`."""
    ir, size = machine.ir, context.get_constant(machine.types.intp, len(table))
    named = machine.cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), TABLE)
    return machine.owning_nothing(context, builder, _table_kind(), builder.ptrtoint(named, ir.IntType(64)), size)


def _calling(name: str) -> Any:
    """Generate calls of one of MuJoCo's functions with the addresses of model and data, and integers."""

    def generate(context: Any, builder: Any, _signature: object, arguments: Any) -> Any:
        ir = machine.ir
        passed = [*arguments[:2], *(builder.trunc(each, ir.IntType(32)) for each in arguments[2:])]
        kind = ir.FunctionType(ir.VoidType(), [each.type for each in passed])
        builder.call(machine.cgutils.get_or_insert_function(builder.module, kind, name), passed)
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


def walks() -> Any:
    """`callback.table`; in machine code what is called `TABLE`, as what is kept on disk needs."""
    return table


def control_of(model: int, data: int) -> None:
    """`mjcb_control`, by addresses."""
    entries, first = walks(), place_of(data)
    for far in range(entries[FARTHEST] + 1):
        entry = PAIRS + 2 * ((first + far) % PLACES)
        if entries[entry] == data:
            c = constants_at(entries[entry + 1], 0)
            step.on_control(c, numbers(c.time, 1)[0])
            return
    if entries[FOREIGN] != 0:
        call(entries[FOREIGN], model, data)


@cache
def control_callback() -> Any:
    """`mjcb_control` as a C function, and its address, for all walks in machine code."""
    define_stages()
    return addressed(machine.compiled(control_of, "void(int64, int64)", for_c=True).ctypes)
