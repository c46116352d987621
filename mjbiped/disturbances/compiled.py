"""The laws of a `SampledController` for compilation: the loop's, around a controller's machine code.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

from typing import NamedTuple

from mjbiped.control import machine_code
from mjbiped.control.controller import Law, Memory, never
from mjbiped.control.machine_code import CompiledLaw, halves, thirds
from mjbiped.disturbances import loop as laws
from mjbiped.disturbances.loop import Loop
from mjbiped.numerics.addresses import floats_at


class Parts(NamedTuple):
    """Parameters of the disturbed loop's laws.

    Attributes:
        inner: The controller's machine code.
        loop: The loop's parameters.
    """

    inner: CompiledLaw
    loop: Loop


def law_of(inner: CompiledLaw, loop: Loop) -> Law:
    """The laws of a disturbed loop; the caller keeps the inner machine code alive."""
    return Law(Parts(inner, loop), _torque, _touchdown, _slope_estimate, never, _tick, _knee_strike)


def _torque(parts: Parts, memory: Memory, *_: float) -> tuple[float, ...]:
    held: tuple[float, ...] = floats_at(memory, parts.loop.size + parts.loop.held, parts.inner.values)
    return held


def _tick(parts: Parts, memory: Memory, t: float, *state: float) -> None:
    q, dq = halves(state)
    laws.tick(machine_code.torque, parts.inner, parts.loop, memory, t, q, dq)


def _touchdown(parts: Parts, memory: Memory, *postures: float) -> None:
    q_before, q, dq = thirds(postures)
    q_before, q, dq = laws.touchdown(parts.loop, memory, q_before, q, dq)
    machine_code.touchdown(parts.inner, memory, q_before, q, dq)


def _knee_strike(parts: Parts, memory: Memory, t: float, *state: float) -> None:
    q, dq = halves(state)
    q, dq = laws.knee_strike(parts.loop, memory, q, dq)
    machine_code.knee_strike(parts.inner, memory, t, q, dq)


def _slope_estimate(parts: Parts, memory: Memory) -> float:
    return machine_code.slope_estimate(parts.inner, memory)
