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

from typing import NamedTuple

from mjbiped.control.controller import Memory
from mjbiped.controllers.settings import Gains
from mjbiped.controllers.slope_estimator import felt_change
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots import compass
from mjbiped.robots.bent_leg import gravity_beside
from mjbiped.robots.chain import Array

SLOPE, MOMENTUM = 0, 1
"""Indices in the memory of the slope's estimate, rad, and of the predicted momentum, kg m²/s."""

OBSERVER_GAIN = 20.0
"""k, 1/s: overdamped with gamma = 0.3 and uniform legs of 1 m, whose frequency is 6.4 rad/s, by a ratio of 1.6."""


class AboutFoot(NamedTuple):
    """Moments about the stance foot.

    Attributes:
        momentum: Angular momentum, sigma, kg m²/s.
        gravity: Moment of gravity on a slope, G, N m.
        by_slope: Its derivative by the slope, G', N m.
        inertia: Of the whole robot, I, kg m².
    """

    momentum: float
    gravity: float
    by_slope: float
    inertia: float


def compass_about_foot(
    constants: compass.Constants, legs: compass.Legs, dq1: float, dq2: float, sine: float, cosine: float
) -> AboutFoot:
    """Moments about the foot of a compass: sums of the rows of (1).

    Args:
        constants: Lumped constants of the robot.
        legs: Sine and cosine of stance and swing angle.
        dq1: Rate of the stance leg, rad/s.
        dq2: Rate of the swing leg, rad/s.
        sine: Sine of the slope, or of its estimate.
        cosine: Cosine of it.
    """
    m11, m12, m22 = compass.mass_terms(constants, legs)
    gc1, gc2, gs1, gs2 = compass.gravity_terms(constants, legs)
    on_sine, on_cosine = -(gc1 + gc2), -(gs1 + gs2)
    return AboutFoot(
        (m11 + m12) * dq1 + (m12 + m22) * dq2,
        on_sine * sine + on_cosine * cosine,
        on_sine * cosine - on_cosine * sine,
        m11 + 2.0 * m12 + m22,
    )


def chain_about_foot(
    moments: Array, across: float, q: Array, dq: Array, even: Array, sine: float, cosine: float
) -> AboutFoot:
    """Moments about the foot of a chain of n segments, whose stance leg may be bent.

    Args:
        moments: b of `mjbiped.robots.chain.Chain`, shape (n,), N m.
        across: Moment of the stance leg's weight beside its line (`mjbiped.robots.bent_leg`), N m; 0 if straight.
        q: Angles, shape (n,), rad.
        dq: Rates, shape (n,), rad/s.
        even: M, shape (n, n), kg m².
        sine: Sine of the slope, or of its estimate.
        cosine: Cosine of it.
    """
    momentum = inertia = gravity = by_slope = 0.0
    for i in range(len(q)):
        sine_q, cosine_q = sine_cosine(q[i])
        gravity += moments[i] * (sine_q * cosine + cosine_q * sine)
        by_slope += moments[i] * (cosine_q * cosine - sine_q * sine)
        for j in range(len(q)):
            momentum += even[i, j] * dq[j]
            inertia += even[i, j]
    if across != 0.0:
        gravity -= gravity_beside(across, q[0], sine, cosine)
        by_slope -= gravity_beside(across, q[0], cosine, -sine)
    return AboutFoot(momentum, gravity, by_slope, inertia)


def identifier_rates(gain: float, memory: Memory, about: AboutFoot, ankle: float) -> tuple[float, float]:
    """Rates of the slope's estimate, rad/s, and of the predicted momentum, N m.

    Args:
        gain: gamma.
        memory: Memory of the controller.
        about: Moments about the foot, on the estimated slope.
        ankle: Ankle torque, N m.
    """
    error = about.momentum - memory[MOMENTUM]
    slope_rate = gain * about.by_slope * error / (about.inertia * about.inertia)
    return slope_rate, ankle + about.gravity + OBSERVER_GAIN * error


def update_slope(gains: Gains, memory: Memory, stance_before: float, swing_after: float) -> None:
    """Update (27) of the estimate in the memory, where it is wanted; see `felt_change`."""
    if gains.estimate_update:
        memory[SLOPE] += felt_change(gains.update_threshold, stance_before, swing_after)
