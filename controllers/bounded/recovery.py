r"""A recovery step: the swing leg follows the stance leg, and the ankle drives that toward a rate.

The swing leg is led onto a virtual constraint of the stance angle within a time T, and stays on it:

.. math:: q_2 = f(q_1) = q_1 - 2 \alpha - \rho (q_1 - \alpha)

On level ground the feet are then 2 alpha apart at touchdown, whenever that is. So the step needs no clock, and a short
or a long swing, a narrow or a wide step decides with how much energy the next one begins. The ankle torque is
proportional to the lack of a rate that is higher the further the stance leg leans; the sole bounds it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mjbiped.control.controller import Memory
from mjbiped.controllers.adaptive import CURVES
from mjbiped.controllers.bounded.identifier import SLOPE
from mjbiped.controllers.bounded.stance import SUPPORT, Driven, Model, driven, standing
from mjbiped.controllers.replanning import POINTS, lay, transition, transition_at
from mjbiped.controllers.settings import REPLANNED
from mjbiped.robots import compass

RECOVERING = SUPPORT + 2
"""Index in the memory of whether this is a recovery step; behind it stand its `Step`'s numbers."""

SIZE = RECOVERING + 4
"""Floats of a memory with a recovery step."""

_POSITION_GAIN, _RATE_GAIN = 400.0, 40.0  # 1/s², 1/s: the constraint's error decays critically, with 20/s


class Step(NamedTuple):
    """A recovery step.

    Attributes:
        time: T, s.
        half: alpha, rad.
        retraction: rho.
    """

    time: float
    half: float
    retraction: float


class Ankle(NamedTuple):
    """The ankle in recovery steps.

    Attributes:
        gain: Torque for each rad/s by which the stance leg is too slow, N m s.
        rate: Rate of an upright stance leg, rad/s.
        stiffness: Rate for each rad of its angle from the vertical, rad/s.
    """

    gain: float
    rate: float
    stiffness: float


def begin(memory: Memory, step: Step, q1: float, q2: float, dq1: float, dq2: float) -> None:
    """Plan the way onto the constraint, of degree 5, from the state with which the step begins."""
    memory[RECOVERING], memory[REPLANNED] = 1.0, 0.0
    memory[RECOVERING + 1], memory[RECOVERING + 2], memory[RECOVERING + 3] = step.time, step.half, step.retraction
    away = q2 - constraint(step, q1)
    away_rate = dq2 - (1.0 - step.retraction) * dq1
    lay(memory, CURVES, 1, transition(step.time, away, away_rate, 0.0, 0.0, 0.0, 0.0))


def planned(memory: Memory) -> Step:
    """The recovery step in the memory."""
    return Step(memory[RECOVERING + 1], memory[RECOVERING + 2], memory[RECOVERING + 3])


def constraint(step: Step, q1: float) -> float:
    """Swing angle on the constraint, rad."""
    return q1 - 2.0 * step.half - step.retraction * (q1 - step.half)


def motion(
    model: Model, ankle: Ankle, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> Driven:
    """Torques of a recovery step, and the accelerations that the law's model has under them."""
    step = planned(memory)
    share = 1.0 - step.retraction
    away, away_rate, away_acceleration = 0.0, 0.0, 0.0
    if t < step.time:
        away, away_rate, away_acceleration = transition_at(memory, CURVES + POINTS, step.time, t)
    offset = (
        away_acceleration
        + _POSITION_GAIN * (away - (q2 - constraint(step, q1)))
        + _RATE_GAIN * (away_rate - (dq2 - share * dq1))
    )
    lean = ankle.stiffness * (q1 + memory[SLOPE])
    asked = ankle.gain * (math.sqrt(ankle.rate * ankle.rate + lean * lean) - dq1)
    slope = math.sin(memory[SLOPE]), math.cos(memory[SLOPE])
    return driven(standing(model, memory), compass.legs_of(q1, q2), dq1, dq2, slope, asked, offset, share)
