"""What impacts ask of the ground under the stance foot: the impulse that holds it, spread over a short time.

The ratio of an impulse alone says little, for the slightest touch has that of a strong one. What counts is whether a
real foot would slide or hop: so the impulse is spread over `AVERAGED`, as MuJoCo's forces are, and added to the force
after the impact.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.accounting import note_force
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.rules.termination import AVERAGED


def momentum(laws: Laws, constants: SimulationConstants, b: Buffers) -> tuple[float, float]:
    """Momentum of the robot in the state `b.y`, forward and upward, kg m/s.

    It depends on the rates as the ground's force on the accelerations. Takes `b.spare` and the first stage of `b.k`.
    """
    angles = constants.angles
    for i in range(angles):
        b.spare[i], b.spare[angles + i] = b.y[i], 0.0
        b.k[angles + i] = b.y[angles + i]
    forward, upward = laws.force_at(constants, b, laws.pose(b, b.spare), b.spare, 0)
    return forward, upward - constants.mass * constants.gravity


def note_impulse(
    laws: Laws, constants: SimulationConstants, b: Buffers, before: tuple[float, float], push: float
) -> None:
    """Keep the stance foot's impulse in an impact, N s.

    Args:
        laws: The robot's functions.
        constants: Robot and ground.
        b: State after the impact.
        before: Momentum before it, kg m/s.
        push: Impulse on the swing foot, along `PUSHED_X` and `PUSHED_Z`, N s.
    """
    w, (forward, upward) = b.w, momentum(laws, constants, b)
    w[at.IMPULSE_X] = forward - before[0] - push * w[at.PUSHED_X]
    w[at.IMPULSE_Z] = upward - before[1] - push * w[at.PUSHED_Z]


def note_impact(constants: SimulationConstants, w: Any) -> None:
    """Take the impulse that has led to the state, if one has, into the step's normal force and friction."""
    x, z, time = w[at.IMPULSE_X], w[at.IMPULSE_Z], AVERAGED * math.sqrt(constants.length / constants.gravity)
    if x != 0.0 or z != 0.0:
        along, normal = (x * w[at.COSINE] - z * w[at.SINE]) / time, (x * w[at.SINE] + z * w[at.COSINE]) / time
        note_force(constants, w, w[at.ALONG_NOW] + along, w[at.NORMAL_NOW] + normal)
        w[at.IMPULSE_X] = w[at.IMPULSE_Z] = 0.0
