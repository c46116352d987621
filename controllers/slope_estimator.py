"""Slope estimator: adaptive law (17) within a step, estimate update (27) at touchdown."""

from __future__ import annotations

import math

from mjbiped.control.controller import Memory, Numbers
from mjbiped.controllers.dynamics import solve
from mjbiped.controllers.layout import ESTIMATE_UPDATE, UPDATE_THRESHOLD
from mjbiped.controllers.room import COS, COSINE, ERROR, SIN, SINE


def estimate_rates(gain: float, chain: Numbers, first: int, n: int, room: Numbers) -> tuple[float, float]:
    r"""Return the rates of the estimates of the slope's sine and cosine by the adaptive law (17), 1/s.

    .. math:: \dot{\hat s}_\varphi = \gamma z_2^T M^{-1} g_c, \quad
              \dot{\hat c}_\varphi = \gamma z_2^T M^{-1} g_s

    Args:
        gain: gamma.
        chain: Numbers among which the chain stands; see `layout.chain_block`.
        first: Index at which it begins.
        n: Number of segments.
        room: Has the state and the errors z2.
    """
    w1, w2, w3 = solve(chain, first, n, room, ERROR)
    moments = first + n * n
    pull = w1 * chain[moments]
    on_sine, on_cosine = -pull * room[COSINE], -pull * room[SINE]
    pull = w2 * chain[moments + 1]
    on_sine, on_cosine = on_sine - pull * room[COSINE + 1], on_cosine - pull * room[SINE + 1]
    if n > 2:
        pull = w3 * chain[moments + 2]
        on_sine, on_cosine = on_sine - pull * room[COSINE + 2], on_cosine - pull * room[SINE + 2]
    beside = chain[moments + n]
    if beside != 0.0:  # of a bent stance leg's weight
        on_sine, on_cosine = on_sine + w1 * beside * room[SINE], on_cosine - w1 * beside * room[COSINE]
    return gain * on_sine, gain * on_cosine


def slope_of(sin_slope: float) -> float:
    """Return the slope estimate arcsin(s), rad; a sine beyond ±1 is cut to it."""
    return math.asin(min(1.0, max(-1.0, sin_slope)))


def slope_change(stance_before: float, swing_after: float) -> float:
    """Return the change of slope at a touchdown, rad: q1 just before it minus q2 just after it.

    The leg that has just left the ground has not moved; its angle against the old ground's normal (as stance leg) and
    against the new one's (as swing leg) differ by the change of slope.
    """
    return stance_before - swing_after


def felt_change(parameters: Numbers, stance_before: float, swing_after: float) -> float:
    r"""Return by how much (27) changes the slope estimate, rad.

    .. math:: \hat\varphi^+ = \hat\varphi^- + q_1^- - q_2^+ \quad \text{if } |q_1^- - q_2^+| > \epsilon

    Args:
        parameters: Of the law, which may be without (27).
        stance_before: q1 just before the touchdown, rad; of a bent leg the angle of its thigh.
        swing_after: q2 just after it, rad.
    """
    change = slope_change(stance_before, swing_after)
    return change if parameters[ESTIMATE_UPDATE] != 0.0 and abs(change) > parameters[UPDATE_THRESHOLD] else 0.0


def update_estimate(parameters: Numbers, memory: Memory, stance_before: float, swing_after: float) -> None:
    """Update the estimates in the memory by `felt_change`, onto the unit circle."""
    change = felt_change(parameters, stance_before, swing_after)
    if change != 0.0:
        slope = slope_of(memory[SIN]) + change
        memory[SIN], memory[COS] = math.sin(slope), math.cos(slope)


def slope_estimate(parameters: Numbers, memory: Numbers) -> float:
    """Return the slope estimate, rad."""
    return slope_of(memory[SIN])
