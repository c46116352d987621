"""The biped with knees in the hybrid engine: its motion, the force of the ground, and its rows.

`mjbiped.engines.hybrid.state.Laws` says what each of the functions of `MODEL` is. The state has three angles also while
the swing knee is locked: thigh and shank then move as one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.dynamics import WILDEST_ANGLE, ensure_dense
from mjbiped.engines.hybrid.kneed_impacts import held, hit_face, lands, strike_stop, stub, transfer
from mjbiped.engines.hybrid.kneed_posture import (
    ANGLES,
    JOINTS,
    KneedConstants,
    Pose,
    hip,
    pose,
    pose_at,
    pose_between,
    sides,
    stand,
    swing_foot,
)
from mjbiped.engines.hybrid.state import KNEE_FREE, KNEE_LOCKED, Buffers, Laws, SimulationConstants
from mjbiped.numerics.dormand_prince import dense_at, dense_rate_at
from mjbiped.records.rows import KNEED_SAMPLED, write_kneed_sample
from mjbiped.robots.bent_leg import ACROSS, force_beside, gravity_beside
from mjbiped.robots.chain import accelerate, ground_force


def rates(
    torque: Callable[..., tuple[float, ...]],
    parameters: Any,
    constants: KneedConstants,
    length: float,  # noqa: ARG001 (a bent stance leg is shorter)
    memory: Any,
    w: Any,
    t: float,
    state: tuple[float, ...],
) -> tuple[float, ...]:
    """Rates of a state at time t since the support transfer; `w` says whether the knee is locked."""
    q1, q2, q3, dq1, dq2, dq3 = state[0], state[1], state[2], state[3], state[4], state[5]
    for index in range(len(state) - 2 * ANGLES - JOINTS):
        memory[index] = state[2 * ANGLES + index]
    wild = not (abs(q1) < WILDEST_ANGLE and abs(q2) < WILDEST_ANGLE and abs(q3) < WILDEST_ANGLE)
    if wild:
        q1 = q2 = q3 = dq1 = dq2 = dq3 = 0.0
    result = torque(parameters, memory, min(max(t, w[at.AFTER]), w[at.BEFORE]), (q1, q2, q3), (dq1, dq2, dq3))
    ankle, hip_torque, knee = result[0], result[1], result[2]
    stance = ankle - hip_torque
    stand(constants, w[at.STANCE_FLEXION])
    if w[at.PUSH] != 0.0:  # a horizontal force at the hip
        stance += w[at.PUSH] * constants.reach[0] * math.cos(q1 + w[at.SLOPE])
    if constants.stance[ACROSS] != 0.0:
        stance -= gravity_beside(constants.stance[ACROSS], q1 + w[at.SLOPE], 0.0, 1.0)  # of the angle from the vertical
    ddq1, ddq2, ddq3 = accelerations(constants, w, q1, q2, q3, dq1, dq2, dq3, stance, hip_torque, knee)
    if wild:
        ddq1 = math.nan
    w[at.ANKLE_TORQUES + int(w[at.STAGE])] = ankle
    w[at.STAGE] += 1.0
    for joint in range(JOINTS):
        size = abs(result[joint])
        w[at.ANKLE + joint] = result[joint]
        if size > w[at.STAGE_ANKLE + joint]:
            w[at.STAGE_ANKLE + joint], w[at.WHEN_ANKLE + joint] = size, t
    powers = (ankle * dq1, hip_torque * (dq2 - dq1), knee * (dq3 - dq2))
    return (dq1, dq2, dq3, ddq1, ddq2, ddq3) + result[3:] + powers  # noqa: RUF005 (Numba adds tuples)


def accelerations(
    c: KneedConstants,
    w: Any,
    q1: float,
    q2: float,
    q3: float,
    dq1: float,
    dq2: float,
    dq3: float,
    stance: float,
    hip_torque: float,
    knee: float,
) -> tuple[float, float, float]:
    """Accelerations of the segments, rad/s^2: of three, or of two where the knee is locked or rests on its stop."""
    slope, x, z = w[at.SLOPE], w[at.PUSHED_X], w[at.PUSHED_Z]
    touches = w[at.FACE] != 0.0 or w[at.GROUND] != 0.0
    if w[at.LOCKED] != KNEE_LOCKED:
        c.q[0], c.q[1], c.q[2], c.dq[0], c.dq[1], c.dq[2] = q1, q2, q3, dq1, dq2, dq3
        c.ddq[0], c.ddq[1], c.ddq[2] = stance, hip_torque - knee, knee
        accelerate(c.free_weights, c.free_moments, slope, c.q, c.dq, c.even, c.odd, c.ddq)
        if touches:
            row, push = c.row, c.push
            w[at.PRESS] = held(c.free_weights, c.reach, slope, x, z, c.q, c.dq, c.ddq, row, push, c.even, c.odd)
        if w[at.LOCKED] == KNEE_FREE:
            return c.ddq[0], c.ddq[1], c.ddq[2]
        w[at.STOP_PRESS] = c.ddq[1] - c.ddq[2]
    q, dq, ddq = c.locked_q, c.locked_dq, c.locked_ddq
    q[0], q[1], dq[0], dq[1], ddq[0], ddq[1] = q1, q2, dq1, dq2, stance, hip_torque
    accelerate(c.locked_weights, c.locked_moments, slope, q, dq, c.locked_even, c.locked_odd, ddq)
    if touches:
        row, push, even, odd = c.locked_row, c.locked_push, c.locked_even, c.locked_odd
        w[at.PRESS] = held(c.locked_weights, c.locked_reach, slope, x, z, q, dq, ddq, row, push, even, odd)
    return ddq[0], ddq[1], ddq[1]


def asked(
    torque: Callable[..., tuple[float, ...]], parameters: Any, memory: Any, t: float, state: Sequence[float]
) -> tuple[float, float, float]:
    """Torques of the law in a state."""
    result = torque(parameters, memory, t, (state[0], state[1], state[2]), (state[3], state[4], state[5]))
    return result[0], result[1], result[2]


def ticked(tick: Callable[..., None], parameters: Any, memory: Any, t: float, state: Sequence[float]) -> None:
    """The law ticks."""
    tick(parameters, memory, t, (state[0], state[1], state[2]), (state[3], state[4], state[5]))


def foot_speed(constants: SimulationConstants, b: Buffers, pose: Pose) -> tuple[float, float]:
    """Its rates at the step's end, m/s."""
    reach, (s1, c1, s2, c2, s3, c3) = constants.robot.reach, pose
    r1, r2, r3 = reach[0] * b.out[3], reach[1] * b.out[4], reach[2] * b.out[5]
    return r1 * c1 + r2 * c2 + r3 * c3, -(r1 * s1 + r2 * s2 + r3 * s3)


