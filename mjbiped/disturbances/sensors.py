"""What the sensors of ankle, hip and swing knee show, as functions of arrays.

Angles are those of stance leg, swing leg or thigh and, with knees, swing shank: from the ground's normal, rad.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

from mjbiped.control.controller import Numbers, Room
from mjbiped.disturbances.chance import normal

Channels: TypeAlias = tuple[tuple[int, int, int], tuple[int, int, int]]
"""Channels of noise of ankle, hip and knee: of their angles, and of their rates."""

TICK: Channels = (0, 1, 9), (2, 3, 10)
STRIKE: Channels = (14, 15, 18), (16, 17, 19)
TOUCHDOWN: Channels = (8, 5, 12), (6, 7, 13)  # the ankle that stands and the knee that swings from then on
_OLD_ANKLE, _HIP, _OLD_KNEE = 4, 5, 11  # of the same posture's angles in the old roles

MOST = 3
"""Greatest number of angles: `sensed` writes rates so far behind angles."""


class Sensors(NamedTuple):
    """Errors of the sensors; the first five have the names that they have in `Disturbances`.

    Attributes:
        angle_noise: Standard deviation of the noise of each joint's angle, rad.
        rate_noise: Standard deviation of the noise of each joint's rate, rad/s.
        angle_bias: Constant error of each joint's angle, rad.
        rate_bias: Constant error of each joint's rate, rad/s.
        angle_resolution: Step of the encoders, rad; 0: none.
        seed_low: Seed of the noise.
        seed_high: The same.
    """

    angle_noise: float
    rate_noise: float
    angle_bias: float
    rate_bias: float
    angle_resolution: float
    seed_low: int
    seed_high: int


def sensed(
    sensors: Sensors, side: float, reading: tuple[int, Channels], q: Numbers, dq: Numbers, shown: Room, place: int
) -> None:
    """Write angles and rates as the sensors of ankle, hip and swing knee show them.

    The hip's sensors show the angle from the left to the right leg.

    Args:
        sensors: Errors of the sensors, `Sensors`.
        side: 1: the left leg stands, -1: the right one.
        reading: Number of the reading, and channels of its noise.
        q: Angles, rad.
        dq: Their rates, rad/s.
        shown: Receives the angles from an index on, and the rates `MOST` behind them.
        place: That index.
    """
    number, (angles, rates) = reading
    shown[place] = _angle(sensors, q[0], number, angles[0])
    shown[place + MOST] = _rate(sensors, dq[0], number, rates[0])
    if len(q) > 1:
        shown[place + 1] = shown[place] + side * _angle(sensors, side * (q[1] - q[0]), number, angles[1])
        turning = side * _rate(sensors, side * (dq[1] - dq[0]), number, rates[1])
        shown[place + MOST + 1] = shown[place + MOST] + turning
    if len(q) > 2:
        shown[place + 2] = shown[place + 1] + _angle(sensors, q[2] - q[1], number, angles[2])
        shown[place + MOST + 2] = shown[place + MOST + 1] + _rate(sensors, dq[2] - dq[1], number, rates[2])


def posture_before(
    sensors: Sensors, side: float, number: int, q_before: Numbers, q: Numbers, shown: Room, place: int
) -> None:
    """Write the posture of a touchdown in the old roles, as the encoders show it.

    Args:
        sensors: Errors of the sensors, `Sensors`.
        side: 1: the left leg stands from then on, -1: the right one.
        number: Number of the touchdown.
        q_before: Angles in the old roles, rad.
        q: Angles in the new ones, rad.
        shown: Receives the angles from an index on.
        place: That index.
    """
    shown[place] = _angle(sensors, q_before[0], number, _OLD_ANKLE)
    if len(q_before) > 1:  # one encoder, one reading
        shown[place + 1] = shown[place] - side * _angle(sensors, side * (q[1] - q[0]), number, _HIP)
    if len(q_before) > 2:
        shown[place + 2] = shown[place + 1] + _angle(sensors, q_before[2] - q_before[1], number, _OLD_KNEE)


def _angle(sensors: Sensors, angle: float, number: int, channel: int) -> float:
    """Reading of an encoder at an angle, rad."""
    shown: float = angle + sensors.angle_bias
    if sensors.angle_noise > 0.0:
        shown += sensors.angle_noise * normal(sensors, number, channel)
    if sensors.angle_resolution > 0.0 and math.isfinite(shown):
        shown = sensors.angle_resolution * math.floor(shown / sensors.angle_resolution + 0.5)
    return shown


def _rate(sensors: Sensors, rate: float, number: int, channel: int) -> float:
    """Reading of a rate sensor, rad/s."""
    shown: float = rate + sensors.rate_bias
    return shown + sensors.rate_noise * normal(sensors, number, channel) if sensors.rate_noise > 0.0 else shown
