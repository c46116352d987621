"""Observation and reward of a robot when its next action is due, as plain functions of numbers.

The same source runs in Python and as machine code, after the steps of each robot (`mjbiped.envs.ticks`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, MutableSequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.sensors import MOST, TICK, TOUCHDOWN, Sensors, posture_before, sensed
from mjbiped.engines.mujoco.state import MARK
from mjbiped.numerics.blocks import first
from mjbiped.rules.termination import Outcome

HIP_X, PROGRESS, ECONOMY, REWARD, OUTCOME, SLOPE, FOOT_X, FELT = range(8)
"""Indices in `out`: hip's x (m), terms of the reward, `mjbiped.rules.termination.Outcome`, slope under the stance foot
(rad), the stance foot's x (m), and the first number of the observation."""

(
    TARGET,  # distance that the hip is to go between two actions, m
    SHARE,  # of that time in the average of that distance
    AFFORDED,  # work in that time at which the reward's second term is a half, J
    TICKS,  # of the controller between two actions
    SENSES,  # 1: the sensors err; how, say the numbers from `SENSORS` on
    AVERAGE,  # distance that the hip goes between two actions, averaged, m
    LAST_X,  # hip at the last call, m
    LAST_WORK,  # absolute work up to the last call, J
    LAST_COUNT,  # touchdowns up to the last call
    TICK_NUMBER,  # of the next tick
    SENSORS,  # five numbers of `mjbiped.disturbances.sensors.Sensors`, and its seed's low and high word
) = range(11)

_SHOWN = SENSORS + 7
_BEFORE = _SHOWN + 2 * MOST
_AFTER = _BEFORE + MOST
_KEPT = _AFTER + 2 * MOST
"""Where it is written what is felt: angles (rad) and their rates (rad/s) now, and `MOST` numbers each: angles at the
last touchdown in the old roles, in the new ones, and rates after it."""

PROGRESS_WEIGHT = 0.75
ECONOMY_WEIGHT = 0.25

_ANGLE, _RATE, _TIME, _TORQUE = 10.0, 100.0, 100.0, 1000.0
"""Bounds to which observations are clipped, in rad, rad/s, s and N m; far beyond those of a walk."""

_DIVERGED = float(Outcome.DIVERGED)

_Part = tuple[int, float, float]
"""Size of a part of the observation, and its bounds."""


def _parts(joints: int) -> dict[str, _Part]:
    """Parts of the observation of a robot with so many motors, in their order."""
    return {
        "joint_angles": (joints, -_ANGLE, _ANGLE),
        "joint_rates": (joints, -_RATE, _RATE),
        "touchdown": (1, 0.0, 1.0),
        "time_since_touchdown": (1, 0.0, _TIME),
        "last_touchdown": (2 * joints, -_ANGLE, _ANGLE),
        "torque": (joints, -_TORQUE, _TORQUE),
        **({"knee_locked": (1, 0.0, 1.0)} if joints > 2 else {}),
    }


def observed(joints: int) -> Mapping[str, slice]:
    """Parts of an observation by their places in it; docs/environments.md describes them."""
    ends = np.cumsum([size for size, _, _ in _parts(joints).values()]).tolist()
    return dict(zip(_parts(joints), map(slice, [0, *ends], ends), strict=False))


