r"""A recovery step: the swing leg follows the stance leg, and the ankle drives the stance leg toward a rate.

The swing leg is led onto a virtual constraint of the stance angle within a time T, and stays on it:

.. math:: q_2 = f(q_1) = q_1 - 2 \alpha - \rho (q_1 - \alpha)

On level ground the feet are then 2 alpha apart at touchdown, whenever that is. So the step needs no clock; T and alpha
decide the energy with which the next step begins. The ankle torque is proportional to the difference from a desired
rate, which rises as the stance leg leans; the sole bounds the torque.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mjbiped.control.controller import Memory, Numbers, Room
from mjbiped.controllers.bounded.identifier import SLOPE
from mjbiped.controllers.bounded.stance import stand
from mjbiped.controllers.dynamics import move_end
from mjbiped.controllers.layout import ANKLE_GAIN, ANKLE_RATE, ANKLE_STIFFNESS
from mjbiped.controllers.replanning import lay, transition, transition_at
from mjbiped.controllers.room import CURVES, DQ, MOTION, POINTS, RECOVERING, REPLANNED, Q

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


def begin(memory: Memory, step: Step, q: Numbers, dq: Numbers) -> None:
    """Plan the way onto the constraint, of degree 5, from the state with which the step begins."""
    memory[RECOVERING], memory[REPLANNED] = 1.0, 0.0
    memory[RECOVERING + 1], memory[RECOVERING + 2], memory[RECOVERING + 3] = step.time, step.half, step.retraction
    away = q[1] - constraint(step, q[0])
    away_rate = dq[1] - (1.0 - step.retraction) * dq[0]
    lay(memory, 1, transition(step.time, (away, away_rate, 0.0), (0.0, 0.0, 0.0)))


def planned(memory: Numbers) -> Step:
    """Return the recovery step in the memory."""
    return Step(memory[RECOVERING + 1], memory[RECOVERING + 2], memory[RECOVERING + 3])


def constraint(step: Step, q1: float) -> float:
    """Return the swing angle on the constraint, rad."""
    return q1 - 2.0 * step.half - step.retraction * (q1 - step.half)


def recover(
    parameters: Numbers, memory: Numbers, t: float, share: float, slope: tuple[float, float], room: Room
) -> float:
    """Write the torques of a recovery step, and the accelerations under them; return the ankle torque, N m.

    Args:
        parameters: Of the law; see `mjbiped.controllers.layout`.
        memory: Of the controller, with the recovery step.
        t: Time since the touchdown, s.
        share: Share of the sole on which the law leans.
        slope: Sine and cosine of the slope, or of its estimate.
        room: Has the state; see `stance.stand`.
    """
    step, q1, q2, dq1, dq2 = planned(memory), room[Q], room[Q + 1], room[DQ], room[DQ + 1]
    follows = 1.0 - step.retraction
    away, away_rate, away_acceleration = 0.0, 0.0, 0.0
    if t < step.time:
        away, away_rate, away_acceleration = transition_at(memory, CURVES + POINTS, step.time, t)
    room[MOTION + 1] = (
        away_acceleration
        + _POSITION_GAIN * (away - (q2 - constraint(step, q1)))
        + _RATE_GAIN * (away_rate - (dq2 - follows * dq1))
    )
    move_end(1, room[MOTION + 1], room)
    lean, upright = parameters[ANKLE_STIFFNESS] * (q1 + memory[SLOPE]), parameters[ANKLE_RATE]
    asked = parameters[ANKLE_GAIN] * (math.sqrt(upright * upright + lean * lean) - dq1)
    return stand(parameters, memory, asked, follows, share, slope, room)
