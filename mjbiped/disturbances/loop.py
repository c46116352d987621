"""A disturbed control loop at its ticks, at touchdowns and at knee strikes, as functions of plain numbers.

`mjbiped.disturbances.sampled` calls them with a controller's methods, `mjbiped.disturbances.compiled` with its machine
code. The loop's own memory stands behind the controller's: `at` counts from there.
"""

from __future__ import annotations

from collections.abc import Callable, MutableSequence
from typing import Any, NamedTuple

from mjbiped.disturbances.sensors import STRIKE, TICK, Angles, Sensors, at_touchdown, sensed

(
    TICKS,  # so far
    TOUCHDOWNS,  # so far
    SIDE,  # 1: the left leg stands, -1: the right one
    BEGUN,  # first of the torques that the motors have at the tick's beginning, N m, one for each joint
) = range(4)


class Loop(NamedTuple):
    """Parameters of a disturbed loop.

    Attributes:
        size: Number of floats of the controller's memory; the loop's memory begins behind them.
        joints: Number of motors: ankle, hip and, with knees, the swing knee.
        held: Index in the loop's memory of the torques held until the next tick, N m.
        rates: Index of the held rates of the controller's integrated states, right behind the torques.
        states: Number of integrated states.
        ring: Index in the loop's memory of the delayed torques, those of all joints in turn.
        room: Number of ticks whose torques the ring holds.
        delay: Number of ticks until a torque acts.
        senses: Whether the sensors differ from the truth.
        sensors: Errors of the sensors.
        torque_limit: Greatest torque of each motor, N m; infinity: none.
        remaining: Fraction of the difference between commanded and actual torque that is left after a tick; 0: no lag.
        mean: Mean of that fraction over the tick.
    """

    size: int
    joints: int
    held: int
    rates: int
    states: int
    ring: int
    room: int
    delay: int
    senses: bool
    sensors: Sensors
    torque_limit: float
    remaining: float
    mean: float


def tick(
    ask: Callable[..., Any], law: Any, loop: Loop, memory: MutableSequence[float], t: float, q: Angles, dq: Angles
) -> None:
    """Read the sensors, ask the law, and set the torques that are held until the next tick.

    Args:
        ask: The law's `torque`.
        law: Parameters of the law.
        loop: Parameters of the loop.
        memory: Memory, whose part behind the controller's is changed in place.
        t: Time since the support transfer, s.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    if loop.senses:
        number = int(memory[loop.size + TICKS])
        q, dq = sensed(loop.sensors, memory[loop.size + SIDE], number, TICK, q, dq)
    values = ask(law, memory, t, q, dq)
    for joint in range(loop.joints):
        _drive(loop, memory, joint, values[joint])
    at = loop.size
    for index in range(loop.states):
        memory[at + loop.rates + index] = values[loop.joints + index]
    memory[at + TICKS] += 1.0


def _drive(loop: Loop, memory: MutableSequence[float], joint: int, torque: float) -> None:
    """Pass a commanded torque through the motor's limit, delay and lag."""
    at = loop.size
    number = int(memory[at + TICKS])
    asked, begun, held = limited(loop, torque), at + BEGUN + joint, at + loop.held + joint
    if loop.delay > 0:
        first = at + loop.ring + joint
        memory[first + loop.joints * (number % loop.room)] = asked
        asked = memory[first + loop.joints * ((number - loop.delay) % loop.room)]  # zeros at the beginning
    if loop.remaining > 0.0:
        memory[held] = limited(loop, asked + (memory[begun] - asked) * loop.mean)
        memory[begun] = asked + (memory[begun] - asked) * loop.remaining
    else:
        memory[held] = asked


def touchdown(
    loop: Loop, memory: MutableSequence[float], q_before: Angles, q: Angles, dq: Angles
) -> tuple[Angles, Angles, Angles]:
    """Exchange the motors' roles at a support transfer, and read the sensors for the controller.

    Returns:
        The posture in the old roles, in the new ones, and the rates.
    """
    number = _exchanged(loop, memory)
    if not loop.senses:
        return q_before, q, dq
    return at_touchdown(loop.sensors, memory[loop.size + SIDE], number, q_before, q, dq)


def knee_strike(loop: Loop, memory: MutableSequence[float], q: Angles, dq: Angles) -> tuple[Angles, Angles]:
    """Read the sensors for the controller when the swing knee strikes its stop; the motors hold their torques."""
    if not loop.senses:
        return q, dq
    number = int(memory[loop.size + TOUCHDOWNS])
    return sensed(loop.sensors, memory[loop.size + SIDE], number, STRIKE, q, dq)


def _exchanged(loop: Loop, memory: MutableSequence[float]) -> int:
    """Give the legs their new roles, and return the number of the touchdown.

    The motors are those of the hip and of each leg's ankle and knee: what still waits for the ankle that leaves the
    ground, or for the knee that is locked now, moves nothing, and a torque between the legs has the other sign in
    their new roles.
    """
    at = loop.size
    memory[at + SIDE] = -memory[at + SIDE]
    for first in (at + BEGUN, at + loop.held):
        _reassign(loop, memory, first)
    for tick in range(loop.room):
        _reassign(loop, memory, at + loop.ring + loop.joints * tick)
    number = int(memory[at + TOUCHDOWNS])
    memory[at + TOUCHDOWNS] = number + 1.0
    return number


def _reassign(loop: Loop, memory: MutableSequence[float], first: int) -> None:
    """Exchange the roles of the torques of ankle, hip and swing knee, as many as there are, from an index on."""
    memory[first] = 0.0
    if loop.joints > 1:
        memory[first + 1] = -memory[first + 1]
    if loop.joints > 2:
        memory[first + 2] = 0.0


def limited(loop: Loop, torque: float) -> float:
    """Clip a torque to the motor's limit, N m; NaN stays NaN."""
    if torque > loop.torque_limit:
        return loop.torque_limit
    return -loop.torque_limit if torque < -loop.torque_limit else torque
