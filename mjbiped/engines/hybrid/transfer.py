"""What every support transfer does, whatever robot walks: the new stance foot stands on its ground, a step begins."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.state import SimulationConstants
from mjbiped.terrain.profile import height_of


def stand_on(constants: SimulationConstants, w: Any, segment: int, foot_x: float) -> None:
    """The robot stands on its other foot, at x (m) on a segment of the terrain; the step's time begins."""
    slope = constants.angle[segment]
    w[at.CLOCK], w[at.AFTER], w[at.BEFORE] = w[at.TIME], 0.0, math.inf
    w[at.STANCE] = 1.0 - w[at.STANCE]
    w[at.SLOPE], w[at.SINE], w[at.COSINE] = slope, math.sin(slope), math.cos(slope)
    w[at.FOOT_X], w[at.FOOT_Z] = foot_x, height_of(constants, segment, foot_x)


def begin_step(constants: SimulationConstants, w: Any) -> None:
    """Forget what is told of one step alone."""
    w[at.CONTACT_ENABLED] = constants.contact
    w[at.FACE] = w[at.GROUND] = w[at.FRICTION] = w[at.FACE_IMPACTS] = w[at.STUBS] = w[at.FLEXION] = 0.0
    w[at.GROUND_SEGMENT] = -1.0
    w[at.FACE_X], w[at.NORMAL_FORCE], w[at.STRIKE_TIME] = math.nan, math.inf, math.nan
