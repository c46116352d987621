"""Slope estimator: adaptive law (17) within a step, estimate update (27) at touchdown."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.control.controller import Memory
from mjbiped.controllers.settings import COS, SIN, Gains
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots import compass
from mjbiped.robots.bent_leg import gravity_beside
from mjbiped.robots.chain import Array
from mjbiped.robots.model import solve_pair


def estimate_rates(
    constants: compass.Constants, adaptation_gain: float, legs: compass.Legs, z2a: float, z2b: float
) -> tuple[float, float]:
    r"""Adaptive law (17).

    .. math:: \dot{\hat s}_\varphi = \gamma z_2^T M^{-1} g_c, \quad
              \dot{\hat c}_\varphi = \gamma z_2^T M^{-1} g_s

    Args:
        constants: Lumped constants of the controller's robot model.
        adaptation_gain: gamma, the same for both.
        legs: Sine and cosine of stance and swing angle.
        z2a: Second backstepping error of the stance leg, rad/s.
        z2b: Second backstepping error of the swing leg, rad/s.

    Returns:
        Rates of the estimates of the slope's sine and cosine, 1/s.
    """
    m11, m12, m22 = compass.mass_terms(constants, legs)
    w1, w2 = solve_pair(m11, m12, m22, z2a, z2b)
    gc1, gc2, gs1, gs2 = compass.gravity_terms(constants, legs)
    return adaptation_gain * (w1 * gc1 + w2 * gc2), adaptation_gain * (w1 * gs1 + w2 * gs2)


def estimate_rates_of_chain(
    moments: Array, across: float, adaptation_gain: float, q: Array, momentum: Array
) -> tuple[float, float]:
    """Adaptive law (17) for a chain of segments (`mjbiped.robots.chain`), whose stance leg may be bent.

    Args:
        moments: Moments b of the controller's robot model, shape (n,), N m.
        across: Moment of the stance leg's weight across its line (`mjbiped.robots.bent_leg`), N m; 0 if straight.
        adaptation_gain: gamma, the same for both.
        q: Angles, shape (n,), rad.
        momentum: M^-1 z2, shape (n,).
    """
    on_sine = on_cosine = 0.0
    for i in range(len(q)):
        sine, cosine = sine_cosine(q[i])
        on_sine -= momentum[i] * moments[i] * cosine
        on_cosine -= momentum[i] * moments[i] * sine
    if across != 0.0:
        on_sine += momentum[0] * gravity_beside(across, q[0], 1.0, 0.0)
        on_cosine += momentum[0] * gravity_beside(across, q[0], 0.0, 1.0)
    return adaptation_gain * on_sine, adaptation_gain * on_cosine


def slope_of(sin_slope: float) -> float:
    """Slope estimate arcsin(s), rad; a sine beyond ±1 is cut to it."""
    return math.asin(min(1.0, max(-1.0, sin_slope)))


def slope_change(stance_before: float, swing_after: float) -> float:
    """Change of slope at a touchdown, rad: q1 just before it minus q2 just after it.

    The leg that has just left the ground has not moved; its angle against the old ground's normal (as stance leg) and
    against the new one's (as swing leg) differ by the change of slope.
    """
    return stance_before - swing_after


def felt_change(threshold: float, stance_before: float, swing_after: float) -> float:
    """`slope_change` where it is greater than epsilon of (27), rad; smaller ones are taken for noise, and are zero."""
    change = slope_change(stance_before, swing_after)
    return change if abs(change) > threshold else 0.0


def updated_estimate(
    sin_slope: float, cos_slope: float, threshold: float, stance_before: float, swing_after: float
) -> tuple[float, float]:
    r"""Estimate update (27), by `slope_change`.

    .. math:: \hat\varphi^+ = \hat\varphi^- + q_1^- - q_2^+ \quad \text{if } |q_1^- - q_2^+| > \epsilon

    Args:
        sin_slope: Estimate of the sine at the end of the step.
        cos_slope: Estimate of the cosine.
        threshold: epsilon, rad; smaller changes are taken for noise and leave the estimate as it is.
        stance_before: q1 just before the touchdown, rad.
        swing_after: q2 just after it, rad.

    Returns:
        Estimates of sine and cosine at the next step's start; on the unit circle where updated.
    """
    change = felt_change(threshold, stance_before, swing_after)
    if change == 0.0:
        return sin_slope, cos_slope
    slope = slope_of(sin_slope) + change
    return math.sin(slope), math.cos(slope)


def update_estimate(gains: Gains, memory: Memory, stance_before: float, swing_after: float) -> None:
    """Update (27) of the estimates in the memory, where it is wanted; see `updated_estimate`."""
    if gains.estimate_update:
        memory[SIN], memory[COS] = updated_estimate(
            memory[SIN], memory[COS], gains.update_threshold, stance_before, swing_after
        )


def slope_estimate_law(parameters: Any, memory: Memory) -> float:
    """The slope estimate, rad."""
    return slope_of(memory[SIN])
