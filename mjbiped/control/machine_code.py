"""Calls of a law's C functions by their addresses, from compiled engines whose states are tuples.

`CompiledLaw` stands in the place of a law's parameters there, and the functions of this module in that of its
functions. This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

from typing import TypeAlias

from mjbiped.control.compiled import CompiledLaw
from mjbiped.control.controller import ROOM, Memory
from mjbiped.numerics.addresses import call, call_for_number, call_for_values

Angles: TypeAlias = tuple[float, ...]
"""A number for each of the robot's angles: q, rad, or dq, rad/s."""


def torque(law: CompiledLaw, memory: Memory, t: float, q: Angles, dq: Angles) -> tuple[float, ...]:
    """Call `Law.torque` by its address; return torques and rates."""
    found: tuple[float, ...] = call_for_values(law.torque, (law.record, memory, t, q, dq), law.values, ROOM)
    return found


def touchdown(law: CompiledLaw, memory: Memory, q_before: Angles, q: Angles, dq: Angles) -> None:
    """Call `Law.touchdown` by its address."""
    call(law.touchdown, (law.record, memory, q_before, q, dq))


def slope_estimate(law: CompiledLaw, memory: Memory) -> float:
    """Call `Law.slope_estimate` by its address."""
    return float(call_for_number(law.slope_estimate, (law.record, memory)))


def next_discontinuity(law: CompiledLaw, memory: Memory, t: float) -> float:
    """Call `Law.next_discontinuity` by its address."""
    return float(call_for_number(law.next_discontinuity, (law.record, memory, t)))


def tick(law: CompiledLaw, memory: Memory, t: float, q: Angles, dq: Angles) -> None:
    """Call `Law.tick`, which there must be, by its address."""
    call(law.tick, (law.record, memory, t, q, dq))


def knee_strike(law: CompiledLaw, memory: Memory, t: float, q: Angles, dq: Angles) -> None:
    """Call `Law.knee_strike`, which there must be, by its address."""
    call(law.knee_strike, (law.record, memory, t, q, dq))


LAWS = (torque, touchdown, slope_estimate, next_discontinuity, tick, knee_strike)
"""What an engine calls of compiled laws, in the order of `mjbiped.control.adapters.LAWS`."""
