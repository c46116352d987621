"""Motion between touchdowns (eq. 1): rates of the state, one integration step, and its dense output."""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence, Sequence
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.numerics.dormand_prince import STAGES, STAGES_WITH_DENSE, dense_at
from mjbiped.robots.compass import Constants, acceleration, legs_of, mass_terms, solve_mass

HANDED_ON = ("torque", "parameters", "constants", "length", "memory", "w")
"""What `rates` takes before time and state: for `dormand_prince.unrolled`."""

WILDEST_ANGLE = 1e6  # beyond it, rad, the motion has no meaning, and sine and cosine no digits


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
    for index in range(len(state) - at.ANGLES_AND_RATES - at.WORKS):
        memory[index] = state[at.ANGLES_AND_RATES + index]
    wild = not (abs(q1) < WILDEST_ANGLE and abs(q2) < WILDEST_ANGLE)
    if wild:
        q1 = q2 = dq1 = dq2 = 0.0
    result = torque(parameters, memory, min(max(t, w[at.AFTER]), w[at.BEFORE]), q1, q2, dq1, dq2)
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
) -> tuple[float, float]:
    """Rates after a plastic, frictionless impact on a face: an impulse along x stops the swing foot along x."""
    push1, push2, along1, along2 = face_terms(constants, length, slope, q1, q2)
    impulse = -(along1 * dq1 + along2 * dq2) / (along1 * push1 + along2 * push2)
    return dq1 + push1 * impulse, dq2 + push2 * impulse


def begin(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float) -> None:
    """Rates of the state in `b.y`, which no step has led to."""
    robot, length, memory, w = constants.robot, constants.length, b.memory, b.w
    laws.begin(rates, laws.torque, parameters, robot, length, memory, w, t, b.y, b.k)


def attempt(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> float:
    """One step of length h from `b.y` to `b.out`; the rates at its start stand in `b.k` already.

    Returns:
        The estimated error over the tolerance; NaN where the motion has no meaning.
    """
    torque, step, robot, length, memory, w = laws.torque, laws.step, constants.robot, constants.length, b.memory, b.w
    w[at.STAGE_ANKLE] = w[at.STAGE_HIP] = w[at.DENSE] = 0.0
    w[at.EVALUATIONS] += STAGES
    tolerance = constants.tolerance
    return float(step(rates, torque, parameters, robot, length, memory, w, t, h, b.y, b.k, b.out, tolerance))


def ensure_dense(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> None:
    """Make the step's dense output, unless it is there; torques and press in `b.w` stay those at the step's end."""
    torque, dense, robot, length, memory, w = laws.torque, laws.dense, constants.robot, constants.length, b.memory, b.w
    if w[at.DENSE] != 0.0:
        return
    ankle, hip, press = w[at.ANKLE], w[at.HIP], w[at.PRESS]
    dense(rates, torque, parameters, robot, length, memory, w, t, h, b.y, b.k, b.out, b.dense)
    w[at.ANKLE], w[at.HIP], w[at.PRESS] = ankle, hip, press
    w[at.DENSE] = 1.0
    w[at.EVALUATIONS] += STAGES_WITH_DENSE - STAGES - 1


def is_motion(state: Sequence[float]) -> bool:
    """Whether angles and rates are numbers."""
    return math.isfinite(state[0] + state[1] + state[2] + state[3])


def dense_state(b: Buffers, x: float, state: MutableSequence[float]) -> None:
    """The whole state at the share x of the step."""
    n = len(b.y)
    for c in range(n):
        state[c] = dense_at(b.dense, n, c, b.y[c], x)
