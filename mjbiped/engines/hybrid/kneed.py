"""The biped with knees in the hybrid engine: its chains' equations, both impacts and its geometry.

`mjbiped.engines.hybrid.state.Laws` says what each of the functions of `MODEL` is. The state has three angles also while
the swing knee is locked: thigh and shank then move as one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.dynamics import WILDEST_ANGLE, ensure_dense
from mjbiped.engines.hybrid.state import KNEE_FREE, KNEE_LOCKED, KNEE_RESTING, Buffers, Laws, SimulationConstants
from mjbiped.engines.hybrid.transfer import stand_on
from mjbiped.numerics.dormand_prince import dense_at, dense_rate_at
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.records.rows import KNEED_SAMPLED, write_kneed_sample, write_kneed_touchdown
from mjbiped.robots.chain import Array, accelerate, constrain, ground_force, strike
from mjbiped.robots.kneed import SWING_LOCKED, KneedBiped

ANGLES = JOINTS = 3

Pose: TypeAlias = tuple[float, float, float, float, float, float]
"""Sine and cosine of stance leg, swing thigh and swing shank from the vertical."""


class KneedConstants(NamedTuple):
    """The robot as chains of three and of two segments, and room to compute in.

    Attributes:
        free_weights: A of three segments; see `mjbiped.robots.chain.Chain`.
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
    """

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


def constants_of(robot: KneedBiped) -> KneedConstants:
    """What the functions below take of a robot; the room is of one walk alone."""
    free, locked = robot.chains[3], robot.chains[2]
    return KneedConstants(
        free.weights,
        free.moments,
        free.reach,
        locked.weights,
        locked.moments,
        locked.reach,
        np.ascontiguousarray(SWING_LOCKED.T @ free.weights),
        locked.about_end,
        locked.onto_end,
        *np.zeros((5, 3)),
        *np.zeros((2, 3, 3)),
        *np.zeros((5, 2)),
        *np.zeros((2, 2, 2)),
    )


def rates(
    torque: Callable[..., tuple[float, ...]],
    parameters: Any,
    constants: KneedConstants,
    length: float,
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
    result = torque(parameters, memory, min(max(t, w[at.AFTER]), w[at.BEFORE]), q1, q2, q3, dq1, dq2, dq3)
    ankle, hip_torque, knee = result[0], result[1], result[2]
    stance = ankle - hip_torque
    if w[at.PUSH] != 0.0:  # a horizontal force at the hip
        stance += w[at.PUSH] * length * math.cos(q1 + w[at.SLOPE])
    ddq1, ddq2, ddq3 = accelerations(constants, w, q1, q2, q3, dq1, dq2, dq3, stance, hip_torque, knee)
    if wild:
        ddq1 = math.nan
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
    slope = w[at.SLOPE]
    if w[at.LOCKED] != KNEE_LOCKED:
        c.q[0], c.q[1], c.q[2], c.dq[0], c.dq[1], c.dq[2] = q1, q2, q3, dq1, dq2, dq3
        c.ddq[0], c.ddq[1], c.ddq[2] = stance, hip_torque - knee, knee
        accelerate(c.free_weights, c.free_moments, slope, c.q, c.dq, c.even, c.odd, c.ddq)
        if w[at.FACE] != 0.0:
            force = _held(c.free_weights, c.reach, slope, c.q, c.dq, c.ddq, c.row, c.push, c.even, c.odd)
            w[at.PRESS] = -w[at.FACE] * force
        if w[at.LOCKED] == KNEE_FREE:
            return c.ddq[0], c.ddq[1], c.ddq[2]
        w[at.STOP_PRESS] = c.ddq[1] - c.ddq[2]
    q, dq, ddq = c.locked_q, c.locked_dq, c.locked_ddq
    q[0], q[1], dq[0], dq[1], ddq[0], ddq[1] = q1, q2, dq1, dq2, stance, hip_torque
    accelerate(c.locked_weights, c.locked_moments, slope, q, dq, c.locked_even, c.locked_odd, ddq)
    if w[at.FACE] != 0.0:
        row, push = c.locked_row, c.locked_push
        force = _held(c.locked_weights, c.locked_reach, slope, q, dq, ddq, row, push, c.locked_even, c.locked_odd)
        w[at.PRESS] = -w[at.FACE] * force
    return ddq[0], ddq[1], ddq[1]


def _held(
    weights: Array,
    reach: Array,
    slope: float,
    q: Array,
    dq: Array,
    ddq: Array,
    row: Array,
    push: Array,
    even: Array,
    odd: Array,
) -> float:
    """Let a face hold the swing foot along x: accelerations are changed, and the force along x is returned, N."""
    bend = 0.0
    for i in range(len(q)):
        sine, cosine = sine_cosine(q[i] + slope)
        row[i] = reach[i] * cosine
        bend -= reach[i] * sine * dq[i] * dq[i]
    return constrain(weights, q, row, bend, even, odd, push, ddq)


def asked(
    torque: Callable[..., tuple[float, ...]], parameters: Any, memory: Any, t: float, state: Sequence[float]
) -> tuple[float, float, float]:
    """Torques of the law in a state."""
    result = torque(parameters, memory, t, state[0], state[1], state[2], state[3], state[4], state[5])
    return result[0], result[1], result[2]


def ticked(tick: Callable[..., None], parameters: Any, memory: Any, t: float, state: Sequence[float]) -> None:
    """The law ticks."""
    tick(parameters, memory, t, state[0], state[1], state[2], state[3], state[4], state[5])


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


def hip(constants: SimulationConstants, b: Buffers, pose: Pose) -> tuple[float, float]:
    """Place x, z of the hip, m."""
    return b.w[at.FOOT_X] + constants.length * pose[0], b.w[at.FOOT_Z] + constants.length * pose[1]


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
    return ground_force(c.free_moments, constants.mass, constants.gravity, c.q, c.dq, c.ddq)


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
    return ground_force(c.free_moments, constants.mass, constants.gravity, c.q, c.dq, c.ddq)


def hit_face(constants: SimulationConstants, b: Buffers) -> None:
    """A vertical face stops the swing foot, plastically and without friction; a locked knee stays locked."""
    c, y, slope = constants.robot, b.y, b.w[at.SLOPE]
    if b.w[at.LOCKED] == KNEE_LOCKED:
        for i in range(2):
            c.locked_q[i], c.locked_ddq[i], c.locked_dq[i] = y[i], y[ANGLES + i], 0.0
        row, push, even, odd = c.locked_row, c.locked_push, c.locked_even, c.locked_odd
        _held(c.locked_weights, c.locked_reach, slope, c.locked_q, c.locked_dq, c.locked_ddq, row, push, even, odd)
        y[3], y[4], y[5] = c.locked_ddq[0], c.locked_ddq[1], c.locked_ddq[1]
        return
    for i in range(ANGLES):
        c.q[i], c.ddq[i], c.dq[i] = y[i], y[ANGLES + i], 0.0
    _held(c.free_weights, c.reach, slope, c.q, c.dq, c.ddq, c.row, c.push, c.even, c.odd)
    for i in range(ANGLES):
        y[ANGLES + i] = c.ddq[i]
    if b.w[at.LOCKED] == KNEE_RESTING:
        b.w[at.LOCKED] = KNEE_FREE


def lands(constants: SimulationConstants, b: Buffers) -> bool:
    """A straight leg that comes down ahead of the other one takes the robot over."""
    x, _ = swing_foot(constants, b, pose(b, b.y))
    return bool(b.w[at.LOCKED] == KNEE_LOCKED and x > b.w[at.FOOT_X])


def transfer(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, segment: int, foot_x: float
) -> None:
    """The heel's impact, new roles, the controller's touchdown, and a row of the record."""
    w, y, n, c = b.w, b.y, len(b.y), constants.robot
    own = n - 2 * ANGLES - JOINTS
    old_slope, stance, slope = w[at.SLOPE], int(w[at.STANCE]), constants.angle[segment]
    q1, q2, q3, dq1, dq2, dq3 = y[0], y[1], y[2], y[3], y[4], y[5]
    hip_x, hip_z = hip(constants, b, pose(b, y))
    turned = old_slope - slope
    new1, new2, new3 = q2 + turned, q1 + turned, q1 + turned
    c.locked_q[0], c.locked_q[1], c.locked_dq[0], c.locked_dq[1] = q1, q2, dq1, dq2
    strike(c.heel_after, c.heel_before, c.locked_q, c.locked_q, c.locked_dq, c.locked_even, c.locked_odd)
    rate1, rate2 = c.locked_dq[1], c.locked_dq[0]
    for index in range(own):
        b.memory[index] = y[2 * ANGLES + index]
    estimate_before = laws.slope_estimate(parameters, b.memory)
    laws.touchdown(parameters, b.memory, q1, q2, q3, new1, new2, new3, rate1, rate2, rate2)
    stand_on(constants, w, segment, foot_x)
    y[0], y[1], y[2], y[3], y[4], y[5] = new1, new2, new3, rate1, rate2, rate2
    w[at.LOCKED] = KNEE_RESTING
    for index in range(own):
        y[2 * ANGLES + index] = b.memory[index]
    for joint in range(JOINTS):
        y[n - JOINTS + joint] = 0.0
    left, right, left_knee, right_knee = _sides(stance, q1 + old_slope, q2 + old_slope, q3 - q2)
    write_kneed_touchdown(
        b.rows[int(w[at.ROWS])],
        0,
        time=w[at.TIME],
        qpos=(hip_x, hip_z, left, right, left_knee, right_knee),
        x=w[at.FOOT_X],
        z=w[at.FOOT_Z],
        stance=w[at.STANCE],
        slope=slope,
        q_before=(q1, q2, q3),
        dq_before=(dq1, dq2, dq3),
        q=(new1, new2, new3),
        dq=(rate1, rate2, rate2),
        work_absolute=w[at.WORK_ABSOLUTE],
        work_net=w[at.WORK_NET],
        work_positive=w[at.WORK_POSITIVE],
        slip=0.0,
        penetration=0.0,
        friction=w[at.FRICTION],
        strikes=w[at.FACE_IMPACTS],
        slope_estimate_before=estimate_before,
        slope_estimate=laws.slope_estimate(parameters, b.memory),
        normal_force=w[at.NORMAL_FORCE],
        knee_strike=w[at.STRIKE_TIME],
        knee_q=(w[at.STRIKE_Q], w[at.STRIKE_Q2], w[at.STRIKE_Q3]),
        knee_dq_before=(w[at.STRIKE_DQ], w[at.STRIKE_DQ2], w[at.STRIKE_DQ3]),
        knee_dq=(w[at.STRUCK_DQ], w[at.STRUCK_DQ2], w[at.STRUCK_DQ3]),
        flexion=w[at.FLEXION],
        stubs=w[at.STUBS],
    )
    for index in range(9):
        w[at.STRIKE_Q + index] = math.nan


def _sides(stance: int, standing: float, thigh: float, flexion: float) -> tuple[float, float, float, float]:
    """Angles of left and right thigh from the vertical, and flexion of left and right knee, rad."""
    if stance == 0:
        return standing, thigh, 0.0, flexion
    return thigh, standing, flexion, 0.0


def write_state(
    constants: SimulationConstants, b: Buffers, row: Any, time: float, state: Sequence[float], estimate: float
) -> None:
    """Fill a row of the samples with a state, with the torques in `w`, and with the slope estimate (rad)."""
    w = b.w
    q1, q2, q3 = state[0], state[1], state[2]
    left, right, left_knee, right_knee = _sides(int(w[at.STANCE]), q1 + w[at.SLOPE], q2 + w[at.SLOPE], q3 - q2)
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


def strike_stop(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float) -> None:
    """The knee strikes its stop, plastically, and locks; the controller is told."""
    w, y, c = b.w, b.y, constants.robot
    y[2] = y[1]
    for i in range(ANGLES):
        c.q[i], c.dq[i] = y[i], y[ANGLES + i]
        w[at.STRIKE_Q + i], w[at.STRIKE_DQ + i] = y[i], y[ANGLES + i]
    c.locked_q[0], c.locked_q[1] = y[0], y[1]
    strike(c.locked_weights, c.knee_before, c.locked_q, c.q, c.dq, c.even, c.odd)
    y[3], y[4], y[5] = c.dq[0], c.dq[1], c.dq[1]
    w[at.STRUCK_DQ], w[at.STRUCK_DQ2], w[at.STRUCK_DQ3] = y[3], y[4], y[5]
    w[at.LOCKED], w[at.STRIKE_TIME] = KNEE_LOCKED, t
    own = len(y) - 2 * ANGLES - JOINTS
    for index in range(own):
        b.memory[index] = y[2 * ANGLES + index]
    laws.knee_strike(parameters, b.memory, t, y[0], y[1], y[2], y[3], y[4], y[5])
    for index in range(own):
        y[2 * ANGLES + index] = b.memory[index]


def note(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> None:
    """Keep the greatest flexion of the knee, also where it lies within the step."""
    w, n = b.w, len(b.y)
    w[at.FLEXION] = max(w[at.FLEXION], b.out[2] - b.out[1])
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
    transfer,
    write_state,
    stops,
    stop_gap,
    stopped_within,
    strike_stop,
    note,
)
"""In the order of `Laws`."""
