"""Impacts of the biped with knees in the hybrid engine: of the foot on a face, of the knee on its stop, of the heel."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.kneed_posture import (
    ANGLES,
    JOINTS,
    KneedConstants,
    hip,
    pose,
    sides,
    stand,
    swing_foot,
)
from mjbiped.engines.hybrid.state import KNEE_FREE, KNEE_LOCKED, KNEE_RESTING, Buffers, Laws, SimulationConstants
from mjbiped.engines.hybrid.transfer import stand_on
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.records.rows import write_kneed_touchdown
from mjbiped.robots.bent_leg import FLEXION, LEAN
from mjbiped.robots.chain import Array, constrain, strike, strike_stiff


def held(
    weights: Array,
    reach: Array,
    slope: float,
    x: float,
    z: float,
    q: Array,
    dq: Array,
    ddq: Array,
    row: Array,
    push: Array,
    even: Array,
    odd: Array,
) -> float:
    """Let a surface hold the swing foot along its normal (x, z), without friction.

    Accelerations are changed, and the force along the normal is returned, N.
    """
    bend = 0.0
    for i in range(len(q)):
        sine, cosine = sine_cosine(q[i] + slope)
        row[i] = reach[i] * (cosine * x - sine * z)
        bend -= reach[i] * (sine * x + cosine * z) * dq[i] * dq[i]
    return constrain(weights, q, row, bend, even, odd, push, ddq)


def hit_face(constants: SimulationConstants, b: Buffers) -> float:
    """A vertical face stops the swing foot; a locked knee stays locked. Returns the face's impulse, N s."""
    return _stop_foot(constants, b)


def stub(constants: SimulationConstants, b: Buffers) -> float:
    """The ground beside or behind the stance foot stops the swing foot, which slides on it from now on.

    Returns the ground's impulse on it, N s, or NaN where the foot is ahead.
    """
    w, segment = b.w, int(b.w[at.LANDING])
    x, _ = swing_foot(constants, b, pose(b, b.y))
    if x > w[at.FOOT_X]:
        return math.nan
    if w[at.GROUND_SEGMENT] != segment:
        w[at.STUBS] += 1.0
    slope = constants.angle[segment]
    w[at.GROUND], w[at.GROUND_SEGMENT], w[at.FACE] = 1.0, segment, 0.0
    w[at.PUSHED_X], w[at.PUSHED_Z] = math.sin(slope), math.cos(slope)
    return _stop_foot(constants, b)


def _stop_foot(constants: SimulationConstants, b: Buffers) -> float:
    """A plastic impact of the swing foot without friction, along the normal in `w`; the stance foot stays.

    Returns the impulse along that normal, N s.
    """
    c, w, y = constants.robot, b.w, b.y
    slope, x, z = w[at.SLOPE], w[at.PUSHED_X], w[at.PUSHED_Z]
    if w[at.LOCKED] != KNEE_LOCKED:
        for i in range(ANGLES):
            c.q[i], c.ddq[i], c.dq[i] = y[i], y[ANGLES + i], 0.0
        impulse = held(c.free_weights, c.reach, slope, x, z, c.q, c.dq, c.ddq, c.row, c.push, c.even, c.odd)
        if w[at.LOCKED] == KNEE_FREE or c.ddq[2] > c.ddq[1]:
            w[at.LOCKED] = KNEE_FREE
            for i in range(ANGLES):
                y[ANGLES + i] = c.ddq[i]
            return impulse
    for i in range(2):  # the knee is locked, or its stop bears the impact
        c.locked_q[i], c.locked_ddq[i], c.locked_dq[i] = y[i], y[ANGLES + i], 0.0
    row, push, even, odd = c.locked_row, c.locked_push, c.locked_even, c.locked_odd
    q, dq, ddq = c.locked_q, c.locked_dq, c.locked_ddq
    impulse = held(c.locked_weights, c.locked_reach, slope, x, z, q, dq, ddq, row, push, even, odd)
    y[3], y[4], y[5] = ddq[0], ddq[1], ddq[1]
    return impulse


