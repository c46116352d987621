"""The swing foot in contact with a vertical face, or, where it cannot take the robot over, with the ground.

It slides there without friction until it is lifted, leaves its stretch of ground, or comes over the face's top.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.dynamics import attempt
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.terrain.profile import height_of

SLID_INTO = 1e-3  # of the leg's length: a sliding foot that is so far below the next segment has met a riser


def end_of_contact(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float, press: int
) -> float:
    """Take the step again so that it ends when the foot no longer presses on the face, or the knee on its stop.

    `press` is the index of that in `w`. Returns the step's length.
    """
    low, high = 0.0, h
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        attempt(laws, parameters, constants, b, t, middle)
        if b.w[press] < 0.0:
            high = middle
        else:
            low = middle
    attempt(laws, parameters, constants, b, t, high)
    return high


def hit_face(laws: Laws, constants: SimulationConstants, b: Buffers) -> float:
    """The swing foot meets a vertical face: plastic and without friction; the stance foot stays.

    Returns the face's impulse, along `PUSHED_X` and `PUSHED_Z`, N s.
    """
    w = b.w
    w[at.FACE] = 1.0 if constants.x[int(w[at.LANDING])] == w[at.FACE_X] else -1.0
    w[at.PUSHED_X], w[at.PUSHED_Z] = -w[at.FACE], 0.0
    w[at.FACE_IMPACTS] = 1.0
    return float(laws.hit_face(constants, b))


def end_at_edge(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float) -> float:
    """Take the step again so that it ends just beyond the segment that the foot slides on; returns its length."""
    low, high = 0.0, h
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        attempt(laws, parameters, constants, b, t, middle)
        if on_its_segment(laws, constants, b, b.out):
            low = middle
        else:
            high = middle
    attempt(laws, parameters, constants, b, t, high)
    return high


def on_its_segment(laws: Laws, constants: SimulationConstants, b: Buffers, state: Any) -> bool:
    """Whether a foot that slides on the ground is, in a state, still on the segment where it came down."""
    segment, (x, _) = int(b.w[at.GROUND_SEGMENT]), laws.swing_foot(constants, b, laws.pose(b, state))
    begun = segment == 0 or constants.x[segment] <= x
    return bool(begun and (segment + 1 == len(constants.x) or x <= constants.x[segment + 1]))


def slides_on(laws: Laws, constants: SimulationConstants, b: Buffers) -> float:
    """A sliding foot comes to another segment: off a step down, on along a change of slope, or, NaN, into a riser.

    Returns the ground's impulse on it, N s.
    """
    w = b.w
    x, z = laws.swing_foot(constants, b, laws.pose(b, b.y))
    segment = int(w[at.GROUND_SEGMENT])
    segment += 1 if x > constants.x[segment] else -1
    w[at.GROUND], w[at.GROUND_SEGMENT], w[at.LANDING] = 0.0, -1.0, segment
    above = z - height_of(constants, segment, x)
    if above > 0.0:
        return 0.0
    return float(laws.stub(constants, b)) if above > -SLID_INTO * constants.length else math.nan
