r"""Slope identifier: from the error of the predicted angular momentum about the stance foot.

The hip torque does not act on this momentum, and the ankle's is known:

.. math:: \dot\sigma = \tau_1 + G(q, \varphi), \quad
          \dot{\hat\sigma} = \tau_1 + G(q, \hat\varphi) + k (\sigma - \hat\sigma), \quad
          \dot{\hat\varphi} = \gamma \, \frac{G'}{I} \, \frac{\sigma - \hat\sigma}{I}

with the moment of gravity G, its derivative by the slope G', and the inertia I of the robot about its foot. The law
has the form of the adaptive law (17), with an error of prediction in place of the tracking error. Tracking errors of a
bounded ankle, which say nothing about the slope, do not mislead it.
"""

from __future__ import annotations

from mjbiped.control.controller import Memory, Numbers
from mjbiped.controllers.dynamics import masses, observe
from mjbiped.controllers.layout import ADAPTATION_GAIN, SEGMENTS, moving_chain
from mjbiped.controllers.room import COSINE, DQ, SINE

SLOPE, MOMENTUM = 0, 1
"""Indices in the memory of the slope's estimate, rad, and of the predicted momentum, kg m²/s."""

OBSERVER_GAIN = 20.0
"""k, 1/s: overdamped with gamma = 0.3 and uniform legs of 1 m, whose frequency is 6.4 rad/s, by a ratio of 1.6."""


def moments_about_foot(
    parameters: Numbers, memory: Numbers, sine: float, cosine: float, room: Numbers
) -> tuple[float, float, float, float]:
    """Return moments about the stance foot: sums of the rows of (1).

    Args:
        parameters: Of the law; see `mjbiped.controllers.layout`.
        memory: Of the controller.
        sine: Sine of the slope, or of its estimate.
        cosine: Cosine of it.
        room: Has the state.

    Returns:
        Angular momentum sigma (kg m²/s), moment of gravity G and its derivative by the slope (N m), and inertia of the
        robot I (kg m²).
    """
    n, chain, first = moving_chain(parameters, memory)
    m11, m12, m22, m13, m23, m33 = masses(chain, first, n, room)
    momentum = (m11 + m12) * room[DQ] + (m12 + m22) * room[DQ + 1]
    inertia = m11 + 2.0 * m12 + m22
    if n > 2:
        momentum += m13 * (room[DQ] + room[DQ + 2]) + m23 * (room[DQ + 1] + room[DQ + 2]) + m33 * room[DQ + 2]
        inertia += 2.0 * (m13 + m23) + m33
    moments, gravity, by_slope = first + n * n, 0.0, 0.0
    for i in range(n):
        moment, s, c = chain[moments + i], room[SINE + i], room[COSINE + i]
        gravity += moment * (s * cosine + c * sine)
        by_slope += moment * (c * cosine - s * sine)
    beside, s, c = chain[moments + n], room[SINE], room[COSINE]
    if beside != 0.0:  # of a bent stance leg's weight
        gravity -= beside * (s * sine - c * cosine)
        by_slope -= beside * (s * cosine + c * sine)
    return momentum, gravity, by_slope, inertia


def identifier_rates(
    parameters: Numbers, memory: Numbers, ankle: float, sine: float, cosine: float, room: Numbers
) -> tuple[float, float]:
    """Return the rates of the slope's estimate, rad/s, and of the predicted momentum, N m, under an ankle torque, N m.

    The other arguments are those of `moments_about_foot`.
    """
    momentum, gravity, by_slope, inertia = moments_about_foot(parameters, memory, sine, cosine, room)
    error = momentum - memory[MOMENTUM]
    slope_rate = parameters[ADAPTATION_GAIN] * by_slope * error / (inertia * inertia)
    return slope_rate, ankle + gravity + OBSERVER_GAIN * error


def begin_prediction(parameters: Numbers, memory: Memory, q: Numbers, dq: Numbers) -> None:
    """Let the predicted momentum begin with the one that a step begins with, at angles (rad) and rates (rad/s)."""
    observe(int(parameters[SEGMENTS]), q, dq, memory)
    memory[MOMENTUM] = moments_about_foot(parameters, memory, 0.0, 1.0, memory)[0]


def slope_estimate(parameters: Numbers, memory: Numbers) -> float:
    """Return the slope estimate, rad."""
    return memory[SLOPE]
