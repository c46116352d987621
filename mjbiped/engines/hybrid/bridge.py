"""A controller's laws as the hybrid engine calls them: functions of arrays, or C functions of addresses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

from mjbiped.control import adapters
from mjbiped.control.compilation import MachineCode
from mjbiped.control.controller import Controller
from mjbiped.numerics.blocks import call, call_for_float, numbers, packed, reader

Functions = dict[str, Any]
"""The fields of `Constants` that say what the engine calls."""


def methods_of(controller: Controller) -> Functions:
    """The methods of a controller, in plain Python."""
    n = len(controller.joints)

    def torque(law: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
        values = adapters.torque(law, memory, t, tuple(q[:n]), tuple(dq[:n]))
        out[: len(values)] = values

    def touchdown(law: Any, memory: Any, before: Any, q: Any, dq: Any) -> None:
        law.on_touchdown(memory, tuple(before[:n]), tuple(q[:n]), tuple(dq[:n]))

    def tick(law: Any, memory: Any, t: float, q: Any, dq: Any) -> None:
        law.tick(memory, t, tuple(q[:n]), tuple(dq[:n]))

    def knee_strike(law: Any, memory: Any, t: float, q: Any, dq: Any) -> None:
        law.on_knee_strike(memory, t, tuple(q[:n]), tuple(dq[:n]))

    return {
        "torque": torque,
        "touchdown": touchdown,
        "slope_estimate": lambda law, memory: law.slope_estimate(memory),
        "next_discontinuity": lambda law, memory, t: law.next_discontinuity(memory, t),
        "tick": tick,
        "knee_strike": knee_strike,
        "parameters": controller,
    }


@dataclass
class Addresses:
    """Addresses of a law's C functions, and of its parameters."""

    torque: int
    touchdown: int
    slope_estimate: int
    next_discontinuity: int
    record: int
    tick: int
    knee_strike: int


_at = reader(Addresses)


def machine_code_of(code: MachineCode, joints: int) -> tuple[Functions, Any]:
    """The C functions of a compiled law, and what has to live as long as they are called."""
    from mjbiped.numerics.machine import compiled

    law = code.law
    block, kept = packed(
        Addresses(
            law.torque, law.touchdown, law.slope_estimate, law.next_discontinuity, law.record, law.tick, law.knee_strike
        )
    )
    made = {name: compiled(*each, for_c=True) for name, each in _bridges(joints).items()}
    functions: Functions = {name: each.address for name, each in made.items()}
    return {**functions, "parameters": block.ctypes.data}, (block, kept, made, code)


@cache
def _bridges(joints: int) -> dict[str, tuple[Callable[..., Any], str]]:
    number = (None, "one", "two", "three")[joints]
    state, posture = "int64, int64, float64, int64, int64", "int64, int64, int64, int64, int64"
    return {
        "torque": (globals()[f"_torque_{number}"], f"void({state}, int64)"),
        "touchdown": (globals()[f"_touchdown_{number}"], f"void({posture})"),
        "tick": (globals()[f"_tick_{number}"], f"void({state})"),
        "knee_strike": (globals()[f"_strike_{number}"], f"void({state})"),
        "slope_estimate": (_slope, "float64(int64, int64)"),
        "next_discontinuity": (_next, "float64(int64, int64, float64)"),
    }


def _slope(p: int, m: int) -> float:
    return call_for_float(_at(p, 0).slope_estimate, _at(p, 0).record, m, 0.0)


def _next(p: int, m: int, t: float) -> float:
    return call_for_float(_at(p, 0).next_discontinuity, _at(p, 0).record, m, t)


def _torque_one(p: int, m: int, t: float, qs: int, dqs: int, out: int) -> None:
    q, dq = numbers(qs, 1), numbers(dqs, 1)
    call(_at(p, 0).torque, _at(p, 0).record, m, t, q[0], dq[0], out)


def _torque_two(p: int, m: int, t: float, qs: int, dqs: int, out: int) -> None:
    q, dq = numbers(qs, 2), numbers(dqs, 2)
    call(_at(p, 0).torque, _at(p, 0).record, m, t, q[0], q[1], dq[0], dq[1], out)


def _torque_three(p: int, m: int, t: float, qs: int, dqs: int, out: int) -> None:
    q, dq = numbers(qs, 3), numbers(dqs, 3)
    call(_at(p, 0).torque, _at(p, 0).record, m, t, q[0], q[1], q[2], dq[0], dq[1], dq[2], out)


def _touchdown_one(p: int, m: int, bs: int, qs: int, dqs: int) -> None:
    b, q, dq = numbers(bs, 1), numbers(qs, 1), numbers(dqs, 1)
    call(_at(p, 0).touchdown, _at(p, 0).record, m, b[0], q[0], dq[0])


def _touchdown_two(p: int, m: int, bs: int, qs: int, dqs: int) -> None:
    b, q, dq = numbers(bs, 2), numbers(qs, 2), numbers(dqs, 2)
    call(_at(p, 0).touchdown, _at(p, 0).record, m, b[0], b[1], q[0], q[1], dq[0], dq[1])


def _touchdown_three(p: int, m: int, bs: int, qs: int, dqs: int) -> None:
    b, q, dq = numbers(bs, 3), numbers(qs, 3), numbers(dqs, 3)
    call(_at(p, 0).touchdown, _at(p, 0).record, m, b[0], b[1], b[2], q[0], q[1], q[2], dq[0], dq[1], dq[2])


def _tick_one(p: int, m: int, t: float, qs: int, dqs: int) -> None:
    q, dq = numbers(qs, 1), numbers(dqs, 1)
    call(_at(p, 0).tick, _at(p, 0).record, m, t, q[0], dq[0])


def _tick_two(p: int, m: int, t: float, qs: int, dqs: int) -> None:
    q, dq = numbers(qs, 2), numbers(dqs, 2)
    call(_at(p, 0).tick, _at(p, 0).record, m, t, q[0], q[1], dq[0], dq[1])


def _tick_three(p: int, m: int, t: float, qs: int, dqs: int) -> None:
    q, dq = numbers(qs, 3), numbers(dqs, 3)
    call(_at(p, 0).tick, _at(p, 0).record, m, t, q[0], q[1], q[2], dq[0], dq[1], dq[2])


def _strike_one(p: int, m: int, t: float, qs: int, dqs: int) -> None:
    q, dq = numbers(qs, 1), numbers(dqs, 1)
    call(_at(p, 0).knee_strike, _at(p, 0).record, m, t, q[0], dq[0])


def _strike_two(p: int, m: int, t: float, qs: int, dqs: int) -> None:
    q, dq = numbers(qs, 2), numbers(dqs, 2)
    call(_at(p, 0).knee_strike, _at(p, 0).record, m, t, q[0], q[1], dq[0], dq[1])


def _strike_three(p: int, m: int, t: float, qs: int, dqs: int) -> None:
    q, dq = numbers(qs, 3), numbers(dqs, 3)
    call(_at(p, 0).knee_strike, _at(p, 0).record, m, t, q[0], q[1], q[2], dq[0], dq[1], dq[2])
