"""Estimates of the ground: slope by the adaptive law (17) within a step, slope (27) and foothold at a touchdown.

At a touchdown, the angles of the legs give the height of the new foothold and the flexion of the stance leg. After a
touchdown with a bent knee the stance leg stays bent. It is then one body, whose angle is that of the line from its foot
to the hip; `mjbiped.dynamics.modes` has the equations.
"""

from __future__ import annotations

import math

from mjbiped.control.controller import Memory, Numbers
from mjbiped.controllers import layout
from mjbiped.controllers.dynamics import solve
from mjbiped.controllers.room import BENT, BENT_FREE, BENT_STIFF, CLIMBING, COS, COSINE, ERROR, LEAN, LOCKED, SIN, SINE
from mjbiped.dynamics.modes import bent_leg


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
    if beside != 0.0:  # the weight of a bent stance leg
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
    r"""Return the change of the slope estimate by (27), rad.

    .. math:: \hat\varphi^+ = \hat\varphi^- + q_1^- - q_2^+ \quad \text{if } |q_1^- - q_2^+| > \epsilon

    Args:
        parameters: Parameters of the law; they may switch (27) off.
        stance_before: q1 just before the touchdown, rad; of a bent leg the angle of its thigh.
        swing_after: q2 just after it, rad.
    """
    change = slope_change(stance_before, swing_after)
    felt = parameters[layout.ESTIMATE_UPDATE] != 0.0 and abs(change) > parameters[layout.UPDATE_THRESHOLD]
    return change if felt else 0.0


def update_estimate(parameters: Numbers, memory: Memory, stance_before: float, swing_after: float) -> None:
    """Update the estimates in the memory by `felt_change`, onto the unit circle."""
    change = felt_change(parameters, stance_before, swing_after)
    if change != 0.0:
        slope = slope_of(memory[SIN]) + change
        memory[SIN], memory[COS] = math.sin(slope), math.cos(slope)


def slope_estimate(parameters: Numbers, memory: Numbers) -> float:
    """Return the slope estimate, rad."""
    return slope_of(memory[SIN])


def feel(parameters: Numbers, memory: Memory, before: Numbers) -> tuple[float, float]:
    """Update the memory by the posture at a touchdown: height change, climbing steps, flexion of the stance leg.

    The levers of the swing foot give the rise from the old foothold to the new one, along the normal of the old ground.
    If the rise is more than a threshold, the next steps are made with the gait for uneven ground.

    Args:
        parameters: Parameters of the law; see `mjbiped.controllers.layout`.
        memory: Memory of the controller, to be changed.
        before: Angles just before the touchdown, rad.

    Returns:
        Angle of the old stance leg, or of its thigh if it is bent, rad; and the rise to the new foothold, m.
    """
    n, rise = int(parameters[layout.SEGMENTS]), 0.0
    thigh = before[0] + memory[LEAN] - memory[BENT]
    levers = int(parameters[layout.FREE]) + n * n + n + 1
    for i in range(n):
        rise += parameters[levers + i] * math.cos(before[i])
    if memory[BENT] != 0.0:
        rise += (memory[BENT_FREE + 13] - parameters[levers]) * math.cos(before[0])
    if rise > parameters[layout.UP] or rise < parameters[layout.DOWN]:
        memory[CLIMBING] = parameters[layout.CLIMBING_STEPS]
    elif memory[CLIMBING] > 0.0:
        memory[CLIMBING] -= 1.0
    flexion = before[2] - before[1] if n > 2 and memory[LOCKED] == 0.0 else 0.0
    memory[BENT], memory[LEAN] = max(0.0, flexion), 0.0
    if memory[BENT] > 0.0:
        stand_bent(parameters, memory)
    return thigh, rise


def stand_bent(parameters: Numbers, memory: Memory) -> None:
    """Write the chains with the stance leg bent by the flexion in the memory, free and locked, behind the curves."""
    whole, free, flexion = int(parameters[layout.WHOLE]), int(parameters[layout.FREE]), memory[BENT]
    length, lean = bent_leg(-parameters[free + 14], -parameters[free + 15], flexion)
    memory[LEAN] = lean
    for index in range(16):
        memory[BENT_FREE + index] = parameters[free + index]
    knee = math.cos(flexion)
    shank_sine, shank_cosine = math.sin(lean), math.cos(lean)
    thigh_sine, thigh_cosine = math.sin(lean - flexion), math.cos(lean - flexion)
    # rows and columns of the whole chain are shank and thigh of the stance leg, then thigh and shank of the swing leg
    along = parameters[whole] + 2.0 * parameters[whole + 1] * knee + parameters[whole + 5]
    memory[BENT_FREE] = memory[BENT_STIFF] = along
    for j in range(1, 3):
        coupling = parameters[whole + j + 1] * shank_cosine + parameters[whole + 5 + j] * thigh_cosine
        memory[BENT_FREE + j] = memory[BENT_FREE + 3 * j] = coupling
    shank_moment, thigh_moment = parameters[whole + 16], parameters[whole + 17]
    moment = shank_moment * shank_cosine + thigh_moment * thigh_cosine
    beside = shank_moment * shank_sine + thigh_moment * thigh_sine
    memory[BENT_FREE + 9], memory[BENT_FREE + 12], memory[BENT_FREE + 13] = moment, beside, length
    swing = memory[BENT_FREE + 1] + memory[BENT_FREE + 2]
    memory[BENT_STIFF + 1] = memory[BENT_STIFF + 2] = swing
    stiff = int(parameters[layout.STIFF])
    memory[BENT_STIFF + 3], memory[BENT_STIFF + 5] = parameters[stiff + 3], parameters[stiff + 5]
    memory[BENT_STIFF + 4], memory[BENT_STIFF + 6] = moment, beside
