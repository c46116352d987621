"""Steps of robots until their next action is due, and the observations and rewards after them, as plain functions.

The same source runs in Python and as machine code, for the robots of `mjbiped.envs.walkers`.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.chance import MOST, TICK, TOUCHDOWN, Sensors, posture_before, sensed
from mjbiped.disturbances.loop import sensors_at
from mjbiped.engines.mujoco.constants import constants_at
from mjbiped.engines.mujoco.state import ANGLES, MARK, State, state_at
from mjbiped.engines.mujoco.step import advance_ticks, look_ahead, warned
from mjbiped.numerics.blocks import Floats, Numbers, first, numbers, reader
from mjbiped.rules.termination import Outcome

AHEAD = tuple(0.1 * step for step in range(1, 11))
"""Places of the ground that a privileged observation shows, ahead of the stance foot, in leg lengths."""

HIGHEST = 100.0
"""Bound to which heights of observed ground are clipped, m."""

PROGRESS_WEIGHT, ECONOMY_WEIGHT = 0.75, 0.25

_ANGLE, _RATE, _TIME, _TORQUE = 10.0, 100.0, 100.0, 1000.0
"""Bounds to which observations are clipped, in rad, rad/s, s and N m; far beyond those of a walk."""

_DIVERGED, _TIME_LIMIT = float(Outcome.DIVERGED), float(Outcome.TIME_LIMIT)
BEFORE, AFTER = 2 * MOST, 3 * MOST
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


class Field(NamedTuple):
    """A part of the observation; `FIELDS` has all of them in their order.

    Attributes:
        name: Its name, by which dm_control's observations and `observed` have it.
        each: Numbers for each joint with a motor.
        more: Numbers besides.
        low: Least value; smaller ones are clipped.
        high: Greatest value.
        meaning: What it is, with its unit.
        of: "all" robots, those with "knees", or "privileged" tasks.
    """

    name: str
    each: int
    more: int
    low: float
    high: float
    meaning: str
    of: str = "all"


_LEGS = "angles of stance and swing leg, rad; with knees of stance leg, swing thigh and swing shank"
_LAST = (
    "angles at the last touchdown, rad: in the old roles from the old ground's normal, then in the new roles from the "
    "new normal"
)
_LOCKED = "1 once the swing knee has struck its stop and is locked, else 0"
_HEIGHTS = "height of the ground 0.1, 0.2, ... 1.0 leg lengths ahead of the stance foot, relative to the foot, m"

FIELDS = (
    Field("joint_angles", 1, 0, -_ANGLE, _ANGLE, _LEGS),
    Field("joint_rates", 1, 0, -_RATE, _RATE, "their rates, rad/s"),
    Field("touchdown", 0, 1, 0.0, 1.0, "1 if the swing foot touched down in the last control period, else 0"),
    Field("time_since_touchdown", 0, 1, 0.0, _TIME, "time since the last touchdown, or since the start, s"),
    Field("last_touchdown", 2, 0, -_ANGLE, _ANGLE, _LAST),
    Field("torque", 1, 0, -_TORQUE, _TORQUE, "torques that the joints hold, N m"),
    Field("knee_locked", 0, 1, 0.0, 1.0, _LOCKED, "knees"),
    Field("ground_slope", 0, 1, -HIGHEST, HIGHEST, "slope under the stance foot, rad, positive downhill", "privileged"),
    Field("ground_heights", 0, len(AHEAD), -HIGHEST, HIGHEST, _HEIGHTS, "privileged"),
)
"""What a policy observes."""


def fields_of(joints: int, privileged: bool = False) -> dict[Field, slice]:
    """Fields of the observation of a robot with so many motors, by their places in it."""
    found = {"all", *(["knees"] if joints > 2 else []), *(["privileged"] if privileged else [])}
    fields = [field for field in FIELDS if field.of in found]
    ends = np.cumsum([field.each * joints + field.more for field in fields]).tolist()
    return dict(zip(fields, map(slice, [0, *ends], ends), strict=False))


def observed(joints: int, privileged: bool = False) -> Mapping[str, slice]:
    """Parts of an observation by their places in it."""
    return {field.name: place for field, place in fields_of(joints, privileged).items()}


def bounds(joints: int, privileged: bool = False) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least and greatest observation."""
    fields = fields_of(joints, privileged)
    sizes = [place.stop - place.start for place in fields.values()]
    return np.repeat([field.low for field in fields], sizes), np.repeat([field.high for field in fields], sizes)


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
    since, touched = now.time - now.transfer_time, now.count > felt.count
    sound = observe(felt.observation, joints, felt.readings, now.torque, since, touched, now.locked)
    _reward(now, felt)
    felt.outcome, felt.slope, felt.foot_x, felt.foot_z = now.outcome, now.slope, now.foot_x, now.foot_z
    if felt.outcome == 0.0 and felt.tick > felt.last:
        felt.outcome = _TIME_LIMIT
    return sound and now.mark == MARK and math.isfinite(felt.x_position + felt.reward + felt.slope + felt.foot_x)


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
        shown[BEFORE + joint], shown[AFTER + joint] = now.told_before[joint], now.told_q[joint]
    if felt.senses:  # what the sensors will show at the next tick, and have shown at the touchdown
        q, dq, before = first(now.angles, joints), first(now.turning, joints), first(now.told_before, joints)
        after, rates_after = first(now.told_q, joints), first(now.told_dq, joints)
        side = 1.0 - 2.0 * now.stance
        sensed(sensors, side, (felt.tick, TICK), q, dq, shown, 0)
        if now.count > 0.0:
            number = int(now.count) - 1
            posture_before(sensors, side, number, before, after, shown, BEFORE)
            sensed(sensors, side, (number, TOUCHDOWN), after, rates_after, shown, AFTER)
    felt.tick += felt.ticks


