"""The biped with knees in the hybrid engine: its chains' constants, and where its hip, legs and swing foot are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.state import Buffers, SimulationConstants
from mjbiped.numerics.dormand_prince import dense_at
from mjbiped.numerics.records import in_one_block
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots import bent_leg
from mjbiped.robots.bent_leg import FLEXION, LEAN
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import LEGS, SWING_LOCKED, KneedBiped

ANGLES = JOINTS = 3

Pose: TypeAlias = tuple[float, float, float, float, float, float]
"""Sine and cosine of stance leg, swing thigh and swing shank from the vertical."""


class KneedConstants(NamedTuple):
    """The robot as chains of four, three and two segments, and room to compute in.

    Those of three and of two are of the stance leg as it stands, straight or bent: `stand` writes them.

    Attributes:
        weights: A of four segments; see `mjbiped.robots.chain.Chain`.
        moments: b.
        ends: Levers of the swing foot, m.
        about_end: Weights of J'FJ of an impact of that foot.
        onto_end: Of its J'F.
        legs: Which leg each of the four is part of.
        stance: How the stance leg stands; see `mjbiped.robots.bent_leg.stand`.
        free_weights: A of three segments.
        free_moments: b.
        reach: Levers of the swing foot, m.
        locked_weights: A of two.
        locked_moments: b.
        locked_reach: Levers of the swing foot, m.
        knee_before: Weights of J'F of the knee strike.
        heel_after: Weights of J'FJ of the heel strike.
        heel_before: Of its J'F.
        q: Room for angles, shape (3,).
        dq: For rates, and
        ddq: for accelerations.
        row: For one row of a Jacobian, and
        push: for the motion that a force along it makes.
        even: Room of shape (3, 3).
        odd: The same.
        locked_q: The same room for two segments.
        locked_dq: The same.
        locked_ddq: The same.
        locked_row: The same.
        locked_push: The same.
        locked_even: The same.
        locked_odd: The same.
        all_q: The same room for four segments.
        all_dq: The same.
        all_even: The same.
        all_odd: The same.
    """

    weights: Array
    moments: Array
    ends: Array
    about_end: Array
    onto_end: Array
    legs: NDArray[np.int64]
    stance: Array
    free_weights: Array
    free_moments: Array
    reach: Array
    locked_weights: Array
    locked_moments: Array
    locked_reach: Array
    knee_before: Array
    heel_after: Array
    heel_before: Array
    q: Array
    dq: Array
    ddq: Array
    row: Array
    push: Array
    even: Array
    odd: Array
    locked_q: Array
    locked_dq: Array
    locked_ddq: Array
    locked_row: Array
    locked_push: Array
    locked_even: Array
    locked_odd: Array
    all_q: Array
    all_dq: Array
    all_even: Array
    all_odd: Array


def constants_of(robot: KneedBiped, compiled: bool = False) -> Any:
    """What the functions below take of a robot; the room is of one walk alone.

    Args:
        robot: The robot.
        compiled: Whether they are compiled; what they take is then a record with the fields of `KneedConstants`.
    """
    four, free, locked = (robot.chains[n] for n in (4, 3, 2))
    constants = KneedConstants(
        four.weights,
        four.moments,
        four.reach,
        four.about_end,
        four.onto_end,
        LEGS,
        np.zeros(3),
        free.weights.copy(),
        free.moments.copy(),
        free.reach.copy(),
        locked.weights.copy(),
        locked.moments.copy(),
        locked.reach.copy(),
        np.ascontiguousarray(SWING_LOCKED.T @ free.weights),
        locked.about_end,
        locked.onto_end,
        *np.zeros((5, 3)),
        *np.zeros((2, 3, 3)),
        *np.zeros((5, 2)),
        *np.zeros((2, 2, 2)),
        *np.zeros((2, 4)),
        *np.zeros((2, 4, 4)),
    )
    return in_one_block(constants) if compiled else constants


def stand(c: KneedConstants, flexion: float) -> None:
    """Let the constants be those of a stance leg whose knee is locked at a flexion, rad."""
    if flexion == c.stance[FLEXION]:
        return
    bent_leg.stand(
        c.stance,
        flexion,
        c.weights,
        c.moments,
        c.free_weights,
        c.free_moments,
        c.reach,
        c.locked_weights,
        c.locked_moments,
        c.locked_reach,
    )
    for j in range(3):
        c.knee_before[0, j] = c.free_weights[0, j]
    c.knee_before[1, 0] = c.free_weights[1, 0] + c.free_weights[2, 0]


def pose_at(b: Buffers, q1: float, q2: float, q3: float) -> Pose:
    """The pose of angles from the ground's normal."""
    slope = b.w[at.SLOPE]
    (s1, c1), (s2, c2), (s3, c3) = sine_cosine(q1 + slope), sine_cosine(q2 + slope), sine_cosine(q3 + slope)
    return s1, c1, s2, c2, s3, c3


def pose(b: Buffers, state: Sequence[float]) -> Pose:
    """The pose in a state."""
    return pose_at(b, state[0], state[1], state[2])


def pose_between(b: Buffers, x: float) -> Pose:
    """The pose at the share x of the step."""
    n = len(b.y)
    return pose_at(
        b,
        dense_at(b.dense, n, 0, b.y[0], x),
        dense_at(b.dense, n, 1, b.y[1], x),
        dense_at(b.dense, n, 2, b.y[2], x),
    )


def swing_foot(constants: SimulationConstants, b: Buffers, pose: Pose) -> tuple[float, float]:
    """Place x, z of the swing foot, m."""
    reach, (s1, c1, s2, c2, s3, c3) = constants.robot.reach, pose
    x = reach[0] * s1 + reach[1] * s2 + reach[2] * s3
    z = reach[0] * c1 + reach[1] * c2 + reach[2] * c3
    return b.w[at.FOOT_X] + x, b.w[at.FOOT_Z] + z


def hip(constants: SimulationConstants, b: Buffers, pose: Pose) -> tuple[float, float]:
    """Place x, z of the hip, m."""
    length = constants.robot.reach[0]
    return b.w[at.FOOT_X] + length * pose[0], b.w[at.FOOT_Z] + length * pose[1]


def sides(c: KneedConstants, w: Any, q1: float, q2: float, q3: float) -> tuple[float, float, float, float]:
    """Angles of left and right thigh from the vertical, and flexion of left and right knee, rad."""
    bent = c.stance[FLEXION]
    standing, swinging, flexion = q1 + w[at.SLOPE], q2 + w[at.SLOPE], q3 - q2
    if bent != 0.0:
        standing += c.stance[LEAN] - bent
    if w[at.STANCE] == 0.0:
        return standing, swinging, bent, flexion
    return swinging, standing, flexion, bent
