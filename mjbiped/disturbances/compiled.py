"""The laws of a `SampledController` for compilation: the loop's, around a controller's machine code.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

from typing import NamedTuple

from mjbiped.control import machine_code
from mjbiped.control.controller import Law, Memory, never
from mjbiped.control.machine_code import CompiledLaw
from mjbiped.disturbances import loop as laws
from mjbiped.disturbances.loop import Loop
from mjbiped.numerics.addresses import floats_at


class Parts(NamedTuple):
    """Parameters of these laws.

    Attributes:
        inner: The controller's machine code.
        loop: The loop's.
    """

    inner: CompiledLaw
    loop: Loop


def law_of(inner: CompiledLaw, loop: Loop, *, knees: bool) -> Law:
    """The laws of a disturbed loop; whoever has them keeps the inner machine code."""
    parts = Parts(inner, loop)
    if knees:
        return Law(parts, _torque, _knees_touchdown, _slope_estimate, never, _knees_tick, _knee_strike)
    return Law(parts, _torque, _touchdown, _slope_estimate, never, _tick)


def _torque(parts: Parts, memory: Memory, *_: float) -> tuple[float, ...]:
    held: tuple[float, ...] = floats_at(memory, parts.loop.size + parts.loop.held, parts.inner.values)
    return held


def _tick(parts: Parts, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float) -> None:
    laws.tick(machine_code.torque, parts.inner, parts.loop, memory, t, q1, q2, dq1, dq2)


def _touchdown(
    parts: Parts,
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> None:
    told = laws.touchdown(parts.loop, memory, q1_before, q2_before, q1, q2, dq1, dq2)
    machine_code.touchdown(parts.inner, memory, told[0], told[1], told[2], told[3], told[4], told[5])


def _knees_tick(
    parts: Parts, memory: Memory, t: float, q1: float, q2: float, q3: float, dq1: float, dq2: float, dq3: float
) -> None:
    laws.knees_tick(machine_code.knees_torque, parts.inner, parts.loop, memory, t, q1, q2, q3, dq1, dq2, dq3)


def _knees_touchdown(
    parts: Parts,
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q3_before: float,
    q1: float,
    q2: float,
    q3: float,
    dq1: float,
    dq2: float,
    dq3: float,
) -> None:
    a, b, c, d, e, f, g, h, i = laws.knees_touchdown(
        parts.loop, memory, q1_before, q2_before, q3_before, q1, q2, q3, dq1, dq2, dq3
    )
    machine_code.knees_touchdown(parts.inner, memory, a, b, c, d, e, f, g, h, i)


def _knee_strike(
    parts: Parts, memory: Memory, t: float, q1: float, q2: float, q3: float, dq1: float, dq2: float, dq3: float
) -> None:
    q1, q2, q3, dq1, dq2, dq3 = laws.knee_strike(parts.loop, memory, q1, q2, q3, dq1, dq2, dq3)
    machine_code.knee_strike(parts.inner, memory, t, q1, q2, q3, dq1, dq2, dq3)


def _slope_estimate(parts: Parts, memory: Memory) -> float:
    return machine_code.slope_estimate(parts.inner, memory)