def foot_rush(constants: SimulationConstants, b: Buffers, first: int, state: Sequence[float]) -> float:
    """Bound of the swing foot's acceleration in a state, m/s^2."""
    bound = 0.0
    for i in range(ANGLES):
        rate = state[ANGLES + i]
        bound += abs(constants.robot.reach[i]) * (abs(b.k[first + ANGLES + i]) + rate * rate)
    return bound


def force_at(
    constants: SimulationConstants,
    b: Buffers,
    pose: Pose,  # noqa: ARG001 (as all of `Laws`)
    state: Sequence[float],
    place: int,
) -> tuple[float, float]:
    """Force of the ground, forward and upward, N."""
    c = constants.robot
    for i in range(ANGLES):
        c.q[i], c.dq[i], c.ddq[i] = state[i] + b.w[at.SLOPE], state[ANGLES + i], b.k[place + ANGLES + i]
    return _force(c, constants)


def _force(c: KneedConstants, constants: SimulationConstants) -> tuple[float, float]:
    """Of the motion that stands in the room for three segments, angles from the vertical."""
    forward, upward = ground_force(c.free_moments, constants.mass, constants.gravity, c.q, c.dq, c.ddq)
    if c.stance[ACROSS] != 0.0:
        ahead, above = force_beside(c.stance[ACROSS], constants.gravity, c.q[0], c.dq[0], c.ddq[0])
        forward, upward = forward + ahead, upward + above
    return forward, upward