def lands(constants: SimulationConstants, b: Buffers) -> bool:
    """A foot that comes down ahead of the other one takes the robot over, if the other one then leaves the ground.

    With a straight leg it does; with a bent one that is looked at.
    """
    x, _ = swing_foot(constants, b, pose(b, b.y))
    if x <= b.w[at.FOOT_X]:
        return False
    if b.w[at.LOCKED] == KNEE_LOCKED and b.w[at.STANCE_FLEXION] == 0.0:
        return True
    c = constants.robot
    new, old = _strike_bent(c, b.y)
    rise = 0.0
    for i in range(4):
        sine, _ = sine_cosine(c.all_q[i])
        rise += c.ends[i] * sine * (old if c.legs[i] == 0 else new)
    return rise > 0.0


def _strike_bent(c: KneedConstants, y: Any) -> tuple[float, float]:
    """Rates, after an impact with bent knees, of the leg that strikes the ground and of the one that leaves it."""
    q, dq, shank = c.all_q, c.all_dq, y[0] + c.stance[LEAN]
    q[0], q[1], q[2], q[3] = shank, shank - c.stance[FLEXION], y[1], y[2]
    dq[0], dq[1], dq[2], dq[3] = y[3], y[3], y[4], y[5]
    strike_stiff(c.about_end, c.onto_end, c.legs, q, dq, c.all_even, c.all_odd)
    return dq[1], dq[0]


def transfer(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, segment: int, foot_x: float
) -> None:
    """The heel's impact, new roles, the controller's touchdown, and a row of the record."""
    w, y, n, c = b.w, b.y, len(b.y), constants.robot
    own = n - 2 * ANGLES - JOINTS
    slope = constants.angle[segment]
    q1, q2, q3, dq1, dq2, dq3 = y[0], y[1], y[2], y[3], y[4], y[5]
    hip_x, hip_z = hip(constants, b, pose(b, y))
    left, right, left_knee, right_knee = sides(c, w, q1, q2, q3)
    turned = w[at.SLOPE] - slope
    standing = 0.0 if w[at.LOCKED] == KNEE_LOCKED else q3 - q2
    bent = w[at.STANCE_FLEXION]
    if standing == 0.0 and bent == 0.0:
        c.locked_q[0], c.locked_q[1], c.locked_dq[0], c.locked_dq[1] = q1, q2, dq1, dq2
        strike(c.heel_after, c.heel_before, c.locked_q, c.locked_q, c.locked_dq, c.locked_even, c.locked_odd)
        rate1, rate2 = c.locked_dq[1], c.locked_dq[0]
        new1, new2, new3 = q2 + turned, q1 + turned, q1 + turned
    else:
        rate1, rate2 = _strike_bent(c, y)
        shank = q1 + c.stance[LEAN]
        w[at.STANCE_FLEXION] = standing
        stand(c, standing)
        new1, new2, new3 = q3 - c.stance[LEAN] + turned, shank - bent + turned, shank + turned
    for index in range(own):
        b.memory[index] = y[2 * ANGLES + index]
    estimate_before = laws.slope_estimate(parameters, b.memory)
    laws.touchdown(parameters, b.memory, (q1, q2, q3), (new1, new2, new3), (rate1, rate2, rate2))
    stand_on(constants, w, segment, foot_x)
    y[0], y[1], y[2], y[3], y[4], y[5] = new1, new2, new3, rate1, rate2, rate2
    w[at.LOCKED] = KNEE_RESTING if bent == 0.0 else KNEE_FREE
    for index in range(own):
        y[2 * ANGLES + index] = b.memory[index]
    for joint in range(JOINTS):
        y[n - JOINTS + joint] = 0.0
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
        pressure_ahead=w[at.PRESSURE_AHEAD],
        pressure_behind=w[at.PRESSURE_BEHIND],
        knee_strike=w[at.STRIKE_TIME],
        knee_q=(w[at.STRIKE_Q], w[at.STRIKE_Q2], w[at.STRIKE_Q3]),
        knee_dq_before=(w[at.STRIKE_DQ], w[at.STRIKE_DQ2], w[at.STRIKE_DQ3]),
        knee_dq=(w[at.STRUCK_DQ], w[at.STRUCK_DQ2], w[at.STRUCK_DQ3]),
        flexion=w[at.FLEXION],
        stubs=w[at.STUBS],
    )
    for index in range(9):
        w[at.STRIKE_Q + index] = math.nan


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
    laws.knee_strike(parameters, b.memory, t, (y[0], y[1], y[2]), (y[3], y[4], y[5]))
    for index in range(own):
        y[2 * ANGLES + index] = b.memory[index]
