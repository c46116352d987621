"""Indices of the parameters of the paper's law.

Robots with straight legs are chains of n = 2 segments, robots with knees chains of n = 3 while the swing knee is free
and of 2 once it is locked. Angles, rates and forces are ordered as the segments: stance leg, swing leg or thigh, swing
shank. All laws of `mjbiped.controllers.adaptive.PaperSettings` read one layout, with zeros for the
numbers that a law does not use. `mjbiped.controllers.room` has the indices of intermediate results and of the memory.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from mjbiped.control.controller import Numbers
from mjbiped.controllers.room import BENT, BENT_FREE, BENT_STIFF, CLIMBING, LOCKED, SUPPORT, SUPPORT_AHEAD
from mjbiped.robots.chain import Array

SEGMENTS, POSITION_GAIN, ON_ANGLE, ON_RATE, ADAPTATION_GAIN = range(5)
"""n while the swing knee is free; K1, 1/s; K1 K2 + 1, 1/s²; K1 + K2, 1/s; gamma."""

ESTIMATE_UPDATE, UPDATE_THRESHOLD = range(5, 7)
"""Whether (27) acts; its epsilon, rad."""

ADDITIVE, REPLANNING_THRESHOLD, KNEE_BUMP, KNEE_BUMP_PER_STEP = range(7, 11)
"""1: the transition is added to the gait, 0: it leads to it in its stead; distance from the limit cycle beyond which a
step is re-planned, rad and rad/s; flexion added in such a step, rad, and further flexion for each metre of a step felt
at touchdown, rad/m."""

FREE, STIFF, WHOLE, GAIT, CLIMBING_GAIT, SUPERVISION = range(11, 17)
"""Starts of blocks: the chain of n segments; that of two segments, once the knee is locked; that of four, whose first
two are the shank and thigh of a bent stance leg (all as `chain_block`); the gait, and the gait for uneven ground (see
`TRANSITION_TIME`); and what the supervisor needs (`mjbiped.controllers.bounded.prediction`)."""

UP, DOWN, CLIMBING_STEPS = range(17, 20)
"""Height changes at a touchdown above and below which the ground counts as uneven, m; number of steps with the gait for
such ground after one."""

WEIGHT, GRAVITY, BEHIND, AHEAD, SOLE_SHARE, ANKLE_HEIGHT = range(20, 26)
"""Weight of the robot, N; m/s²; distances from the ankle to the heel and to the toe, m, infinite without a sole; share
of the sole on which the law leans; height of the ankle over the sole, m."""

ANKLE_GAIN, ANKLE_RATE, ANKLE_STIFFNESS = range(26, 29)
"""Of recovery steps; see `mjbiped.controllers.bounded.recovery.Ankle`."""

HEADER = 29
"""Number of scalars and starts, in front of all blocks."""

TRANSITION_TIME, IMITATED_SLOPE, BENT_TABLE, STRAIGHT_TABLE, CYCLE = range(5)
"""Indices in a gait's block: t_c = zeta T, s (0: no re-planning); phi_r, rad; starts of the trajectories with the swing
knee free and locked; and the first state on the limit cycle, n angles and n rates."""


def chain_block(weights: Array, moments: Array, reach: Array) -> list[float]:
    """Return the numbers of a chain of n segments whose stance leg is straight.

    Args:
        weights: A of `mjbiped.robots.chain.Chain`, shape (n, n), kg m².
        moments: b of it, shape (n,), N m.
        reach: Levers of the swing foot, shape (n,), m.

    Returns:
        A row by row, b, the moment of the stance leg's weight beside its line (N m), and the levers.
    """
    return [*weights.ravel().tolist(), *moments.tolist(), 0.0, *reach.tolist()]


def flat(scalars: Mapping[int, float], blocks: Mapping[int, Numbers]) -> list[float]:
    """Return a law's parameters: scalars at their indices, and blocks behind them, whose starts stand at theirs."""
    parameters = [0.0] * HEADER
    parameters[UP], parameters[DOWN] = math.inf, -math.inf
    for index, value in scalars.items():
        parameters[index] = float(value)
    for index, block in blocks.items():
        parameters[index] = float(len(parameters))
        parameters += map(float, block)
    return parameters


def gait_of(parameters: Numbers, memory: Numbers) -> int:
    """Return the start of the block of the gait with which the current step is made."""
    return int(parameters[CLIMBING_GAIT if memory[CLIMBING] > 0.0 else GAIT])


def table_of_step(parameters: Numbers, memory: Numbers, gait: int) -> int:
    """Return the start of the trajectory that a step follows with the gait at an index, of the knee as it is now."""
    return int(parameters[gait + (STRAIGHT_TABLE if memory[LOCKED] != 0.0 else BENT_TABLE)])


def moving_chain(parameters: Numbers, memory: Numbers) -> tuple[int, Numbers, int]:
    """Return the number of segments that move now, and where their chain stands: in which sequence, and at which index.

    It stands in the parameters with a straight stance leg, and in the memory with a bent one.
    """
    locked = memory[LOCKED] != 0.0
    n = 2 if locked else int(parameters[SEGMENTS])
    if memory[BENT] != 0.0:
        return n, memory, BENT_STIFF if locked else BENT_FREE
    return n, parameters, int(parameters[STIFF if locked else FREE])


def bounds(parameters: Numbers, memory: Numbers, share: float) -> tuple[float, float]:
    """Return how far behind and ahead of the ankle the law leans in this step, m, on a share of what bears the foot."""
    behind, ahead = parameters[BEHIND], parameters[AHEAD]
    if memory[SUPPORT] + memory[SUPPORT_AHEAD] > 0.0:  # else nothing was told
        behind, ahead = min(behind, memory[SUPPORT]), min(ahead, memory[SUPPORT_AHEAD])
    return share * behind, share * ahead
