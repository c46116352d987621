"""The compass biped in the hybrid engine: its equations (1), impact map (2) and geometry as the engine's functions.

`mjbiped.engines.hybrid.state.Laws` says what each of the functions of `MODEL` is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.dynamics import WILDEST_ANGLE
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.engines.hybrid.transfer import stand_on
from mjbiped.numerics.dormand_prince import dense_at, dense_rate_at
from mjbiped.records.rows import SAMPLED, write_sample, write_touchdown
from mjbiped.robots import compass
from mjbiped.robots.compass import Constants, Legs, acceleration, impact_rates, legs_of, mass_terms, solve_mass

JOINTS = 2


def rates(
    torque: Callable[..., tuple[float, ...]],
    parameters: Any,
    constants: Constants,
    length: float,
    memory: Any,
    w: Any,
    t: float,
    state: tuple[float, ...],
) -> tuple[float, ...]:
    """Rates of a state at time t since the support transfer; `w` says whether the swing foot slides on a face.

    This innermost function takes the few sequences that it needs instead of whole buffers: where compiled, handing over
    a tuple of arrays costs more than the equations of motion.
    """
    q1, q2, dq1, dq2 = state[0], state[1], state[2], state[3]
    for index in range(len(state) - at.ANGLES_AND_RATES - JOINTS):
        memory[index] = state[at.ANGLES_AND_RATES + index]
    wild = not (abs(q1) < WILDEST_ANGLE and abs(q2) < WILDEST_ANGLE)
    if wild:
        q1 = q2 = dq1 = dq2 = 0.0
    result = torque(parameters, memory, min(max(t, w[at.AFTER]), w[at.BEFORE]), (q1, q2), (dq1, dq2))
    ankle, hip = result[0], result[1]
    stance = ankle - hip
    if w[at.PUSH] != 0.0:
        stance += push_torque(length, w, q1)
    ddq1, ddq2 = acceleration(constants, q1, q2, dq1, dq2, w[at.SINE], w[at.COSINE], stance, hip)
    if w[at.FACE] != 0.0:
        ddq1, ddq2 = on_face(constants, length, w, q1, q2, dq1, dq2, ddq1, ddq2)
    if wild:
        ddq1 = math.nan
    w[at.ANKLE], w[at.HIP] = ankle, hip
    w[at.ANKLE_TORQUES + int(w[at.STAGE])] = ankle
    w[at.STAGE] += 1.0
    greater = abs(ankle) > w[at.STAGE_ANKLE]
    w[at.STAGE_ANKLE] = abs(ankle) if greater else w[at.STAGE_ANKLE]
    w[at.WHEN_ANKLE] = t if greater else w[at.WHEN_ANKLE]
    greater = abs(hip) > w[at.STAGE_HIP]
    w[at.STAGE_HIP] = abs(hip) if greater else w[at.STAGE_HIP]
    w[at.WHEN_HIP] = t if greater else w[at.WHEN_HIP]
    return (dq1, dq2, ddq1, ddq2) + result[2:] + (ankle * dq1, hip * (dq2 - dq1))  # noqa: RUF005 (Numba adds tuples)


def push_torque(length: float, w: Any, q1: float) -> float:
    """What a horizontal force at the hip is to the stance leg: its torque about the foot, N m."""
    return float(w[at.PUSH] * length * math.cos(q1 + w[at.SLOPE]))


def on_face(
    constants: Constants,
    length: float,
    w: Any,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
    ddq1: float,
    ddq2: float,
) -> tuple[float, float]:
    """Accelerations of the legs while the swing foot slides along a vertical face, from those without the face."""
    slope = w[at.SLOPE]
    push1, push2, along1, along2 = face_terms(constants, length, slope, q1, q2)
    bend = length * (math.sin(q2 + slope) * dq2 * dq2 - math.sin(q1 + slope) * dq1 * dq1)
    force = -(along1 * ddq1 + along2 * ddq2 + bend) / (along1 * push1 + along2 * push2)
    w[at.PRESS] = -w[at.FACE] * force
    return ddq1 + push1 * force, ddq2 + push2 * force


def face_terms(
    constants: Constants, length: float, slope: float, q1: float, q2: float
) -> tuple[float, float, float, float]:
    """Accelerations of the legs by a unit force along x at the swing foot (M^-1 J'), and the foot's Jacobian (J)."""
    along1, along2 = length * math.cos(q1 + slope), -length * math.cos(q2 + slope)
    m11, m12, m22 = mass_terms(constants, legs_of(q1, q2))
    push1, push2 = solve_mass(m11, m12, m22, along1, along2)
    return push1, push2, along1, along2


def face_impact_rates(
    constants: Constants, length: float, slope: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float]:
    """Rates after a plastic, frictionless impact on a face: an impulse along x (N s, at last) stops the swing foot."""
    push1, push2, along1, along2 = face_terms(constants, length, slope, q1, q2)
    impulse = -(along1 * dq1 + along2 * dq2) / (along1 * push1 + along2 * push2)
    return dq1 + push1 * impulse, dq2 + push2 * impulse, impulse


def asked(
    torque: Callable[..., tuple[float, ...]], parameters: Any, memory: Any, t: float, state: Sequence[float]
) -> tuple[float, float]:
    """Torques of the law in a state."""
    result = torque(parameters, memory, t, (state[0], state[1]), (state[2], state[3]))
    return result[0], result[1]


def ticked(tick: Callable[..., None], parameters: Any, memory: Any, t: float, state: Sequence[float]) -> None:
    """The law ticks."""
    tick(parameters, memory, t, (state[0], state[1]), (state[2], state[3]))


def legs_at(b: Buffers, q1: float, q2: float) -> Legs:
    """Sine and cosine of the stance leg's and of the swing leg's angle from the vertical."""
    return legs_of(q1 + b.w[at.SLOPE], q2 + b.w[at.SLOPE])


def pose(b: Buffers, state: Sequence[float]) -> Legs:
    """The legs in a state."""
    return legs_at(b, state[0], state[1])


def pose_between(b: Buffers, x: float) -> Legs:
    """The legs at the share x of the step."""
    n = len(b.y)
    return legs_at(b, dense_at(b.dense, n, 0, b.y[0], x), dense_at(b.dense, n, 1, b.y[1], x))


def swing_foot(constants: SimulationConstants, b: Buffers, legs: Legs) -> tuple[float, float]:
    """Place x, z of the swing foot, m."""
    sine1, cosine1, sine2, cosine2 = legs
    return b.w[at.FOOT_X] + constants.length * (sine1 - sine2), b.w[at.FOOT_Z] + constants.length * (cosine1 - cosine2)


def foot_speed(constants: SimulationConstants, b: Buffers, legs: Legs) -> tuple[float, float]:
    """Its rates at the step's end, m/s."""
    sine1, cosine1, sine2, cosine2 = legs
    return (
        constants.length * (cosine1 * b.out[2] - cosine2 * b.out[3]),
        constants.length * (sine2 * b.out[3] - sine1 * b.out[2]),
    )


def foot_rush(constants: SimulationConstants, b: Buffers, first: int, state: Sequence[float]) -> float:
    """Bound of the swing foot's acceleration in a state, m/s^2."""
    legs = abs(b.k[first + 2]) + abs(b.k[first + 3]) + state[2] * state[2] + state[3] * state[3]
    return float(constants.length * legs)


def hip(constants: SimulationConstants, b: Buffers, legs: Legs) -> tuple[float, float]:
    """Place x, z of the hip, m."""
    return b.w[at.FOOT_X] + constants.length * legs[0], b.w[at.FOOT_Z] + constants.length * legs[1]


def force_at(
    constants: SimulationConstants, b: Buffers, legs: Legs, state: Sequence[float], place: int
) -> tuple[float, float]:
    """Force of the ground, forward and upward, N."""
    return compass.ground_force(
        constants.robot, constants.mass, constants.gravity, legs, state[2], state[3], b.k[place + 2], b.k[place + 3]
    )


def force_within(constants: SimulationConstants, b: Buffers, legs: Legs, x: float, h: float) -> tuple[float, float]:
    """The same within the step."""
    n = len(b.y)
    ddq1, ddq2 = dense_rate_at(b.dense, n, 2, x) / h, dense_rate_at(b.dense, n, 3, x) / h
    return compass.ground_force(
        constants.robot, constants.mass, constants.gravity, legs, b.spare[2], b.spare[3], ddq1, ddq2
    )


def hit_face(constants: SimulationConstants, b: Buffers) -> float:
    """A vertical face stops the swing foot; returns the face's impulse, away from it, N s."""
    y, slope = b.y, b.w[at.SLOPE]
    y[2], y[3], impulse = face_impact_rates(constants.robot, constants.length, slope, y[0], y[1], y[2], y[3])
    return float(-b.w[at.FACE] * impulse)


def lands(constants: SimulationConstants, b: Buffers) -> bool:  # noqa: ARG001 (robots with knees look)
    """Every foot that comes down takes the robot over."""
    return True


def stub(constants: SimulationConstants, b: Buffers) -> float:  # noqa: ARG001 (robots with knees do)
    """Straight legs always take over."""
    return math.nan


def transfer(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, segment: int, foot_x: float
) -> None:
    """Impact map (2), new roles, the controller's touchdown, and a row of the record."""
    w, y, n = b.w, b.y, len(b.y)
    own = n - at.ANGLES_AND_RATES - JOINTS
    old_slope, stance, slope = w[at.SLOPE], int(w[at.STANCE]), constants.angle[segment]
    q1, q2, dq1, dq2 = y[0], y[1], y[2], y[3]
    hip_x, hip_z = hip(constants, b, legs_at(b, q1, q2))
    new1, new2 = q2 + old_slope - slope, q1 + old_slope - slope
    rate1, rate2 = impact_rates(constants.robot, q1, q2, dq1, dq2)
    for index in range(own):
        b.memory[index] = y[at.ANGLES_AND_RATES + index]
    estimate_before = laws.slope_estimate(parameters, b.memory)
    laws.touchdown(parameters, b.memory, (q1, q2), (new1, new2), (rate1, rate2))
    stand_on(constants, w, segment, foot_x)
    y[0], y[1], y[2], y[3] = new1, new2, rate1, rate2
    for index in range(own):
        y[at.ANGLES_AND_RATES + index] = b.memory[index]
    y[n - 2] = y[n - 1] = 0.0
    left, right = q1 + old_slope, q2 + old_slope
    if stance == 1:
        left, right = right, left
    write_touchdown(
        b.rows[int(w[at.ROWS])],
        0,
        time=w[at.TIME],
        qpos=(hip_x, hip_z, left, right),
        x=w[at.FOOT_X],
        z=w[at.FOOT_Z],
        stance=w[at.STANCE],
        slope=slope,
        q_before=(q1, q2),
        dq_before=(dq1, dq2),
        q=(new1, new2),
        dq=(rate1, rate2),
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
    )


def write_state(
    constants: SimulationConstants, b: Buffers, row: Any, time: float, state: Sequence[float], estimate: float
) -> None:
    """Fill a row of the samples with a state, with the torques in `w`, and with the slope estimate (rad)."""
    w = b.w
    left, right = state[0] + w[at.SLOPE], state[1] + w[at.SLOPE]
    if w[at.STANCE] != 0.0:
        left, right = right, left
    x, z = hip(constants, b, legs_at(b, state[0], state[1]))
    write_sample(
        row,
        0,
        time=time,
        q=(state[0], state[1]),
        dq=(state[2], state[3]),
        torque=(w[at.ANKLE], w[at.HIP]),
        slope=w[at.SLOPE],
        slope_estimate=estimate,
        stance=w[at.STANCE],
        qpos=(x, z, left, right),
    )
    for index in range(len(b.y) - at.ANGLES_AND_RATES - JOINTS):
        row[SAMPLED + index] = state[at.ANGLES_AND_RATES + index]


def stops(constants: SimulationConstants, b: Buffers) -> bool:  # noqa: ARG001 (the legs are straight)
    """There is no knee."""
    return False


def stop_gap(b: Buffers) -> tuple[float, float]:  # noqa: ARG001
    """There is no knee."""
    return 0.0, 0.0


def stopped_within(b: Buffers, x: float) -> bool:  # noqa: ARG001
    """There is no knee."""
    return False


def strike_stop(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float) -> None:
    """There is no knee."""


def note(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> None:
    """Nothing beyond what every robot's rows tell."""


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
