r"""Slope identifier: by how much the angular momentum about the stance foot changes otherwise than predicted.

The hip torque does not act on this momentum, and the ankle's is known:

.. math:: \dot\sigma = \tau_1 + G(q, \varphi), \quad
          \dot{\hat\sigma} = \tau_1 + G(q, \hat\varphi) + k (\sigma - \hat\sigma), \quad
          \dot{\hat\varphi} = \gamma \, \frac{G'}{I} \, \frac{\sigma - \hat\sigma}{I}

with the moment of gravity G, its derivative by the slope G', and the inertia I of the robot about its foot. It has the
form of the adaptive law (17) with an error of prediction in the place of the tracking error: tracking errors that a
bounded ankle leaves say nothing of the slope, and this law is not misled by them.
"""

from __future__ import annotations

import math

from controllers.settings import Gains
from controllers.slope_estimator import felt_change
from mjbiped.control.controller import Memory
from mjbiped.robots import compass

SLOPE, MOMENTUM = 0, 1
"""Indices in the memory of the slope's estimate, rad, and of the predicted momentum, kg m²/s."""

OBSERVER_GAIN = 20.0
"""k, 1/s: overdamped with gamma = 0.3 and uniform legs of 1 m, whose frequency is 6.4 rad/s, by a ratio of 1.6."""


def momentum_about_foot(constants: compass.Constants, legs: compass.Legs, dq1: float, dq2: float) -> float:
    """Angular momentum about the stance foot, sigma, kg m²/s: the sum of both rows of M dq."""
    m11, m12, m22 = compass.mass_terms(constants, legs)
    return (m11 + m12) * dq1 + (m12 + m22) * dq2


def begin(memory: Memory, constants: compass.Constants, q1: float, q2: float, dq1: float, dq2: float) -> None:
    """Let the prediction begin with the momentum that a step begins with."""
    memory[MOMENTUM] = momentum_about_foot(constants, compass.legs_of(q1, q2), dq1, dq2)


def identifier_rates(
    constants: compass.Constants, gain: float, memory: Memory, legs: compass.Legs, dq1: float, dq2: float, ankle: float
) -> tuple[float, float]:
    """Rates of the slope's estimate, rad/s, and of the predicted momentum, N m.

    Args:
        constants: Lumped constants of the law's robot model.
        gain: gamma.
        memory: Memory of the controller.
        legs: Sine and cosine of stance and swing angle.
        dq1: Rate of the stance leg, rad/s.
        dq2: Rate of the swing leg, rad/s.
        ankle: Ankle torque, N m.
    """
    sine, cosine = math.sin(memory[SLOPE]), math.cos(memory[SLOPE])
    m11, m12, m22 = compass.mass_terms(constants, legs)
    gc1, gc2, gs1, gs2 = compass.gravity_terms(constants, legs)
    moment = -(gc1 + gc2) * sine - (gs1 + gs2) * cosine
    change = -(gc1 + gc2) * cosine + (gs1 + gs2) * sine
    inertia = m11 + 2.0 * m12 + m22
    error = momentum_about_foot(constants, legs, dq1, dq2) - memory[MOMENTUM]
    return gain * change * error / (inertia * inertia), ankle + moment + OBSERVER_GAIN * error


def update_slope(gains: Gains, memory: Memory, stance_before: float, swing_after: float) -> None:
    """Update (27) of the estimate in the memory, where it is wanted; see `felt_change`."""
    if gains.estimate_update:
        memory[SLOPE] += felt_change(gains.update_threshold, stance_before, swing_after)
