"""What the sensors of ankle, hip and swing knee show, as functions of plain numbers."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

from mjbiped.disturbances.chance import Seed, normal

Channels: TypeAlias = tuple[tuple[int, int, int], tuple[int, int, int]]
"""Channels of noise of ankle, hip and knee: of their angles, and of their rates."""

TICK: Channels = (0, 1, 9), (2, 3, 10)
STRIKE: Channels = (14, 15, 18), (16, 17, 19)
_TOUCHDOWN: Channels = (8, 5, 12), (6, 7, 13)  # the ankle that stands and the knee that swings from then on
_OLD_ANKLE, _HIP, _OLD_KNEE = 4, 5, 11  # of the same posture's angles in the old roles

Angles: TypeAlias = tuple[float, ...]
"""Stance leg, swing leg or thigh and, with knees, swing shank: from the ground's normal, rad, or their rates, rad/s."""


class Sensors(NamedTuple):
    """Errors of the sensors; the first five have the names that they have in `Disturbances`.

    Attributes:
        angle_noise: Standard deviation of the noise of each joint's angle, rad.
        rate_noise: Standard deviation of the noise of each joint's rate, rad/s.
        angle_bias: Constant error of each joint's angle, rad.
        rate_bias: Constant error of each joint's rate, rad/s.
        angle_resolution: Step of the encoders, rad; 0: none.
        seed: Seed of the noise.
    """

    angle_noise: float
    rate_noise: float
    angle_bias: float
    rate_bias: float
    angle_resolution: float
    seed: Seed


def sensed(
    sensors: Sensors, side: float, number: int, channels: Channels, q: Angles, dq: Angles
) -> tuple[Angles, Angles]:
    """Angles and rates as the sensors of ankle, hip and swing knee show them.

    The hip's sensors show the angle from the left to the right leg.

    Args:
        sensors: Errors of the sensors.
        side: 1: the left leg stands, -1: the right one.
        number: Number of the reading.
        channels: Channels of its noise.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    angles, rates = channels
    ankle = _angle(sensors, q[0], number, angles[0])
    ankle_rate = _rate(sensors, dq[0], number, rates[0])
    if len(q) == 1:
        return (ankle,), (ankle_rate,)
    leg = ankle + side * _angle(sensors, side * (q[1] - q[0]), number, angles[1])
    leg_rate = ankle_rate + side * _rate(sensors, side * (dq[1] - dq[0]), number, rates[1])
    if len(q) == 2:
        return (ankle, leg), (ankle_rate, leg_rate)
    knee = _angle(sensors, q[2] - q[1], number, angles[2])
    knee_rate = _rate(sensors, dq[2] - dq[1], number, rates[2])
    return (ankle, leg, leg + knee), (ankle_rate, leg_rate, leg_rate + knee_rate)


def at_touchdown(
    sensors: Sensors, side: float, number: int, q_before: Angles, q: Angles, dq: Angles
) -> tuple[Angles, Angles, Angles]:
    """Posture in the old roles, in the new ones, and rates, as the same encoders show them at a touchdown.

    Args:
        sensors: Errors of the sensors.
        side: 1: the left leg stands from then on, -1: the right one.
        number: Number of the touchdown.
        q_before: Angles in the old roles, rad.
        q: Angles in the new ones, rad.
        dq: Their rates, rad/s.
    """
    ankle = _angle(sensors, q_before[0], number, _OLD_ANKLE)
    if len(q_before) == 1:
        now = sensed(sensors, side, number, _TOUCHDOWN, q, dq)
        return (ankle,), now[0], now[1]
    leg = ankle - side * _angle(sensors, side * (q[1] - q[0]), number, _HIP)  # one encoder, one reading
    now = sensed(sensors, side, number, _TOUCHDOWN, q, dq)
    if len(q_before) == 2:
        return (ankle, leg), now[0], now[1]
    knee = _angle(sensors, q_before[2] - q_before[1], number, _OLD_KNEE)
    return (ankle, leg, leg + knee), now[0], now[1]


def _angle(sensors: Sensors, angle: float, number: int, channel: int) -> float:
    """Reading of an encoder at an angle, rad."""
    shown = angle + sensors.angle_bias
    if sensors.angle_noise > 0.0:
        shown += sensors.angle_noise * normal(sensors.seed, number, channel)
    if sensors.angle_resolution > 0.0:
        shown = sensors.angle_resolution * math.floor(shown / sensors.angle_resolution + 0.5)
    return shown


def _rate(sensors: Sensors, rate: float, number: int, channel: int) -> float:
    """Reading of a rate sensor, rad/s."""
    shown = rate + sensors.rate_bias
    return shown + sensors.rate_noise * normal(sensors.seed, number, channel) if sensors.rate_noise > 0.0 else shown
