"""What a touchdown tells by the angles of the legs: the height of the new foothold, and how the stance leg is bent.

After a touchdown with a bent knee the stance leg stays bent. It then is one body, told by the angle of the line from
its foot to the hip; `mjbiped.dynamics.modes` has the equations.
"""

from __future__ import annotations

import math

from mjbiped.control.controller import Memory, Numbers
from mjbiped.controllers.layout import CLIMBING_STEPS, DOWN, FREE, SEGMENTS, STIFF, UP, WHOLE
from mjbiped.controllers.memory import BENT, BENT_FREE, BENT_STIFF, CLIMBING, LEAN, LOCKED
from mjbiped.dynamics.modes import bent_leg


def feel(parameters: Numbers, memory: Memory, before: Numbers) -> tuple[float, float]:
    """Take up what a touchdown tells.

    By how much the new foothold is higher than the old one, along the normal of the ground under the old one, follows
    from the levers of the swing foot. Where that is more than a threshold, the next steps are made with the gait for
    uneven ground.

    Args:
        parameters: Of the law; see `mjbiped.controllers.layout`.
        memory: Of the controller, to be changed.
        before: Angles just before the touchdown, rad.

    Returns:
        Angle of the leg that stood, rad, of a bent one that of its thigh; and the rise to the new foothold, m.
    """
    n, rise = int(parameters[SEGMENTS]), 0.0
    thigh = before[0] + memory[LEAN] - memory[BENT]
    levers = int(parameters[FREE]) + n * n + n + 1
    for i in range(n):
        rise += parameters[levers + i] * math.cos(before[i])
    if memory[BENT] != 0.0:
        rise += (memory[BENT_FREE + 13] - parameters[levers]) * math.cos(before[0])
    if rise > parameters[UP] or rise < parameters[DOWN]:
        memory[CLIMBING] = parameters[CLIMBING_STEPS]
    elif memory[CLIMBING] > 0.0:
        memory[CLIMBING] -= 1.0
    flexion = before[2] - before[1] if n > 2 and memory[LOCKED] == 0.0 else 0.0
    memory[BENT], memory[LEAN] = max(0.0, flexion), 0.0
    if memory[BENT] > 0.0:
        stand_bent(parameters, memory)
    return thigh, rise


def stand_bent(parameters: Numbers, memory: Memory) -> None:
    """Write the chains with the stance leg bent by the flexion in the memory, free and locked, behind the curves."""
    whole, free, flexion = int(parameters[WHOLE]), int(parameters[FREE]), memory[BENT]
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
    stiff = int(parameters[STIFF])
    memory[BENT_STIFF + 3], memory[BENT_STIFF + 5] = parameters[stiff + 3], parameters[stiff + 5]
    memory[BENT_STIFF + 4], memory[BENT_STIFF + 6] = moment, beside
