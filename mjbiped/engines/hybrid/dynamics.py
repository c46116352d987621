"""Motion between touchdowns: one integration step of the robot's equations, and its dense output."""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.numerics.dormand_prince import STAGES, STAGES_WITH_DENSE, dense_at

HANDED_ON = ("torque", "parameters", "constants", "length", "memory", "w")
"""What `rates` takes before time and state: for `dormand_prince.unrolled`."""

WILDEST_ANGLE = 1e6  # beyond it, rad, the motion has no meaning, and sine and cosine no digits


def begin(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float) -> None:
    """Rates of the state in `b.y`, which no step has led to."""
    robot, length, memory, w = constants.robot, constants.length, b.memory, b.w
    w[at.STAGE] = 0.0
    laws.begin(laws.rates, laws.torque, parameters, robot, length, memory, w, t, b.y, b.k)


def attempt(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> float:
    """One step of length h from `b.y` to `b.out`; the rates at its start stand in `b.k` already.

    Returns:
        The estimated error over the tolerance; NaN where the motion has no meaning.
    """
    torque, step, robot, length, memory, w = laws.torque, laws.step, constants.robot, constants.length, b.memory, b.w
    for joint in range(constants.joints):
        w[at.STAGE_ANKLE + joint] = 0.0
    w[at.DENSE], w[at.STAGE] = 0.0, 1.0
    w[at.EVALUATIONS] += STAGES
    tolerance = constants.tolerance
    return float(step(laws.rates, torque, parameters, robot, length, memory, w, t, h, b.y, b.k, b.out, tolerance))


def ensure_dense(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> None:
    """Make the step's dense output, unless it is there; torques and press in `b.w` stay those at the step's end."""
    torque, dense, robot, length, memory, w = laws.torque, laws.dense, constants.robot, constants.length, b.memory, b.w
    if w[at.DENSE] != 0.0:
        return
    ankle, hip, knee, press, stop_press = w[at.ANKLE], w[at.HIP], w[at.KNEE], w[at.PRESS], w[at.STOP_PRESS]
    dense(laws.rates, torque, parameters, robot, length, memory, w, t, h, b.y, b.k, b.out, b.dense)
    w[at.ANKLE], w[at.HIP], w[at.KNEE], w[at.PRESS], w[at.STOP_PRESS] = ankle, hip, knee, press, stop_press
    w[at.DENSE] = 1.0
    w[at.EVALUATIONS] += STAGES_WITH_DENSE - STAGES - 1


def is_motion(constants: SimulationConstants, state: Sequence[float]) -> bool:
    """Whether angles and rates are numbers."""
    total = state[0]
    for component in range(1, 2 * constants.angles):
        total += state[component]
    return math.isfinite(total)


def dense_state(b: Buffers, x: float, state: MutableSequence[float]) -> None:
    """The whole state at the share x of the step."""
    n = len(b.y)
    for c in range(n):
        state[c] = dense_at(b.dense, n, c, b.y[c], x)
