"""What a disturbed control loop does at its ticks and at a touchdown, as functions of plain numbers.

`mjbiped.disturbances.sampled` calls them with a controller's methods, `mjbiped.disturbances.compiled` with its machine
code. The loop's own memory stands behind the controller's: `at` counts from there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence
from typing import Any, NamedTuple

from mjbiped.disturbances.chance import Seed, normal

(
    TICKS,  # so far
    TOUCHDOWNS,  # so far
    SIDE,  # 1: the left leg stands, -1: the right one
    ANKLE_BEGUN,  # torques that the motors have at the tick's beginning, N m
    HIP_BEGUN,
    ANKLE,  # torques held until the next tick, N m
    HIP,
    RATES,  # first of the held rates of the controller's states, as many as it has
) = range(8)

_ANKLE_ANGLE, _HIP_ANGLE, _ANKLE_RATE, _HIP_RATE = 0, 1, 2, 3  # channels of noise, at ticks
_AT_TOUCHDOWN = 4  # and as many from here on at touchdowns
_NEW_ANKLE = 8  # the encoder of the ankle that stands from then on

Reading = tuple[float, float, float, float]
"""Stance and swing leg from the ground's normal, rad, and their rates, rad/s."""


class Loop(NamedTuple):
    """What does not change in a disturbed loop.

    Attributes:
        size: Floats of the controller's memory; the loop's memory begins behind them.
        states: Number of its integrated states.
        ring: Index in the loop's memory of the torques that wait, ankle and hip in turn.
        room: So many pairs have room there.
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
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> None:
    """Read the sensors, ask the law, and set the torques that are held until the next tick.

    Args:
        ask: The law's `torque`.
        law: Its parameters.
        loop: The loop's.
        memory: To be changed, behind the controller's part.
        t: Time since the support transfer, s.
        q1: Stance leg, rad.
        q2: Swing leg, rad.
        dq1: Their rates, rad/s.
        dq2: The same.
    """
    at = loop.size
    number = int(memory[at + TICKS])
    if loop.senses:
        side = memory[at + SIDE]
        ankle_angle = read_angle(loop, q1, number, _ANKLE_ANGLE)
        hip_angle = side * read_angle(loop, side * (q2 - q1), number, _HIP_ANGLE)
        ankle_rate = read_rate(loop, dq1, number, _ANKLE_RATE)
        hip_rate = side * read_rate(loop, side * (dq2 - dq1), number, _HIP_RATE)
        q1, q2, dq1, dq2 = ankle_angle, ankle_angle + hip_angle, ankle_rate, ankle_rate + hip_rate
    values = ask(law, memory, t, q1, q2, dq1, dq2)
    for index in range(loop.states):
        memory[at + RATES + index] = values[2 + index]
    ankle, hip = limited(loop, values[0]), limited(loop, values[1])
    if loop.delay > 0:
        slot = at + loop.ring + 2 * (number % loop.room)
        memory[slot], memory[slot + 1] = ankle, hip
        slot = at + loop.ring + 2 * ((number - loop.delay) % loop.room)  # zeros at the beginning
        ankle, hip = memory[slot], memory[slot + 1]
    if loop.remaining > 0.0:
        memory[at + ANKLE] = limited(loop, ankle + (memory[at + ANKLE_BEGUN] - ankle) * loop.mean)
        memory[at + HIP] = limited(loop, hip + (memory[at + HIP_BEGUN] - hip) * loop.mean)
        memory[at + ANKLE_BEGUN] = ankle + (memory[at + ANKLE_BEGUN] - ankle) * loop.remaining
        memory[at + HIP_BEGUN] = hip + (memory[at + HIP_BEGUN] - hip) * loop.remaining
    else:
        memory[at + ANKLE], memory[at + HIP] = ankle, hip
    memory[at + TICKS] = number + 1.0


def touchdown(
    loop: Loop,
    memory: MutableSequence[float],
    q1_before: float,
    q2_before: float,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> tuple[float, float, float, float, float, float]:
    """Take notice of a support transfer, and read the posture that the controller is told of it.

    The motors are those of the left ankle, the right ankle and the hip: what still waits for the ankle that leaves the
    ground moves nothing, and a torque between the legs has the other sign in their new roles.

    Returns:
        The posture in the old roles, in the new ones, and the rates.
    """
    at = loop.size
    memory[at + SIDE] = -memory[at + SIDE]
    memory[at + ANKLE], memory[at + HIP] = 0.0, -memory[at + HIP]
    memory[at + ANKLE_BEGUN], memory[at + HIP_BEGUN] = 0.0, -memory[at + HIP_BEGUN]
    for slot in range(at + loop.ring, at + loop.ring + 2 * loop.room, 2):
        memory[slot], memory[slot + 1] = 0.0, -memory[slot + 1]
    number = int(memory[at + TOUCHDOWNS])
    memory[at + TOUCHDOWNS] = number + 1.0
    if not loop.senses:
        return q1_before, q2_before, q1, q2, dq1, dq2
    side = memory[at + SIDE]
    old_ankle = read_angle(loop, q1_before, number, _AT_TOUCHDOWN + _ANKLE_ANGLE)
    new_ankle = read_angle(loop, q1, number, _NEW_ANKLE)
    hip_angle = side * read_angle(loop, side * (q2 - q1), number, _AT_TOUCHDOWN + _HIP_ANGLE)  # of the same posture
    ankle_rate = read_rate(loop, dq1, number, _AT_TOUCHDOWN + _ANKLE_RATE)
    hip_rate = side * read_rate(loop, side * (dq2 - dq1), number, _AT_TOUCHDOWN + _HIP_RATE)
    return old_ankle, old_ankle - hip_angle, new_ankle, new_ankle + hip_angle, ankle_rate, ankle_rate + hip_rate


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
