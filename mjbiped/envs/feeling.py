"""Observation and reward of a robot at the end of a control period, as plain functions of numbers.

The same source runs in Python and compiled (`mjbiped.engines.mujoco.compiled.advance`), after the steps of each robot.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence
from typing import Any

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
"""Parts of an observation by their places in `out`; docs/environments.md describes them."""

LOWEST = (-10.0, -10.0, -100.0, -100.0, 0.0, 0.0, -10.0, -10.0, -10.0, -10.0, -100.0, -100.0)
HIGHEST = (10.0, 10.0, 100.0, 100.0, 1.0, 100.0, 10.0, 10.0, 10.0, 10.0, 100.0, 100.0)
"""Bounds to which observations are clipped, in rad, rad/s, s and N m; far beyond those of a walk."""

OBSERVATIONS = 12
HIP_X, PROGRESS, ECONOMY, REWARD, OUTCOME, SLOPE, FOOT_X = range(OBSERVATIONS, OBSERVATIONS + 7)
"""Indices in `out`, behind the observation: hip's x (m), terms of the reward, `mjbiped.rules.termination.Outcome`,
slope under the stance foot (rad) and the stance foot's x (m)."""

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


def feel(now: Any, kept: MutableSequence[float], out: MutableSequence[float]) -> None:
    """Fill `out` with a robot's observation and its reward since the last call.

    Args:
        now: `State` of its walk as the next tick will find it.
        kept: Numbers of this robot by the indices above; the last four are updated.
        out: Numbers to fill, by `OBSERVED` and the indices behind the observation.
    """
    for index in range(2):
        out[index], out[2 + index] = now.angles[index], now.turning[index]
        out[6 + index], out[8 + index] = now.told_before[index], now.told_q[index]
        out[10 + index] = now.torque[index]
    out[4] = 1.0 if now.count > kept[LAST_COUNT] else 0.0
    out[5] = now.time - now.transfer_time

    sound = now.running != 0.0  # MuJoCo resets what diverges, and notices it in the step after
    for index in range(OBSERVATIONS):
        sound = sound and math.isfinite(out[index])
        out[index] = min(max(out[index], LOWEST[index]), HIGHEST[index])

    stance = now.q[3] if now.stance else now.q[2]
    hip_x = now.foot_x + kept[LEG_LENGTH] * math.sin(stance)
    work = now.work_absolute - kept[LAST_WORK]
    kept[AVERAGE] += kept[SHARE] * (hip_x - kept[LAST_X] - kept[AVERAGE])
    progress = PROGRESS_WEIGHT * min(max(kept[AVERAGE] / kept[TARGET], 0.0), 1.0)
    economy = ECONOMY_WEIGHT / (1.0 + work / kept[AFFORDED])
    kept[LAST_X], kept[LAST_WORK], kept[LAST_COUNT] = hip_x, now.work_absolute, now.count
    out[HIP_X], out[PROGRESS], out[ECONOMY] = hip_x, progress, economy
    out[REWARD] = progress + economy
    out[OUTCOME], out[SLOPE], out[FOOT_X] = now.outcome, now.slope, now.foot_x
    for index in range(OBSERVATIONS, len(out)):
        sound = sound and math.isfinite(out[index])
    if not sound:
        for index in range(len(out)):
            out[index] = 0.0
        out[OUTCOME] = _DIVERGED
