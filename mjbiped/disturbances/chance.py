"""Random numbers by a seed, and their uses: noise of the sensors of ankle, hip and swing knee, and times of pushes.

The numbers are the same in Python and compiled, in any thread, in whatever order: each is a hash of its seed and of two
numbers (of the tick and of the sensor), so that no generator's state has to be kept. The hash is MurmurHash3's (A.
Appleby, public domain), on words of 32 bits: products are made in halves, for Python's whole numbers never overflow and
compiled ones do.

Angles are those of stance leg, swing leg or thigh and, with knees, swing shank: from the ground's normal, rad.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

from mjbiped.control.controller import Numbers, Room
from mjbiped.numerics.blocks import Floats, numbers

_WORD = 0xFFFFFFFF
_HALF = 0xFFFF
_SPREAD = 0x9E3779B9  # an odd number without pattern: 2^32 over the golden ratio

Channels: TypeAlias = tuple[tuple[int, int, int], tuple[int, int, int]]
"""Channels of noise of ankle, hip and knee: of their angles, and of their rates."""

TICK: Channels = (0, 1, 9), (2, 3, 10)
STRIKE: Channels = (14, 15, 18), (16, 17, 19)
TOUCHDOWN: Channels = (8, 5, 12), (6, 7, 13)  # the ankle that stands and the knee that swings from then on
_OLD_ANKLE, _HIP, _OLD_KNEE = 4, 5, 11  # of the same posture's angles in the old roles

MOST = 3
"""Greatest number of angles: `sensed` writes rates so far behind angles."""

_TIME, _SIGN = 1000, 1001  # channels of chance that no sensor has


class Seed(NamedTuple):
    """A seed as two words of 32 bits; blocks of numbers that have these two fields serve as well."""

    seed_low: int
    seed_high: int


def words_of(seed: int) -> Seed:
    """A seed from 0 to 2^64 - 1 as two words."""
    return Seed(seed & _WORD, seed >> 32)


def uniform(seed: Any, number: int, channel: int) -> float:
    """A uniformly distributed number between 0 and 1, both ends excluded.

    Args:
        seed: `Seed` of the walk.
        number: Index in the channel, from 0 on.
        channel: Numbers of different channels are independent.
    """
    found = _mixed(_mixed(_mixed(_mixed(seed.seed_low, seed.seed_high), channel), number & _WORD), number >> 32)
    return (found + 0.5) / 4294967296.0


def normal(seed: object, number: int, channel: int) -> float:
    """A normally distributed number of mean 0 and deviation 1 (Box and Muller), from two channels of `uniform`."""
    radius = math.sqrt(-2.0 * math.log(uniform(seed, number, 2 * channel)))
    return radius * math.cos(2.0 * math.pi * uniform(seed, number, 2 * channel + 1))


def _mixed(before: int, word: int) -> int:
    """Hash two words of 32 bits into one that depends on all their bits."""
    x = (before ^ word) + _SPREAD & _WORD
    x = _product(x ^ x >> 16, 0x85EBCA6B)
    x = _product(x ^ x >> 13, 0xC2B2AE35)
    return x ^ x >> 16


def _product(x: int, factor: int) -> int:
    """The low 32 bits of a product, computed without exceeding 64 bits."""
    return (x & _HALF) * factor + (((x >> 16) * factor & _HALF) << 16) & _WORD


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


class Pushes(NamedTuple):
    """The pushes of a walk, at given times or at random.

    Attributes:
        times: Times at which pushes begin, s.
        impulses: Impulse of each push, N s.
        listed: Number of these.
        duration: Duration of each push, s.
        size: Impulse of random pushes, N s.
        interval: Mean time between random pushes, s; 0: there are none.
        seed_low: Seed of random pushes.
        seed_high: The same.
    """

    times: Floats
    impulses: Floats
    listed: int
    duration: float
    size: float
    interval: float
    seed_low: int
    seed_high: int


def following(pushes: Pushes, number: int, after: float) -> tuple[float, float]:
    """Time at which a push begins (s), and its impulse (N s); the time is infinite after the last one.

    Args:
        pushes: The `Pushes` of the walk.
        number: Index of the push, from 0 on.
        after: End of the push before it, s.
    """
    if pushes.interval > 0.0:
        size = pushes.size if uniform(pushes, number, _SIGN) < 0.5 else -pushes.size
        return after - pushes.interval * math.log(uniform(pushes, number, _TIME)), size
    if number < pushes.listed:
        times, impulses = numbers(pushes.times, pushes.listed), numbers(pushes.impulses, pushes.listed)
        return float(times[number]), float(impulses[number])
    return math.inf, 0.0
