"""Where the numbers of the paper's law stand: in its parameters, its memory, and its room for intermediate results.

Robots with straight legs are chains of n = 2 segments, robots with knees chains of n = 3 while the swing knee is free
and of 2 once it is locked. Angles, rates and forces are ordered as the segments: stance leg, swing leg or thigh, swing
shank. All laws of `mjbiped.controllers.settings.PaperSettings` read one layout, with zeros where a law has no use for
a number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from mjbiped.robots.chain import Array

ANGLES = 3
"""Greatest number of segments that move."""

POINTS = 6
"""Control points of one angle's transition curve."""

(
    SEGMENTS,  # n while the swing knee is free
    POSITION_GAIN,  # K1, 1/s
    ON_ANGLE,  # K1 K2 + 1, 1/s²
    ON_RATE,  # K1 + K2, 1/s
    ADAPTATION_GAIN,  # gamma
    ADDITIVE,  # 1: the transition is added to the gait, 0: it leads to it in its stead
    ESTIMATE_UPDATE,  # whether (27) acts
    UPDATE_THRESHOLD,  # epsilon of (27), rad
    REPLANNING_THRESHOLD,  # distance from the limit cycle beyond which a step is re-planned, rad and rad/s
    KNEE_BUMP,  # flexion added in a re-planned step, rad
    KNEE_BUMP_PER_STEP,  # further flexion for each metre of a step felt at touchdown, rad/m
    FREE,  # start of the chain of n segments; see `chain_block`
    STIFF,  # start of the chain of two segments, once the knee is locked
    WHOLE,  # start of the chain of four segments, whose first two are the shank and thigh of a bent stance leg
    GAIT,  # start of the gait; see `gait_block`
    CLIMBING_GAIT,  # start of the gait for uneven ground
    UP,  # height change at a touchdown above which the ground counts as uneven, m
    DOWN,  # height change below which it does so, m
    CLIMBING_STEPS,  # number of steps with the climbing gait after such a change
    WEIGHT,  # of the robot, N
    GRAVITY,  # m/s²
    BEHIND,  # distance from the ankle to the heel, m; infinite without a sole
    AHEAD,  # distance from the ankle to the toe, m
    SOLE_SHARE,  # share of the sole on which the law leans
    ANKLE_HEIGHT,  # of the ankle over the sole, m
    ANKLE_GAIN,  # of recovery steps, as the two that follow; see `mjbiped.controllers.bounded.recovery.Ankle`
    ANKLE_RATE,
    ANKLE_STIFFNESS,
    SUPERVISION,  # start of what the supervisor needs; see `mjbiped.controllers.bounded.supervisor`
    HEADER,  # number of these
) = range(30)
"""Indices in the parameters."""

TRANSITION_TIME, IMITATED_SLOPE, BENT_TABLE, STRAIGHT_TABLE, CYCLE = range(5)
"""Indices in a gait's block: t_c = zeta T (s; 0: no re-planning), phi_r (rad), starts of the trajectories with the swing
knee free and locked, and the first state on the limit cycle, n angles and n rates."""

(
    SIN,  # estimate of the slope's sine
    COS,  # estimate of its cosine
    REPLANNED,  # whether this step is re-planned
    LOCKED,  # whether the swing knee is locked
    BUMP,  # of the shank's curve, rad
    BENT,  # flexion of the locked stance knee, rad
    LEAN,  # of the shank of a bent stance leg, forward of the line from its foot to the hip, rad
    SUPPORT,  # how far behind the ankle the ground bears the foot, m; see `Controller.support`
    SUPPORT_AHEAD,  # how far ahead of it
    CLIMBING,  # number of steps left with the climbing gait, this one included
    RECOVERING,  # whether this is a recovery step; behind it stand its time, half angle and retraction
) = range(11)
"""Indices in the memory of what lasts from call to call."""

ROOM = 16
"""First index of the room for intermediate results: behind the numbers that `torque` returns, and within the memory for
touchdowns. Nothing is kept there from one call to the next."""

Q, DQ, SINE, COSINE, REFERENCE, MOTION, ERROR, FORCE, FORWARD, UPWARD, BY_STANCE, TORQUE, ALONG, NORMAL = (
    ROOM + place for place in (0, 3, 6, 9, 12, 21, 24, 27, 30, 33, 36, 39, 42, 43)
)
"""Indices in the room: angles (rad), their rates (rad/s), sines and cosines; reference as `reference_at` writes it;
accelerations (rad/s²); z2 (rad/s); generalised forces (N m); accelerations of the ends of unit vectors along the
segments, along the ground and along its normal (1/s²); change of the forces by the stance leg's acceleration (kg m²);
torques (N m); and the ground's force along it and normal to it (N)."""

CURVES = ROOM + 48
"""Index in the memory of the control points of re-planned steps."""

BENT_FREE = CURVES + ANGLES * POINTS
"""Index in the memory of the chain with a bent stance leg and a free swing knee; see `chain_block`."""

BENT_STIFF = BENT_FREE + 16
"""Index of the same chain once the swing knee is locked."""

STRAIGHT_LEGS_SIZE, KNEES_SIZE = CURVES + 2 * POINTS, BENT_STIFF + 7
"""Floats of a memory of a law for straight legs, and with knees."""


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


def flat(scalars: Mapping[int, float], blocks: Mapping[int, Sequence[float]]) -> list[float]:
    """Return a law's parameters: scalars at their indices, and blocks behind them, whose starts stand at theirs."""
    parameters = [0.0] * HEADER
    parameters[UP], parameters[DOWN] = math.inf, -math.inf
    for index, value in scalars.items():
        parameters[index] = float(value)
    for index, block in blocks.items():
        parameters[index] = float(len(parameters))
        parameters += map(float, block)
    return parameters


def gait_of(parameters: Sequence[float], memory: Sequence[float]) -> int:
    """Return the start of the block of the gait with which the current step is made."""
    return int(parameters[CLIMBING_GAIT if memory[CLIMBING] > 0.0 else GAIT])


def table_of_step(parameters: Sequence[float], memory: Sequence[float], gait: int) -> int:
    """Return the start of the trajectory that a step follows with the gait at an index, of the knee as it is now."""
    return int(parameters[gait + (STRAIGHT_TABLE if memory[LOCKED] != 0.0 else BENT_TABLE)])


def moving_chain(parameters: Sequence[float], memory: Sequence[float]) -> tuple[int, Sequence[float], int]:
    """Return the number of segments that move now, and where their chain stands: in which sequence, and at which index.

    It stands in the parameters with a straight stance leg, and in the memory with a bent one.
    """
    locked = memory[LOCKED] != 0.0
    n = 2 if locked else int(parameters[SEGMENTS])
    if memory[BENT] != 0.0:
        return n, memory, BENT_STIFF if locked else BENT_FREE
    return n, parameters, int(parameters[STIFF if locked else FREE])
