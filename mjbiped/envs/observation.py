"""Observation and reward of a robot when its next action is due, as plain functions of numbers.

The same source runs in Python and as machine code, after the steps of each robot (`mjbiped.envs.walkers`).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.chance import MOST, TICK, TOUCHDOWN, Sensors, posture_before, sensed
from mjbiped.engines.mujoco.state import ANGLES, MARK, State
from mjbiped.numerics.blocks import first, reader
from mjbiped.rules.termination import Outcome

AHEAD = tuple(0.1 * step for step in range(1, 11))
"""Places of the ground that a privileged observation shows, ahead of the stance foot, in leg lengths."""

HIGHEST = 100.0
"""Bound to which heights of observed ground are clipped, m."""

PROGRESS_WEIGHT = 0.75
ECONOMY_WEIGHT = 0.25

_ANGLE, _RATE, _TIME, _TORQUE = 10.0, 100.0, 100.0, 1000.0
"""Bounds to which observations are clipped, in rad, rad/s, s and N m; far beyond those of a walk."""

_DIVERGED, _TIME_LIMIT = float(Outcome.DIVERGED), float(Outcome.TIME_LIMIT)
_BEFORE, _AFTER = 2 * MOST, 3 * MOST
"""Where angles in the old and in the new roles begin among the `readings`."""


class Felt(ctypes.Structure):
    """Numbers of a robot from one action to the next.

    Attributes:
        action: Torques to be added in the next control period, N m.
        ticks: Number of the controller's ticks between two actions.
        last: Number of its last tick in the longest episode.
        target: Distance that the hip is to go between two actions, m.
        share: Share of that time in the average of that distance.
        afforded: Work in that time at which the reward's second term is a half, J.
        senses: Whether the sensors err.
        tick: Number of the controller's next tick.
        average: Distance that the hip goes between two actions, averaged, m.
        work: Absolute work so far, J.
        count: Touchdowns so far.
        readings: Angles and rates now; angles at the last touchdown in the old roles, and in the new; rates then.
        x_position: Place of the hip, m.
        reward_progress: First term of the reward.
        reward_economy: Second term.
        reward: Their sum.
        outcome: `Outcome` as a float.
        slope: Slope of the ground under the stance foot, rad.
        foot_x: Place of the stance foot, m.
        foot_z: Its height, m.
        observation: See `observed`.
    """

    _fields_: ClassVar = [
        ("action", ctypes.c_double * ANGLES),
        *((name, ctypes.c_int64) for name in ("ticks", "last", "senses", "tick")),
        *((name, ctypes.c_double) for name in ("target", "share", "afforded", "average", "work", "count")),
        ("readings", ctypes.c_double * (5 * MOST)),
        *((name, ctypes.c_double) for name in ("x_position", "reward_progress", "reward_economy", "reward")),
        *((name, ctypes.c_double) for name in ("outcome", "slope", "foot_x", "foot_z")),
        ("observation", ctypes.c_double * (5 * ANGLES + 3)),
    ]


felt_at = reader(Felt)


def _parts(joints: int, privileged: bool) -> dict[str, tuple[int, float, float]]:
    """Size and bounds of each part of the observation of a robot with so many motors, in their order."""
    ground = {"ground_slope": (1, -HIGHEST, HIGHEST), "ground_heights": (len(AHEAD), -HIGHEST, HIGHEST)}
    return {
        "joint_angles": (joints, -_ANGLE, _ANGLE),
        "joint_rates": (joints, -_RATE, _RATE),
        "touchdown": (1, 0.0, 1.0),
        "time_since_touchdown": (1, 0.0, _TIME),
        "last_touchdown": (2 * joints, -_ANGLE, _ANGLE),
        "torque": (joints, -_TORQUE, _TORQUE),
        **({"knee_locked": (1, 0.0, 1.0)} if joints > 2 else {}),
        **(ground if privileged else {}),
    }


def observed(joints: int, privileged: bool = False) -> Mapping[str, slice]:
    """Parts of an observation by their places in it; docs/environments.md describes them."""
    parts = _parts(joints, privileged)
    ends = np.cumsum([size for size, _, _ in parts.values()]).tolist()
    return dict(zip(parts, map(slice, [0, *ends], ends), strict=False))


def bounds(joints: int, privileged: bool = False) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least and greatest observation."""
    sizes, low, high = zip(*_parts(joints, privileged).values(), strict=True)
    return np.repeat(low, sizes), np.repeat(high, sizes)


