"""What every support transfer does, whatever robot walks: the new stance foot stands on its ground, a step begins."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.state import SimulationConstants
from mjbiped.terrain.profile import height_of

FACE_WIDTH = 1e-8  # a foot so close to the face that it struck stays on its own side of it, m


def stand_on(constants: SimulationConstants, w: Any, segment: int, foot_x: float) -> None:
    """Stand the robot on its other foot, at x (m) on a segment of the terrain; the step's time begins."""
    slope = constants.angle[segment]
    note_face(constants, w, int(w[at.FOOT_SEGMENT]), w[at.FOOT_X])
    w[at.CLOCK], w[at.AFTER], w[at.BEFORE] = w[at.TIME], 0.0, math.inf
    w[at.STANCE] = 1.0 - w[at.STANCE]
    w[at.SLOPE], w[at.SINE], w[at.COSINE] = slope, math.sin(slope), math.cos(slope)
    w[at.FOOT_X], w[at.FOOT_Z], w[at.FOOT_SEGMENT] = foot_x, height_of(constants, segment, foot_x), segment


def note_face(constants: SimulationConstants, w: Any, own: int, x: float) -> None:
    """Note the vertical face beside which the new swing foot has stood, at x (m) on the segment `own`.

    A foot at the base of a riser lies within rounding of its face, on either side of it. It stays on the side of the
    ground that it stood on until it is clearly elsewhere.
    """
    w[at.FACE_X] = math.nan
    for other in (own - 1, own + 1):
        if 0 <= other < len(constants.x):
            face = constants.x[max(own, other)]
            top = height_of(constants, other, face)
            if abs(x - face) < FACE_WIDTH and top != height_of(constants, own, face):
                w[at.FACE_X], w[at.FACE_TOP], w[at.FACE_SEGMENT] = face, top, own


def begin_step(constants: SimulationConstants, w: Any) -> None:
    """Forget what is told of one step alone."""
    w[at.CONTACT_ENABLED] = constants.contact
    w[at.FACE] = w[at.GROUND] = w[at.FRICTION] = w[at.FACE_IMPACTS] = w[at.STUBS] = w[at.FLEXION] = 0.0
    w[at.GROUND_SEGMENT] = -1.0
    w[at.PRESSURE_AHEAD] = w[at.PRESSURE_BEHIND] = -math.inf
    w[at.NORMAL_FORCE], w[at.STRIKE_TIME] = math.inf, math.nan
