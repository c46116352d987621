"""The adaptive controller with two references: an economical one, and one that climbs where the ground is uneven."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mjbiped.controllers.adaptive import AdaptiveController
from mjbiped.controllers.gait_library import GaitLibrary
from mjbiped.utils import domains


@dataclass(frozen=True)
class LibraryController(GaitLibrary, AdaptiveController):
    """Walks as `AdaptiveController`, with one of two gaits: see `GaitLibrary`. A step down counts as one up does.

    The first step up is met with the economical gait: what that one cannot climb, this controller cannot either.

    Attributes:
        gait: The economical gait.
        climbing_clearance: See `GaitLibrary`, as for the attributes of the climbing gait, and `AdaptiveController` for
            the others.
    """

    climbing_clearance: Annotated[float, domains.CLEARANCE] = 0.1
    height_threshold: Annotated[float, domains.CLEARANCE] = 0.005

    lifts_after_drop: ClassVar[bool] = True
    with_knees: ClassVar[str | None] = None
