"""What a robot feels at the end of a control period, and what it is rewarded with; plain functions of numbers.

The same source runs in Python and compiled (`mjbiped.engines.mujoco.compiled.advance`), after the steps of each robot.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.compiled.advance import Sizes
from mjbiped.rules.termination import Outcome

OBSERVED: dict[str, slice] = {
    "joint_angles": slice(0, 2),
    "joint_rates": slice(2, 4),
    "touchdown": slice(4, 5),
    "time_since_touchdown": slice(5, 6),
    "last_touchdown": slice(6, 10),
    "torque": slice(10, 12),
}
"""The parts of what is felt, in the order in which they stand in `out`; docs/environments.md has their meanings."""

LOWEST = (-10.0, -10.0, -100.0, -100.0, 0.0, 0.0, -10.0, -10.0, -10.0, -10.0, -100.0, -100.0)
HIGHEST = (10.0, 10.0, 100.0, 100.0, 1.0, 100.0, 10.0, 10.0, 10.0, 10.0, 100.0, 100.0)
"""Bounds of what is felt, in rad, rad/s, s and N m, far beyond what a walk comes to: what is beyond is cut off."""

OBSERVATIONS = 12
HIP_X, PROGRESS, ECONOMY, REWARD, OUTCOME, SLOPE, FOOT_X = range(OBSERVATIONS, OBSERVATIONS + 7)
"""Indices in `out`, behind what is felt: hip's x (m), terms of the reward, `mjbiped.rules.termination.Outcome`, slope
under the stance foot (rad) and the stance foot's x (m)."""

(
    LEG_LENGTH,  # m
    TARGET,  # distance that the hip is to go in a control period, m
    SHARE,  # of a control period in the average of that distance
    AFFORDED,  # work in a control period at which the reward's second term is a half, J
    AVERAGE,  # distance that the hip goes in a control period, averaged, m
    LAST_X,  # hip at the last call, m
    LAST_WORK,  # absolute work up to the last call, J
    LAST_COUNT,  # touchdowns up to the last call
) = range(8)

SIZES = Sizes(inputs=2, kept=8, out=OBSERVATIONS + 7)

PROGRESS_WEIGHT = 0.75
ECONOMY_WEIGHT = 0.25

_DIVERGED = float(Outcome.DIVERGED)


def feel(now: Sequence[float], kept: MutableSequence[float], out: MutableSequence[float]) -> None:
    """Fill `out` with what the robot feels, and its reward since the last call.

    Args:
        now: Userdata as the next tick will find them; see `contact_events`.
        kept: Numbers of this robot, of which the last four are changed.
        out: See `OBSERVED` and the indices behind it.
    """
    slope = now[events.SLOPE]
    if now[events.STANCE]:
        stance, swing = now[events.RIGHT], now[events.LEFT]
        stance_rate, swing_rate = now[events.RIGHT_RATE], now[events.LEFT_RATE]
    else:
        stance, swing = now[events.LEFT], now[events.RIGHT]
        stance_rate, swing_rate = now[events.LEFT_RATE], now[events.RIGHT_RATE]
    out[0], out[1] = stance - slope, swing - slope
    out[2], out[3] = stance_rate, swing_rate
    out[4] = 1.0 if now[events.COUNT] > kept[LAST_COUNT] else 0.0
    out[5] = now[events.TIME] - now[events.TRANSFER_TIME]
    for index in range(2):
        out[6 + index] = now[events.TOLD_Q_BEFORE + index]
        out[8 + index] = now[events.TOLD_Q + index]
    out[10], out[11] = now[events.ANKLE], now[events.HIP]

    sound = now[events.RUNNING] != 0.0  # MuJoCo resets what diverges, and notices it in the step after
    for index in range(OBSERVATIONS):
        sound = sound and math.isfinite(out[index])
        out[index] = min(max(out[index], LOWEST[index]), HIGHEST[index])

    hip_x = now[events.FOOT_X] + kept[LEG_LENGTH] * math.sin(stance)
    work = now[events.WORK_ABSOLUTE] - kept[LAST_WORK]
    kept[AVERAGE] += kept[SHARE] * (hip_x - kept[LAST_X] - kept[AVERAGE])
    progress = PROGRESS_WEIGHT * min(max(kept[AVERAGE] / kept[TARGET], 0.0), 1.0)
    economy = ECONOMY_WEIGHT / (1.0 + work / kept[AFFORDED])
    kept[LAST_X], kept[LAST_WORK], kept[LAST_COUNT] = hip_x, now[events.WORK_ABSOLUTE], now[events.COUNT]
    out[HIP_X], out[PROGRESS], out[ECONOMY] = hip_x, progress, economy
    out[REWARD] = progress + economy
    out[OUTCOME], out[SLOPE], out[FOOT_X] = now[events.OUTCOME], slope, now[events.FOOT_X]
    for index in range(OBSERVATIONS, len(out)):
        sound = sound and math.isfinite(out[index])
    if not sound:
        for index in range(len(out)):
            out[index] = 0.0
        out[OUTCOME] = _DIVERGED
