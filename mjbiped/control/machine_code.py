"""A controller's laws as machine code of their own, which engines call by address.

An engine compiled around a law has to be compiled again with every other law, which takes ten times as long as the law
itself. So each law becomes C functions, and the engines call what stands at the addresses that they are given: one
machine code of an engine serves many controllers. `CompiledLaw` stands in the place of a law's
parameters, and the functions of this module in that of its functions.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from mjbiped.control.controller import Memory
from mjbiped.numerics.addresses import call_at, call_for_nothing, call_torque

Angles: TypeAlias = tuple[float, ...]
"""A number for each of the robot's angles: q, rad, or dq, rad/s."""


class CompiledLaw(NamedTuple):
    """Addresses of a law's machine code and parameters. The C functions take angles and rates one by one.

    Attributes:
        torque: Address of the C function (record, memory, t, q1, ..., dq1, ..., out).
        touchdown: Address of (record, memory, q1 before, ..., q1, ..., dq1, ...).
        slope_estimate: Address of (record, memory, t) -> float; the time means nothing.
        next_discontinuity: Address of (record, memory, t) -> float.
        record: Address of the parameters, a `mjbiped.numerics.records.Packer`'s record.
        values: Zeros, at least as many as `torque` returns numbers: a tuple's length is part of its type.
        tick: Address of (record, memory, t, q1, ..., dq1, ...); 0: the law has none.
        knee_strike: Address of (record, memory, t, q1, ..., dq1, ...); 0: the law has none.
    """

    torque: int
    touchdown: int
    slope_estimate: int
    next_discontinuity: int
    record: int
    values: tuple[float, ...]
    tick: int = 0
    knee_strike: int = 0


def halves(state: Angles) -> tuple[Angles, Angles]:
    """Split a state into angles and rates; compiled code needs slices with constant bounds."""
    if len(state) == 2:
        return state[:1], state[1:]
    return (state[:2], state[2:]) if len(state) == 4 else (state[:3], state[3:])


def thirds(postures: Angles) -> tuple[Angles, Angles, Angles]:
    """Split postures into angles before a touchdown, angles after it, and rates."""
    if len(postures) == 3:
        return postures[:1], postures[1:2], postures[2:]
    if len(postures) == 6:
        return postures[:2], postures[2:4], postures[4:]
    return postures[:3], postures[3:6], postures[6:]


def torque(law: CompiledLaw, memory: Memory, t: float, q: Angles, dq: Angles) -> tuple[float, ...]:
    """Call `Law.torque` by its address."""
    found: tuple[float, ...] = call_torque(law.torque, law.record, memory, (t, *q, *dq), law.values)
    return found


def touchdown(law: CompiledLaw, memory: Memory, q_before: Angles, q: Angles, dq: Angles) -> None:
    """Call `Law.touchdown` by its address."""
    call_for_nothing(law.touchdown, law.record, memory, (*q_before, *q, *dq))


def slope_estimate(law: CompiledLaw, memory: Memory) -> float:
    """Call `Law.slope_estimate` by its address."""
    return float(call_at(law.slope_estimate, law.record, memory, 0.0))


def next_discontinuity(law: CompiledLaw, memory: Memory, t: float) -> float:
    """Call `Law.next_discontinuity` by its address."""
    return float(call_at(law.next_discontinuity, law.record, memory, t))


def tick(law: CompiledLaw, memory: Memory, t: float, q: Angles, dq: Angles) -> None:
    """Call `Law.tick`, which there must be, by its address."""
    call_for_nothing(law.tick, law.record, memory, (t, *q, *dq))


def knee_strike(law: CompiledLaw, memory: Memory, t: float, q: Angles, dq: Angles) -> None:
    """Call `Law.knee_strike`, which there must be, by its address."""
    call_for_nothing(law.knee_strike, law.record, memory, (t, *q, *dq))


LAWS = (torque, touchdown, slope_estimate, next_discontinuity, tick, knee_strike)
"""What an engine calls of compiled laws, in the order of `mjbiped.control.adapters.LAWS`."""
