"""What a disturbed control loop does at its ticks and at a touchdown, as functions of plain numbers.

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

_ANKLE_ANGLE, _HIP_ANGLE, _ANKLE_RATE, _HIP_RATE = 0, 1, 2, 3  # channels of noise, at ticks
_AT_TOUCHDOWN = 4  # and as many from here on at touchdowns
_NEW_ANKLE = 8  # the encoder of the ankle that stands from then on
_KNEE_ANGLE = 9  # of the swing knee at ticks; the next one is its rate's
_OLD_KNEE, _NEW_KNEE = 11, 12  # at touchdowns, of the knee that swung and of the one that swings, 13 its rate's
_AT_STRIKE, _KNEE_AT_STRIKE = 14, 18  # as at ticks, where the knee strikes its stop

Angles: TypeAlias = tuple[float, ...]
"""Stance leg, swing leg or thigh and, with knees, swing shank: from the ground's normal, rad, or their rates, rad/s."""


class Loop(NamedTuple):
    """What does not change in a disturbed loop.

    Attributes:
        size: Floats of the controller's memory; the loop's memory begins behind them.
        joints: Number of motors: ankle, hip and, with knees, the swing knee.
        held: Index in the loop's memory of the torques held until the next tick, N m; right behind them are ...
        rates: ... the held rates of the controller's integrated states.
        states: Number of these.
        ring: Index in the loop's memory of the torques that wait, those of all joints in turn.
        room: For so many ticks there is room.
        delay: Ticks until a torque acts.
        senses: Whether the sensors differ from the truth.
        angle_noise: See `Disturbances`, as for what follows.
        rate_noise: The same.
        angle_bias: The same.
        rate_bias: The same.
        angle_resolution: The same.
        torque_limit: The same; infinity: none.
        remaining: Share of a torque's deviation from what is asked for that is left after a tick; 0: the motor has no
            lag.
        mean: The same in the mean over the tick.
        seed: Of the noise.
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
        q, dq = _limbs(loop, memory, number, _ANKLE_ANGLE, _ANKLE_ANGLE, _KNEE_ANGLE, q, dq)
    values = ask(law, memory, t, q, dq)
    for joint in range(loop.joints):
        _drive(loop, memory, joint, values[joint])
    at = loop.size
    for index in range(loop.states):
        memory[at + loop.rates + index] = values[loop.joints + index]
    memory[at + TICKS] += 1.0


def _drive(loop: Loop, memory: MutableSequence[float], joint: int, torque: float) -> None:
    """Give a motor what the law asks of it, through limit, delay and lag."""
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
    ankle = read_angle(loop, q_before[0], number, _AT_TOUCHDOWN + _ANKLE_ANGLE)
    hip, _ = _hip(loop, memory, number, _AT_TOUCHDOWN, q[1] - q[0], dq[1] - dq[0])  # of the same posture
    now = _limbs(loop, memory, number, _AT_TOUCHDOWN, _NEW_ANKLE, _NEW_KNEE, q, dq)
    if len(q_before) == 2:
        return (ankle, ankle - hip), now[0], now[1]
    knee = read_angle(loop, q_before[2] - q_before[1], number, _OLD_KNEE)
    return (ankle, ankle - hip, ankle - hip + knee), now[0], now[1]


def knee_strike(loop: Loop, memory: MutableSequence[float], q: Angles, dq: Angles) -> tuple[Angles, Angles]:
    """Read what the controller is told when the swing knee strikes its stop; the motors hold what they have."""
    if not loop.senses:
        return q, dq
    number = int(memory[loop.size + TOUCHDOWNS])
    return _limbs(loop, memory, number, _AT_STRIKE, _AT_STRIKE + _ANKLE_ANGLE, _KNEE_AT_STRIKE, q, dq)


def _exchanged(loop: Loop, memory: MutableSequence[float]) -> int:
    """Give the legs their new roles; returns the number of the touchdown.

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
    """Torques of ankle, hip and, with knees, swing knee in the new roles; the first one's index is given."""
    memory[first], memory[first + 1] = 0.0, -memory[first + 1]
    if loop.joints > 2:
        memory[first + 2] = 0.0


def _limbs(
    loop: Loop,
    memory: MutableSequence[float],
    number: int,
    channel: int,
    ankle_channel: int,
    knee_channel: int,
    q: Angles,
    dq: Angles,
) -> tuple[Angles, Angles]:
    """Angles and rates as the sensors of ankle, hip and swing knee show them.

    Args:
        loop: The loop's parameters.
        memory: Tells which leg stands.
        number: Of the reading.
        channel: The first of the four channels of noise of ankle and hip, but
        ankle_channel: for the ankle's angle.
        knee_channel: For the knee's angle; the next one is its rate's.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    ankle = read_angle(loop, q[0], number, ankle_channel)
    ankle_rate = read_rate(loop, dq[0], number, channel + _ANKLE_RATE)
    hip, hip_rate = _hip(loop, memory, number, channel, q[1] - q[0], dq[1] - dq[0])
    leg, leg_rate = ankle + hip, ankle_rate + hip_rate
    if len(q) == 2:
        return (ankle, leg), (ankle_rate, leg_rate)
    knee = read_angle(loop, q[2] - q[1], number, knee_channel)
    knee_rate = read_rate(loop, dq[2] - dq[1], number, knee_channel + 1)
    return (ankle, leg, leg + knee), (ankle_rate, leg_rate, leg_rate + knee_rate)


def _hip(
    loop: Loop, memory: MutableSequence[float], number: int, channel: int, angle: float, rate: float
) -> tuple[float, float]:
    """What the hip's sensors, from the left to the right leg, show of the angle from stance to swing leg."""
    side = memory[loop.size + SIDE]
    hip_angle = side * read_angle(loop, side * angle, number, channel + _HIP_ANGLE)
    return hip_angle, side * read_rate(loop, side * rate, number, channel + _HIP_RATE)


def read_angle(loop: Loop, angle: float, number: int, channel: int) -> float:
    """What an encoder shows of an angle, rad."""
    shown = angle + loop.angle_bias
    if loop.angle_noise > 0.0:
        shown += loop.angle_noise * normal(loop.seed, number, channel)
    if loop.angle_resolution > 0.0:
        shown = loop.angle_resolution * math.floor(shown / loop.angle_resolution + 0.5)
    return shown


def read_rate(loop: Loop, rate: float, number: int, channel: int) -> float:
    """What a sensor shows of a rate, rad/s."""
    shown = rate + loop.rate_bias
    return shown + loop.rate_noise * normal(loop.seed, number, channel) if loop.rate_noise > 0.0 else shown


def limited(loop: Loop, torque: float) -> float:
    """A torque within the motor's limit, N m; one that is no number stays so."""
    if torque > loop.torque_limit:
        return loop.torque_limit
    return -loop.torque_limit if torque < -loop.torque_limit else torque
