"""Motion between touchdowns (eq. 1): rates of the state, one integration step, and its dense output."""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence, Sequence
from typing import Any

from mjbiped.compass import Constants, acceleration, mass_terms, solve_mass
from mjbiped.dormand_prince import (
    STAGES,
    STAGES_WITH_DENSE,
    dense_at,
    dense_coefficients,
    error_of,
    stage_state,
)
from mjbiped.hybrid_state import (
    AFTER,
    ANGLES_AND_RATES,
    ANKLE,
    BEFORE,
    COSINE,
    DENSE,
    EVALUATIONS,
    FACE,
    HIP,
    PRESS,
    SINE,
    SLOPE,
    STAGE_ANKLE,
    STAGE_HIP,
    WORKS,
    Buffers,
    World,
)

WILDEST_ANGLE = 1e6  # beyond it, rad, the motion has no meaning, and sine and cosine no digits


def rates(
    torque: Callable[..., Sequence[float]],
    parameters: Any,
    constants: Constants,
    length: float,
    memory: Any,
    w: Any,
    t: float,
    y: Sequence[float],
    k: Any,
    at: int,
) -> None:
    """Write the rates of the state y at time t since the leg exchange into `k` from place `at` on.

    This innermost function takes the few sequences that it needs instead of whole buffers: where compiled, handing over
    a tuple of arrays costs more than the equations of motion.
    """
    n = len(y)
    own = n - ANGLES_AND_RATES - WORKS
    q1, q2, dq1, dq2 = y[0], y[1], y[2], y[3]
    w[EVALUATIONS] += 1.0
    if not (abs(q1) < WILDEST_ANGLE and abs(q2) < WILDEST_ANGLE):
        for c in range(n):
            k[at + c] = math.nan
        return
    for index in range(own):
        memory[index] = y[ANGLES_AND_RATES + index]
    result = torque(parameters, memory, min(max(t, w[AFTER]), w[BEFORE]), q1, q2, dq1, dq2)
    ankle, hip = result[0], result[1]
    for index in range(own):
        k[at + ANGLES_AND_RATES + index] = result[2 + index]
    ddq1, ddq2 = acceleration(constants, q1, q2, dq1, dq2, w[SINE], w[COSINE], ankle - hip, hip)
    if w[FACE] != 0.0:
        slope = w[SLOPE]
        push1, push2, along1, along2 = face_terms(constants, length, slope, q1, q2)
        bend = length * (math.sin(q2 + slope) * dq2 * dq2 - math.sin(q1 + slope) * dq1 * dq1)
        force = -(along1 * ddq1 + along2 * ddq2 + bend) / (along1 * push1 + along2 * push2)
        ddq1 += push1 * force
        ddq2 += push2 * force
        w[PRESS] = -w[FACE] * force
    k[at], k[at + 1], k[at + 2], k[at + 3] = dq1, dq2, ddq1, ddq2
    k[at + n - 2] = ankle * dq1
    k[at + n - 1] = hip * (dq2 - dq1)
    w[ANKLE], w[HIP] = ankle, hip
    w[STAGE_ANKLE] = max(w[STAGE_ANKLE], abs(ankle))
    w[STAGE_HIP] = max(w[STAGE_HIP], abs(hip))


def face_terms(
    constants: Constants, length: float, slope: float, q1: float, q2: float
) -> tuple[float, float, float, float]:
    """Accelerations of the legs by a unit force along x at the swing foot (M^-1 J'), and its way per angle (J)."""
    along1, along2 = length * math.cos(q1 + slope), -length * math.cos(q2 + slope)
    m11, m12, m22 = mass_terms(constants, q1, q2)
    push1, push2 = solve_mass(m11, m12, m22, along1, along2)
    return push1, push2, along1, along2


def strike_rates(
    constants: Constants, length: float, slope: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float]:
    """Rates after a plastic, frictionless strike: an impulse along x takes the swing foot's horizontal speed."""
    push1, push2, along1, along2 = face_terms(constants, length, slope, q1, q2)
    impulse = -(along1 * dq1 + along2 * dq2) / (along1 * push1 + along2 * push2)
    return dq1 + push1 * impulse, dq2 + push2 * impulse


def attempt(
    torque: Callable[..., Sequence[float]], parameters: Any, world: World, b: Buffers, t: float, h: float
) -> float:
    """One step of length h from `b.y` to `b.out`; the rates at its start stand in `b.k` already.

    Returns:
        The estimated error over the tolerance; NaN where the motion has no meaning.
    """
    y, out, k, w, memory = b.y, b.out, b.k, b.w, b.memory
    a, c = world.scheme.a, world.scheme.c
    n = len(y)
    w[STAGE_ANKLE] = w[STAGE_HIP] = w[DENSE] = 0.0
    for stage in range(1, STAGES + 1):
        stage_state(a, stage, h, y, k, out)
        rates(torque, parameters, world.constants, world.length, memory, w, t + c[stage] * h, out, k, stage * n)
    return error_of(world.scheme.e3, world.scheme.e5, h, y, out, k, world.tolerance)


def ensure_dense(
    torque: Callable[..., Sequence[float]], parameters: Any, world: World, b: Buffers, t: float, h: float
) -> None:
    """Make the step's dense output, unless it is there."""
    if b.w[DENSE] != 0.0:
        return
    y, spare, k, w, memory = b.y, b.spare, b.k, b.w, b.memory
    a, c = world.scheme.a, world.scheme.c
    n = len(y)
    for stage in range(STAGES + 1, STAGES_WITH_DENSE):
        stage_state(a, stage, h, y, k, spare)
        rates(torque, parameters, world.constants, world.length, memory, w, t + c[stage] * h, spare, k, stage * n)
    dense_coefficients(world.scheme.d, h, y, b.out, k, b.dense)
    b.w[DENSE] = 1.0


def dense_state(b: Buffers, x: float, state: MutableSequence[float]) -> None:
    """The whole state at the share x of the step."""
    n = len(b.y)
    for c in range(n):
        state[c] = dense_at(b.dense, n, c, b.y[c], x)
