"""A disturbed control loop at its ticks, at touchdowns and at knee strikes, as functions of arrays.

`mjbiped.disturbances.sampled` calls them with a controller's methods, `mjbiped.disturbances.compiled` with its machine
code. The loop's own memory stands behind the controller's: `at` counts from there. Its last part is room, from the
index `Loop.shown` on: for what the sensors show, and behind that for what the controller's law writes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from mjbiped.control.controller import Numbers, Room
from mjbiped.disturbances.sensors import MOST, STRIKE, TICK, TOUCHDOWN, Sensors, posture_before, sensed

(
    TICKS,  # so far
    TOUCHDOWNS,  # so far
    SIDE,  # 1: the left leg stands, -1: the right one
    BEGUN,  # first of the torques that the motors have at the tick's beginning, N m, one for each joint
) = range(4)

SHOWN = 3 * MOST
"""Room for what the sensors show."""


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
        shown: Index in the loop's memory of what the sensors show, `SHOWN` numbers: angles (rad), rates (rad/s), and at
            a touchdown the angles in the old roles. Behind these the law writes.
        senses: Whether the sensors differ from the truth.
        torque_limit: Greatest torque of each motor, N m; infinity: none.
        remaining: Fraction of the difference between commanded and actual torque that is left after a tick; 0: no lag.
        mean: Mean of that fraction over the tick.
        sensors: Errors of the sensors.
    """

    size: int
    joints: int
    held: int
    rates: int
    states: int
    ring: int
    room: int
    delay: int
    shown: int
    senses: bool
    torque_limit: float
    remaining: float
    mean: float
    sensors: Sensors


def tick(ask: Callable[..., None], law: Any, loop: Loop, memory: Room, t: float, q: Numbers, dq: Numbers) -> None:
    """Read the sensors, ask the law, and set the torques that are held until the next tick.

    Args:
        ask: (law, memory, t, q, dq, place): writes what the law's `torque` gives into the memory, from an index on.
        law: Parameters of the law.
        loop: Parameters of the loop.
        memory: Memory, whose part behind the controller's is changed in place.
        t: Time since the support transfer, s.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    at, place = loop.size, loop.size + loop.shown
    values = place + SHOWN
    if loop.senses:
        number, n = int(memory[at + TICKS]), len(q)
        sensed(loop.sensors, memory[at + SIDE], (number, TICK), q, dq, memory, place)
        ask(law, memory, t, memory[place : place + n], memory[place + MOST : place + MOST + n], values)
    else:
        ask(law, memory, t, q, dq, values)
    for joint in range(loop.joints):
        _drive(loop, memory, joint, memory[values + joint])
    for index in range(loop.states):
        memory[at + loop.rates + index] = memory[values + loop.joints + index]
    memory[at + TICKS] += 1.0


def _drive(loop: Loop, memory: Room, joint: int, torque: float) -> None:
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
    tell: Callable[..., None], law: Any, loop: Loop, memory: Room, q_before: Numbers, q: Numbers, dq: Numbers
) -> None:
    """Exchange the motors' roles at a support transfer, read the sensors, and tell the controller.

    Args:
        tell: (law, memory, q_before, q, dq): tells the law.
        law: Parameters of the law.
        loop: Parameters of the loop.
        memory: Memory, changed in place.
        q_before: Angles in the old roles, rad.
        q: Angles in the new ones, rad.
        dq: Their rates, rad/s.
    """
    number, n, place = _exchanged(loop, memory), len(q), loop.size + loop.shown
    if not loop.senses:
        tell(law, memory, q_before, q, dq)
        return
    side, before = memory[loop.size + SIDE], place + 2 * MOST
    posture_before(loop.sensors, side, number, q_before, q, memory, before)
    sensed(loop.sensors, side, (number, TOUCHDOWN), q, dq, memory, place)
    rates = place + MOST
    tell(law, memory, memory[before : before + n], memory[place : place + n], memory[rates : rates + n])


def knee_strike(
    tell: Callable[..., None], law: Any, loop: Loop, memory: Room, t: float, q: Numbers, dq: Numbers
) -> None:
    """Read the sensors when the swing knee strikes its stop, and tell the controller; motors hold their torques.

    Args:
        tell: (law, memory, t, q, dq): tells the law.
        law: Parameters of the law.
        loop: Parameters of the loop.
        memory: Memory, changed in place.
        t: Time since the support transfer, s.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    if not loop.senses:
        tell(law, memory, t, q, dq)
        return
    number, n, place = int(memory[loop.size + TOUCHDOWNS]), len(q), loop.size + loop.shown
    sensed(loop.sensors, memory[loop.size + SIDE], (number, STRIKE), q, dq, memory, place)
    tell(law, memory, t, memory[place : place + n], memory[place + MOST : place + MOST + n])


def _exchanged(loop: Loop, memory: Room) -> int:
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


def _reassign(loop: Loop, memory: Room, first: int) -> None:
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
