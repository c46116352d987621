"""A disturbed control loop at its ticks, at touchdowns and at knee strikes, as functions of plain numbers.

`mjbiped.disturbances.sampled` calls them with a controller's methods, `mjbiped.disturbances.compiled` with its machine
code. The loop's own memory stands behind the controller's: `at` counts from there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence
from typing import Any, NamedTuple, TypeAlias

from mjbiped.disturbances.chance import Seed, normal

(
    TICKS,  # so far
    TOUCHDOWNS,  # so far
    SIDE,  # 1: the left leg stands, -1: the right one
    BEGUN,  # first of the torques that the motors have at the tick's beginning, N m, one for each joint
) = range(4)

Channels: TypeAlias = tuple[tuple[int, int, int], tuple[int, int, int]]
"""Channels of noise of ankle, hip and knee: of their angles, and of their rates."""

_TICK: Channels = (0, 1, 9), (2, 3, 10)
_TOUCHDOWN: Channels = (8, 5, 12), (6, 7, 13)  # the ankle that stands and the knee that swings from then on
_OLD_ANKLE, _HIP, _OLD_KNEE = 4, 5, 11  # of the same posture's angles in the old roles
_STRIKE: Channels = (14, 15, 18), (16, 17, 19)

Angles: TypeAlias = tuple[float, ...]
"""Stance leg, swing leg or thigh and, with knees, swing shank: from the ground's normal, rad, or their rates, rad/s."""


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
        angle_noise: Standard deviation of the noise of each joint's angle, rad.
        rate_noise: Standard deviation of the noise of each joint's rate, rad/s.
        angle_bias: Constant error of each joint's angle, rad.
        rate_bias: Constant error of each joint's rate, rad/s.
        angle_resolution: Step of the encoders, rad; 0: none.
        torque_limit: Greatest torque of each motor, N m; infinity: none.
        remaining: Fraction of the difference between commanded and actual torque that is left after a tick; 0: no lag.
        mean: Mean of that fraction over the tick.
        seed: Seed of the noise.
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
    angle_noise: float
    rate_noise: float
    angle_bias: float
    rate_bias: float
    angle_resolution: float
    torque_limit: float
    remaining: float
    mean: float
    seed: Seed


def tick(
    ask: Callable[..., Any],
    law: Any,
    loop: Loop,
    memory: MutableSequence[float],
    t: float,
    q: Angles,
    dq: Angles,
) -> None:
    """Read the sensors, ask the law, and set the torques that are held until the next tick.

    Args:
        ask: The law's `torque`.
        law: Its parameters.
        loop: The loop's.
        memory: To be changed, behind the controller's part.
        t: Time since the support transfer, s.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    if loop.senses:
        number = int(memory[loop.size + TICKS])
        q, dq = _sensed(loop, memory, number, _TICK, q, dq)
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
    """Take notice of a support transfer, and read the posture that the controller is told of it.

    Returns:
        The posture in the old roles, in the new ones, and the rates.
    """
    number = _exchanged(loop, memory)
    if not loop.senses:
        return q_before, q, dq
    ankle = read_angle(loop, q_before[0], number, _OLD_ANKLE)
    if len(q_before) == 1:
        now = _sensed(loop, memory, number, _TOUCHDOWN, q, dq)
        return (ankle,), now[0], now[1]
    side = memory[loop.size + SIDE]
    leg = ankle - side * read_angle(loop, side * (q[1] - q[0]), number, _HIP)  # one encoder, one reading
    now = _sensed(loop, memory, number, _TOUCHDOWN, q, dq)
    if len(q_before) == 2:
        return (ankle, leg), now[0], now[1]
    knee = read_angle(loop, q_before[2] - q_before[1], number, _OLD_KNEE)
    return (ankle, leg, leg + knee), now[0], now[1]


def knee_strike(loop: Loop, memory: MutableSequence[float], q: Angles, dq: Angles) -> tuple[Angles, Angles]:
    """Read what the controller is told when the swing knee strikes its stop; the motors hold what they have."""
    if not loop.senses:
        return q, dq
    number = int(memory[loop.size + TOUCHDOWNS])
    return _sensed(loop, memory, number, _STRIKE, q, dq)


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


def _sensed(
    loop: Loop, memory: MutableSequence[float], number: int, channels: Channels, q: Angles, dq: Angles
) -> tuple[Angles, Angles]:
    """Angles and rates as the sensors of ankle, hip and swing knee show them.

    The hip's sensors show the angle from the left to the right leg.

    Args:
        loop: The loop's parameters.
        memory: Tells which leg stands.
        number: Of the reading.
        channels: Of its noise.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    angles, rates = channels
    ankle = read_angle(loop, q[0], number, angles[0])
    ankle_rate = read_rate(loop, dq[0], number, rates[0])
    if len(q) == 1:
        return (ankle,), (ankle_rate,)
    side = memory[loop.size + SIDE]
    leg = ankle + side * read_angle(loop, side * (q[1] - q[0]), number, angles[1])
    leg_rate = ankle_rate + side * read_rate(loop, side * (dq[1] - dq[0]), number, rates[1])
    if len(q) == 2:
        return (ankle, leg), (ankle_rate, leg_rate)
    knee = read_angle(loop, q[2] - q[1], number, angles[2])
    knee_rate = read_rate(loop, dq[2] - dq[1], number, rates[2])
    return (ankle, leg, leg + knee), (ankle_rate, leg_rate, leg_rate + knee_rate)


def read_angle(loop: Loop, angle: float, number: int, channel: int) -> float:
    """Reading of an encoder at an angle, rad."""
    shown = angle + loop.angle_bias
    if loop.angle_noise > 0.0:
        shown += loop.angle_noise * normal(loop.seed, number, channel)
    if loop.angle_resolution > 0.0:
        shown = loop.angle_resolution * math.floor(shown / loop.angle_resolution + 0.5)
    return shown


def read_rate(loop: Loop, rate: float, number: int, channel: int) -> float:
    """Reading of a rate sensor, rad/s."""
    shown = rate + loop.rate_bias
    return shown + loop.rate_noise * normal(loop.seed, number, channel) if loop.rate_noise > 0.0 else shown


def limited(loop: Loop, torque: float) -> float:
    """A torque cut to the motor's limit, N m; NaN stays NaN."""
    if torque > loop.torque_limit:
        return loop.torque_limit
    return -loop.torque_limit if torque < -loop.torque_limit else torque
