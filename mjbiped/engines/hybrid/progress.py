"""Whether a gait step of the hybrid engine gets on: a torque that switches would keep it busy without end.

Where a torque jumps, integration steps shrink until its jump is no more than the tolerance, and then grow again. Where
it jumps to and fro without end (a torque by the sign of a rate, which it brings to zero), they never do, and the motion
all but stands still. Gains beyond what any robot has are of the same effect.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid.state import (
    EVALUATIONS,
    LOOK,
    LOOKED,
    STEP_STARTED,
    UNDER_WAY,
    Buffers,
    SimulationConstants,
)
from mjbiped.numerics.dormand_prince import STAGES

MOST_ATTEMPTS = 100_000  # integration steps tried in one gait step; the paper's controller needs some 20
ATTEMPTS_BETWEEN_LOOKS = 2000
LEAST_PROGRESS = 2e-3
"""Between two looks, of the stall time: at this pace a gait step would need ten times `MOST_ATTEMPTS`."""

TAME = 1e3
"""Of the legs' rates, in sqrt(g / l): the robot moves, and is not about to fly apart."""


def watch(w: Any) -> None:
    """Begin to watch a gait step."""
    w[UNDER_WAY], w[LOOKED] = 1.0, 0.0
    w[STEP_STARTED] = w[EVALUATIONS]
    w[LOOK] = w[STEP_STARTED] + STAGES * ATTEMPTS_BETWEEN_LOOKS


def lags(constants: SimulationConstants, w: Any, t: float) -> bool:
    """Whether a gait step takes too many integration steps, or the last of them have brought it on too little.

    Args:
        constants: Tells the stall time.
        w: Scalars of the walk.
        t: Time since the support transfer, s.
    """
    progress = t - w[LOOKED]
    w[LOOKED], w[LOOK] = t, w[EVALUATIONS] + STAGES * ATTEMPTS_BETWEEN_LOOKS
    tried = w[EVALUATIONS] - w[STEP_STARTED]
    return bool(tried > STAGES * MOST_ATTEMPTS or progress < LEAST_PROGRESS * constants.stall_time)


def is_tame(constants: SimulationConstants, b: Buffers) -> bool:
    """Whether the robot moves as robots do."""
    rates = 0.0
    for component in range(constants.angles, 2 * constants.angles):
        rates += abs(b.y[component])
    return bool(rates < TAME * math.sqrt(constants.gravity / constants.length))