def feel(now: State, felt: Felt, sensors: Sensors, joints: int) -> bool:
    """Fill in a robot's observation, and its reward since the last call.

    Args:
        now: State of its walk as the next tick will find it.
        felt: Its numbers.
        sensors: Errors of its sensors.
        joints: Number of its motors.

    Returns:
        Whether all of them are finite.
    """
    _sense(now, felt, sensors, joints)
    sound = _observe(now, felt, joints)
    _reward(now, felt)
    felt.outcome, felt.slope, felt.foot_x, felt.foot_z = now.outcome, now.slope, now.foot_x, now.foot_z
    if felt.outcome == 0.0 and felt.tick > felt.last:
        felt.outcome = _TIME_LIMIT
    return sound and math.isfinite(felt.x_position + felt.reward + felt.slope + felt.foot_x)


def diverge(felt: Felt) -> None:
    """Tell nothing but that the walk has diverged."""
    felt.x_position = felt.reward_progress = felt.reward_economy = felt.reward = 0.0
    felt.slope = felt.foot_x = felt.foot_z = 0.0
    felt.outcome = _DIVERGED
    for index in range(len(felt.observation)):
        felt.observation[index] = 0.0


def _sense(now: State, felt: Felt, sensors: Sensors, joints: int) -> None:
    """Note angles and rates now and angles at the last touchdown, as the sensors show them."""
    shown = felt.readings
    for joint in range(joints):
        shown[joint], shown[MOST + joint] = now.angles[joint], now.turning[joint]
        shown[_BEFORE + joint], shown[_AFTER + joint] = now.told_before[joint], now.told_q[joint]
    if felt.senses:  # what the sensors will show at the next tick, and have shown at the touchdown
        q, dq, before = first(now.angles, joints), first(now.turning, joints), first(now.told_before, joints)
        after, rates_after = first(now.told_q, joints), first(now.told_dq, joints)
        side = 1.0 - 2.0 * now.stance
        sensed(sensors, side, (felt.tick, TICK), q, dq, shown, 0)
        if now.count > 0.0:
            number = int(now.count) - 1
            posture_before(sensors, side, number, before, after, shown, _BEFORE)
            sensed(sensors, side, (number, TOUCHDOWN), after, rates_after, shown, _AFTER)
    felt.tick += felt.ticks


def _observe(now: State, felt: Felt, joints: int) -> bool:
    """Fill in the observation; whether all of it is finite."""
    shown, sound = felt.readings, bool(now.mark == MARK)
    for joint in range(joints):
        sound = _put(felt, joint, shown[joint], _ANGLE) and sound
        sound = _put(felt, joint + joints, shown[MOST + joint], _RATE) and sound
        sound = _put(felt, joint + 2 * joints + 2, shown[_BEFORE + joint], _ANGLE) and sound
        sound = _put(felt, joint + 3 * joints + 2, shown[_AFTER + joint], _ANGLE) and sound
        sound = _put(felt, joint + 4 * joints + 2, now.torque[joint], _TORQUE) and sound
    felt.observation[2 * joints] = 1.0 if now.count > felt.count else 0.0
    if joints > 2:
        felt.observation[5 * joints + 2] = now.locked
    return _put(felt, 2 * joints + 1, now.time - now.transfer_time, _TIME) and sound


def _reward(now: State, felt: Felt) -> None:
    """Fill in the reward and what it consists of."""
    stance = now.q[3] if now.stance else now.q[2]
    hip_x = now.foot_x + now.reach * math.sin(stance + now.tilt)
    work = now.work_absolute - felt.work
    felt.average += felt.share * (hip_x - felt.x_position - felt.average)
    felt.reward_progress = PROGRESS_WEIGHT * min(max(felt.average / felt.target, 0.0), 1.0)
    felt.reward_economy = ECONOMY_WEIGHT / (1.0 + work / felt.afforded)
    felt.reward = felt.reward_progress + felt.reward_economy
    felt.x_position, felt.work, felt.count = hip_x, now.work_absolute, now.count


def _put(felt: Felt, index: int, value: float, bound: float) -> bool:
    """Fill in a number of the observation, clipped to a bound in both directions; whether it is finite."""
    felt.observation[index] = min(max(value, -bound), bound)
    return math.isfinite(value)
