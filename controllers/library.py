"""Controller with two gaits: an economical one, and one of more clearance for some steps after uneven ground."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

from mjbiped.controllers import layout
from mjbiped.controllers.adaptive import AdaptiveController, PaperSettings
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.optimised import OptimisedGait, find_reference
from mjbiped.robots.compass import Compass
from mjbiped.utils import domains

CLEARANCE, THRESHOLD = 0.14, 0.025
"""Default clearance of the climbing gait and default threshold of the height change, in leg lengths."""


@dataclass(frozen=True)
class GaitLibrary(PaperSettings):
    r"""Settings of controllers with an economical gait, and a climbing gait for the steps after a height change.

    At touchdown both feet are on the ground, and the legs' angles tell by how much the new foothold is higher than the
    old one, along the normal of the ground under the old one:

    .. math:: \Delta = l \, (\cos q_1^- - \cos q_2^-)

    If the change of height is more than a threshold, the next steps are made with the climbing gait, which has more
    clearance; then the economical gait returns. Re-planning, additive by default, leads from one gait to the other.

    Attributes:
        climbing_clearance: Clearance of the climbing gait, m; see `mjbiped.find_reference`. None: `CLEARANCE`.
        climbing_steps: Number of steps made with the climbing gait after a height change.
        height_threshold: Least height change after which the climbing gait is used, m. None: `THRESHOLD`.
        climbing_gait: The climbing gait; unless given, the optimised reference of the economical one's speed and of
            `climbing_clearance`, with retraction unless the economical one is without.
        replanning: See `PaperSettings`, as for all attributes not named here.
    """

    robot: Compass
    gait: Gait
    replanning: str = "additive"
    climbing_clearance: Annotated[float | None, domains.CLEARANCE] = None
    climbing_steps: Annotated[int, domains.STEPS] = 5
    height_threshold: Annotated[float | None, domains.CLEARANCE] = None
    climbing_gait: Gait | None = None

    lifts_after_drop: ClassVar[bool] = False
    """Whether the climbing gait is used after a step down, too."""

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain, and find the climbing gait.

        Raises:
            InputError: A parameter is outside its domain; see `mjbiped.utils.domains`.
            GaitError: There is no such climbing gait.
        """
        super().__post_init__()
        if self.climbing_gait is None:
            gait, clearance = self.gait, self.climbing_clearance
            found = find_reference(
                gait.robot,
                speed=gait.speed,
                clearance=CLEARANCE * gait.robot.leg_length if clearance is None else clearance,
                retraction=gait.goal.retraction if isinstance(gait, OptimisedGait) else True,
            )
            object.__setattr__(self, "climbing_gait", found)
        if self.climbing_gait is not self.gait:
            replace(self, gait=self.climbing_gait or self.gait).check_imitated()

    def scalars(self) -> dict[int, float]:
        """Return the scalars among the parameters, by their indices."""
        threshold = self.height_threshold
        up = THRESHOLD * self.robot.leg_length if threshold is None else threshold
        down = -up if self.lifts_after_drop else -math.inf
        own = {layout.UP: up, layout.DOWN: down, layout.CLIMBING_STEPS: float(self.climbing_steps)}
        return {**super().scalars(), **own}

    def gaits(self) -> dict[int, Gait]:
        """Return the gaits that are imitated, by the indices of their starts."""
        return {**super().gaits(), layout.CLIMBING_GAIT: self.climbing_gait or self.gait}


@dataclass(frozen=True)
class LibraryController(GaitLibrary, AdaptiveController):
    """Walks as `AdaptiveController`, with one of two gaits: see `GaitLibrary`, also after a step down.

    The economical gait meets the first step up, so this controller climbs no higher first step than that gait.

    Attributes:
        gait: The economical gait.
        climbing_clearance: See `GaitLibrary`, as for the attributes of the climbing gait, and `AdaptiveController` for
            the others.
    """

    climbing_clearance: Annotated[float, domains.CLEARANCE] = 0.1
    height_threshold: Annotated[float, domains.CLEARANCE] = 0.005

    lifts_after_drop: ClassVar[bool] = True
    for_joints: ClassVar[Mapping[str, str]] = {}