def observe(
    seen: Floats, joints: int, shown: Numbers, torque: Numbers, since: float, touched: bool, locked: float
) -> bool:
    """Fill in an observation.

    Args:
        seen: Its numbers, in the order of `FIELDS`.
        joints: Number of motors.
        shown: What the sensors show, as `Felt.readings`.
        torque: Torques that the joints hold, N m.
        since: Time since the touchdown, s.
        touched: Whether it was in the last control period.
        locked: 1 if the swing knee is locked.

    Returns:
        Whether all numbers are finite.
    """
    sound = _put(seen, 2 * joints + 1, since, _TIME)
    for joint in range(joints):
        sound = _put(seen, joint, shown[joint], _ANGLE) and sound
        sound = _put(seen, joint + joints, shown[MOST + joint], _RATE) and sound
        sound = _put(seen, joint + 2 * joints + 2, shown[BEFORE + joint], _ANGLE) and sound
        sound = _put(seen, joint + 3 * joints + 2, shown[AFTER + joint], _ANGLE) and sound
        sound = _put(seen, joint + 4 * joints + 2, torque[joint], _TORQUE) and sound
    seen[2 * joints] = 1.0 if touched else 0.0
    if joints > 2:
        seen[5 * joints + 2] = locked
    return sound


def _reward(now: State, felt: Felt) -> None:
    """Fill in the reward and what it consists of."""
    stance = now.q[3] if now.stance else now.q[2]
    hip_x = now.foot_x + now.reach * math.sin(stance + now.tilt)
    work = now.work_absolute - felt.work
    felt.average += felt.share * (hip_x - felt.x_position - felt.average)
    felt.reward_progress = progress_reward(felt.average, felt.target)
    felt.reward_economy = economy_reward(work, felt.afforded)
    felt.reward = felt.reward_progress + felt.reward_economy
    felt.x_position, felt.work, felt.count = hip_x, now.work_absolute, now.count


def progress_reward(speed: float, target: float) -> float:
    """Part of the reward for walking at a speed, of a target in the same unit."""
    return PROGRESS_WEIGHT * min(max(speed / target, 0.0), 1.0)


def economy_reward(work: float, afforded: float) -> float:
    """Part of the reward for little work in a control period, J, of a work that halves it."""
    return ECONOMY_WEIGHT / (1.0 + work / afforded)


def _put(seen: Floats, index: int, value: float, bound: float) -> bool:
    """Fill in a number of the observation, clipped to a bound in both directions; whether it is finite."""
    seen[index] = min(max(value, -bound), bound)
    return math.isfinite(value)


class Row(NamedTuple):
    """A robot of many, as machine code sees it.

    Attributes:
        constants: Its walk's, alone in a list; see `mjbiped.engines.mujoco.constants.Constants`.
        ahead: The same for a look ahead; see `mjbiped.engines.mujoco.step.look_ahead`.
        model: Its mjModel.
        data: Its mjData.
        felt: Its numbers, alone in a list.
        sensors: Errors of its sensors, alone in a list.
        place: Index of the action in its controller's memory.
    """

    constants: object
    ahead: Any
    model: object
    data: object
    felt: object
    sensors: object
    place: int


row_at = reader(Row)


def advance_rows(rows: object, first: int, last: int, ticks: int) -> None:
    """Step robots to a later tick of their controllers, and fill in what they feel then.

    Args:
        rows: All robots.
        first: Number of the first one that is stepped.
        last: Number behind the last one.
        ticks: Number of ticks; 0: only look.
    """
    for index in range(first, last):
        row = row_at(rows, index)
        c, ahead, felt = constants_at(row.constants, 0), constants_at(row.ahead, 0), felt_at(row.felt, 0)
        u = state_at(c.state, 0)
        if ticks and u.mark == MARK and not u.outcome:
            memory = numbers(c.memory, c.memory_size)
            for joint in range(c.angles):
                memory[row.place + joint] = felt.action[joint]
        advance_ticks(c, row.model, row.data, ticks)
        look_ahead(c, ahead)
        seen = state_at(ahead.state, 0)
        if ticks and seen.outcome and not u.outcome:
            advance_ticks(c, row.model, row.data, 1)  # so that its own state knows of it
        if not feel(seen, felt, sensors_at(row.sensors, 0), c.angles) or warned(c):
            diverge(felt)


@cache
def machine_code() -> Any:
    """`advance_rows` of packed rows, for threads."""
    from mjbiped.engines.mujoco import callback
    from mjbiped.numerics import machine

    callback.define_stages()
    return machine.compiled(advance_rows, "void(int64, int64, int64, int64)")