def force_within(
    constants: SimulationConstants,
    b: Buffers,
    pose: Pose,  # noqa: ARG001
    x: float,
    h: float,
) -> tuple[float, float]:
    """The same within the step."""
    c, n = constants.robot, len(b.y)
    for i in range(ANGLES):
        c.q[i], c.dq[i] = b.spare[i] + b.w[at.SLOPE], b.spare[ANGLES + i]
        c.ddq[i] = dense_rate_at(b.dense, n, ANGLES + i, x) / h
    return _force(c, constants)


def write_state(
    constants: SimulationConstants, b: Buffers, row: Any, time: float, state: Sequence[float], estimate: float
) -> None:
    """Fill a row of the samples with a state, with the torques in `w`, and with the slope estimate (rad)."""
    w = b.w
    q1, q2, q3 = state[0], state[1], state[2]
    left, right, left_knee, right_knee = sides(constants.robot, w, q1, q2, q3)
    x, z = hip(constants, b, pose_at(b, q1, q2, q3))
    write_kneed_sample(
        row,
        0,
        time=time,
        q=(q1, q2, q3),
        dq=(state[3], state[4], state[5]),
        torque=(w[at.ANKLE], w[at.HIP], w[at.KNEE]),
        slope=w[at.SLOPE],
        slope_estimate=estimate,
        stance=w[at.STANCE],
        qpos=(x, z, left, right, left_knee, right_knee),
        locked=1.0 if w[at.LOCKED] == KNEE_LOCKED else 0.0,
    )
    for index in range(len(b.y) - 2 * ANGLES - JOINTS):
        row[KNEED_SAMPLED + index] = state[2 * ANGLES + index]


def stops(constants: SimulationConstants, b: Buffers) -> bool:  # noqa: ARG001 (as all of `Laws`)
    """Whether the free knee is bent forwards at the step's end, beyond its stop."""
    return bool(b.w[at.LOCKED] == KNEE_FREE and b.out[2] < b.out[1])


def stop_gap(b: Buffers) -> tuple[float, float]:
    """Flexion of the knee (rad) and its rate (rad/s) at the step's end."""
    return b.out[2] - b.out[1], b.out[5] - b.out[4]


def stopped_within(b: Buffers, x: float) -> bool:
    """Whether the knee is beyond its stop at the share x of the step."""
    n = len(b.y)
    return bool(dense_at(b.dense, n, 2, b.y[2], x) < dense_at(b.dense, n, 1, b.y[1], x))


def note(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> None:
    """Keep the greatest flexion of the knee, also where it lies within the step."""
    w, n = b.w, len(b.y)
    w[at.FLEXION] = max(w[at.FLEXION], b.y[2] - b.y[1], b.out[2] - b.out[1])
    if b.y[5] - b.y[4] <= 0.0 or b.out[5] - b.out[4] >= 0.0:
        return
    ensure_dense(laws, parameters, constants, b, t, h)
    x, end = 0.0, 1.0
    for _ in range(30):
        middle = 0.5 * (x + end)
        if dense_at(b.dense, n, 5, b.y[5], middle) > dense_at(b.dense, n, 4, b.y[4], middle):
            x = middle
        else:
            end = middle
    flexion = dense_at(b.dense, n, 2, b.y[2], x) - dense_at(b.dense, n, 1, b.y[1], x)
    w[at.FLEXION] = max(w[at.FLEXION], flexion)


MODEL = (
    rates,
    asked,
    ticked,
    pose,
    pose_between,
    swing_foot,
    foot_speed,
    foot_rush,
    hip,
    force_at,
    force_within,
    hit_face,
    lands,
    stub,
    transfer,
    write_state,
    stops,
    stop_gap,
    stopped_within,
    strike_stop,
    note,
)
"""In the order of `Laws`."""