def bounds(joints: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least and greatest observation."""
    sizes, low, high = zip(*_parts(joints).values(), strict=True)
    return np.repeat(low, sizes), np.repeat(high, sizes)


def sizes_of(joints: int) -> tuple[int, int, int]:
    """Numbers that are given, kept and filled for a robot."""
    return joints, _KEPT, FELT + len(bounds(joints)[0])


def sense_by(sensors: Sensors, kept: NDArray[np.float64]) -> None:
    """Store the errors of a robot's sensors."""
    kept[SENSES] = any(sensors[:5])
    kept[SENSORS:_SHOWN] = sensors


def feel(now: Any, kept: MutableSequence[float], out: MutableSequence[float], joints: int) -> None:
    """Fill in a robot's observation, and its reward since the last call.

    Args:
        now: `State` of its walk as the next tick will find it.
        kept: Numbers of this robot by the indices above, some of which are updated.
        out: Numbers to fill.
        joints: Number of its motors.
    """
    _sense(now, kept, joints)
    sound = _observe(now, kept, out, joints)
    _reward(now, kept, out)
    for index in range(FELT):
        sound = sound and math.isfinite(out[index])
    if not sound:
        for index in range(len(out)):
            out[index] = 0.0
        out[OUTCOME] = _DIVERGED


def _sense(now: Any, kept: MutableSequence[float], joints: int) -> None:
    """Note angles and rates now and angles at the last touchdown, as the sensors show them."""
    for joint in range(joints):
        kept[_SHOWN + joint], kept[_SHOWN + MOST + joint] = now.angles[joint], now.turning[joint]
        kept[_BEFORE + joint], kept[_AFTER + joint] = now.told_before[joint], now.told_q[joint]
    if kept[SENSES] != 0.0:  # what the sensors will show at the next tick, and have shown at the touchdown
        q, dq, before = first(now.angles, joints), first(now.turning, joints), first(now.told_before, joints)
        after, rates_after = first(now.told_q, joints), first(now.told_dq, joints)
        side = 1.0 - 2.0 * now.stance
        sensors = Sensors(
            kept[SENSORS],
            kept[SENSORS + 1],
            kept[SENSORS + 2],
            kept[SENSORS + 3],
            kept[SENSORS + 4],
            int(kept[SENSORS + 5]),
            int(kept[SENSORS + 6]),
        )
        sensed(sensors, side, (int(kept[TICK_NUMBER]), TICK), q, dq, kept, _SHOWN)
        if now.count > 0.0:
            number = int(now.count) - 1
            posture_before(sensors, side, number, before, after, kept, _BEFORE)
            sensed(sensors, side, (number, TOUCHDOWN), after, rates_after, kept, _AFTER)
    kept[TICK_NUMBER] += kept[TICKS]


def _observe(now: Any, kept: MutableSequence[float], out: MutableSequence[float], joints: int) -> bool:
    """Fill in the observation; whether all of it is finite."""
    sound = bool(now.mark == MARK)
    for joint in range(joints):
        at = FELT + joint
        sound = _put(out, at, kept[_SHOWN + joint], _ANGLE) and sound
        sound = _put(out, at + joints, kept[_SHOWN + MOST + joint], _RATE) and sound
        sound = _put(out, at + 2 * joints + 2, kept[_BEFORE + joint], _ANGLE) and sound
        sound = _put(out, at + 3 * joints + 2, kept[_AFTER + joint], _ANGLE) and sound
        sound = _put(out, at + 4 * joints + 2, now.torque[joint], _TORQUE) and sound
    out[FELT + 2 * joints] = 1.0 if now.count > kept[LAST_COUNT] else 0.0
    if joints > 2:
        out[len(out) - 1] = now.locked
    return _put(out, FELT + 2 * joints + 1, now.time - now.transfer_time, _TIME) and sound


def _reward(now: Any, kept: MutableSequence[float], out: MutableSequence[float]) -> None:
    """Fill in the reward and what it consists of."""
    stance = now.q[3] if now.stance else now.q[2]
    hip_x = now.foot_x + now.reach * math.sin(stance + now.tilt)
    work = now.work_absolute - kept[LAST_WORK]
    kept[AVERAGE] += kept[SHARE] * (hip_x - kept[LAST_X] - kept[AVERAGE])
    progress = PROGRESS_WEIGHT * min(max(kept[AVERAGE] / kept[TARGET], 0.0), 1.0)
    economy = ECONOMY_WEIGHT / (1.0 + work / kept[AFFORDED])
    kept[LAST_X], kept[LAST_WORK], kept[LAST_COUNT] = hip_x, now.work_absolute, now.count
    out[HIP_X], out[PROGRESS], out[ECONOMY] = hip_x, progress, economy
    out[REWARD] = progress + economy
    out[OUTCOME], out[SLOPE], out[FOOT_X] = now.outcome, now.slope, now.foot_x


def _put(out: MutableSequence[float], index: int, value: float, bound: float) -> bool:
    """Fill in a number, clipped to a bound in both directions; whether it is finite."""
    out[index] = min(max(value, -bound), bound)
    return math.isfinite(value)
