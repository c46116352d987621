"""The paper's adaptive controller for the biped with knees: three joints until the knee strike, two after it.

Law (14), adaptive law (17), update (27) and re-planning are those of `mjbiped.controllers.adaptive`. What knees add:

- The reference has a branch for the bent and one for the straight knee, and the law follows the one of the knee that
  the robot has, not of the clock (reference spreading). The bent branch drives on past the stop, so that a knee that is
  late still strikes.
- After a touchdown with a bent knee the stance leg stays bent. The law takes it for what it is
  (`mjbiped.controllers.footholds`), and (27) compares thighs, which are then not where the leg's line is.
- A re-planned curve would lead a straight leg straight on. So a bump is added to the shank's curve, higher where the
  robot has felt a step at its touchdown.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from mjbiped.control.controller import Memory, Numbers
from mjbiped.control.tracking import Tracking
from mjbiped.controllers import layout
from mjbiped.controllers.adaptive import AdaptiveController
from mjbiped.controllers.memory import KNEES_SIZE
from mjbiped.controllers.settings import PaperSettings
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Gait
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains


@dataclass(frozen=True)
class KneedController(PaperSettings, Tracking):
    """Imitates a gait with knees on ground of unknown slope, as `AdaptiveController` does without knees.

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated, `mjbiped.find_kneed_gait`'s or `mjbiped.find_reference`'s.
        knee_bump: Flexion that is added to a re-planned step, rad: 64 A u³ (1 - u)³ over the transition.
        knee_bump_per_step: Increase of that flexion for each metre by which the last touchdown was higher or lower than
            the one before, rad/m.
    """

    robot: KneedBiped
    knee_bump: Annotated[float, domains.KNEE_BUMP] = 0.5
    knee_bump_per_step: Annotated[float, domains.KNEE_BUMP_PER_STEP] = 5.0

    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints
    memory_size: ClassVar[int] = KNEES_SIZE
    functions: ClassVar[tuple[Any, ...]] = AdaptiveController.functions

    def check_imitated(self) -> None:
        """Refuse a robot or a gait without knees."""
        if not isinstance(self.robot, KneedBiped) or not isinstance(self.gait, Gait) or self.gait.knee_strike is None:
            raise InputError(
                f"{type(self).__name__} needs a mjbiped.KneedBiped and a gait with knees (see mjbiped.find_kneed_gait "
                f"and mjbiped.find_reference), got {type(self.robot).__name__} and {type(self.gait).__name__}"
            )

    def scalars(self) -> dict[int, float]:
        """Return the scalars among the parameters, by their indices."""
        bump = {layout.KNEE_BUMP: self.knee_bump, layout.KNEE_BUMP_PER_STEP: self.knee_bump_per_step}
        return {**super().scalars(), **bump}

    def chains(self) -> dict[int, Numbers]:
        """Return the robot model's chains, free, locked and whole, by the indices of their starts."""
        places = {layout.FREE: 3, layout.STIFF: 2, layout.WHOLE: 4}
        return {place: layout.chain_block(*self.robot.chains[n][:3]) for place, n in places.items()}

    def reference(self, memory: Memory, t: float) -> tuple[tuple[float, float, float], ...]:
        """Tracked angle, rate and acceleration of stance leg, swing thigh and swing shank at time t of the step."""
        return tuple(zip(*self.reference_of(memory, t), strict=True))
