"""The laws of a `SampledController` for compilation: the loop's, around a controller's machine code.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

from typing import Any

from mjbiped.control.compiled import CompiledLaw
from mjbiped.control.controller import Law, Memory, Numbers, Room, never
from mjbiped.disturbances import loop as laws
from mjbiped.disturbances.loop import Loop
from mjbiped.disturbances.sensors import Sensors
from mjbiped.numerics.addresses import call, call_for_number

TORQUE, TOUCHDOWN, SLOPE_ESTIMATE, KNEE_STRIKE, RECORD, LOOP = range(6)
"""Indices in the parameters of the addresses of the inner law, and of the first number of the loop."""

_SENSORS = LOOP + len(Loop._fields) - 1


def law_of(inner: CompiledLaw, loop: Loop) -> Law:
    """Return the laws of a disturbed loop; the caller keeps the inner machine code alive."""
    addresses = inner.torque, inner.touchdown, inner.slope_estimate, inner.knee_strike, inner.record
    sensors = *loop.sensors[:-1], *loop.sensors.seed
    parameters = [float(each) for each in (*addresses, *loop[:-1], *sensors)]
    return Law(parameters, _torque, _touchdown, _slope_estimate, never, _tick, _knee_strike)


def _torque(parameters: Numbers, memory: Memory, _t: float, _q: Numbers, _dq: Numbers, out: Room) -> None:
    loop = _loop(parameters)
    first = loop.size + loop.held
    for index in range(loop.joints + loop.states):
        out[index] = memory[first + index]


def _tick(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    laws.tick(_ask, parameters, _loop(parameters), memory, t, q, dq)


def _touchdown(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    laws.touchdown(_tell_touchdown, parameters, _loop(parameters), memory, q_before, q, dq)


def _knee_strike(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    laws.knee_strike(_tell_strike, parameters, _loop(parameters), memory, t, q, dq)


def _slope_estimate(parameters: Numbers, memory: Memory) -> float:
    return float(call_for_number(int(parameters[SLOPE_ESTIMATE]), (int(parameters[RECORD]), memory)))


def _ask(parameters: Any, memory: Any, t: float, q: Any, dq: Any, place: int) -> None:
    """Call the inner law's `torque`, which writes into the memory."""
    call(int(parameters[TORQUE]), (int(parameters[RECORD]), memory, t, q, dq, memory[place:]))


def _tell_touchdown(parameters: Any, memory: Any, q_before: Any, q: Any, dq: Any) -> None:
    call(int(parameters[TOUCHDOWN]), (int(parameters[RECORD]), memory, q_before, q, dq))


def _tell_strike(parameters: Any, memory: Any, t: float, q: Any, dq: Any) -> None:
    call(int(parameters[KNEE_STRIKE]), (int(parameters[RECORD]), memory, t, q, dq))


def _loop(p: Numbers) -> Loop:
    """Return the loop's parameters, from among those of the law."""
    k = _SENSORS
    seed = int(p[k + 5]), int(p[k + 6])
    return Loop(
        int(p[LOOP]),
        int(p[LOOP + 1]),
        int(p[LOOP + 2]),
        int(p[LOOP + 3]),
        int(p[LOOP + 4]),
        int(p[LOOP + 5]),
        int(p[LOOP + 6]),
        int(p[LOOP + 7]),
        int(p[LOOP + 8]),
        p[LOOP + 9] != 0.0,
        p[LOOP + 10],
        p[LOOP + 11],
        p[LOOP + 12],
        Sensors(p[k], p[k + 1], p[k + 2], p[k + 3], p[k + 4], seed),
    )
