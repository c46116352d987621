"""Settings of the MuJoCo engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from mjbiped.errors import InputError, shown
from mjbiped.utils import domains
from mjbiped.utils.domains import Words

DEFAULT_TIMESTEP = 1e-3  # s
DEFAULT_CONTACT_TIMESTEP = 1e-5  # s
AUTO, FIELD, BOXES = GROUND_KINDS = ("auto", "heightfield", "boxes")
LOCKED, MOTOR = STANCE_KNEES = ("locked", "motor")
"""What holds the stance knee of a robot with knees."""
LONGEST_TIMESTEP = domains.TIMESTEP.high  # at 5 ms c_mt errs by 0.05 %, at 8 ms by 0.7 %, s


@dataclass(frozen=True)
class Options:
    """Settings of the MuJoCo engine; `mjbiped.engines.mujoco.engine.Mujoco` says more of them.

    Attributes:
        timestep: Longest physics step, s.
        contact_timestep: Physics step during an impact, s.
        control_period: Time between ticks of the controller, s; each physics step unless given.
        ground: "auto", "heightfield" or "boxes".
        lands: Whether a physics step ends at each touchdown; without, all keep the timestep (0.1 ms or less), and
            contacts alone tell.
        stance_knee: What holds the stance knee of a robot with knees: a lock, or a motor, whose torque and work are
            recorded.

    Raises:
        InputError: A value is outside its domain.
    """

    timestep: Annotated[float, domains.TIMESTEP] = DEFAULT_TIMESTEP
    contact_timestep: Annotated[float, domains.Domain(1e-6, 1.0, "s")] = DEFAULT_CONTACT_TIMESTEP
    control_period: Annotated[float | None, domains.CONTROL_PERIOD] = None
    ground: Annotated[str, Words(GROUND_KINDS)] = AUTO
    lands: bool = True
    stance_knee: Annotated[str, Words(STANCE_KNEES)] = LOCKED

    def __post_init__(self) -> None:
        """Check what does not depend on a walk."""
        domains.check_fields(self)
        if not isinstance(self.lands, bool):
            raise InputError(f"lands = {shown(self.lands)}: must be True or False")
        if self.control_period is not None:
            ratio = self.control_period / self.timestep
            if not (ratio > 0.5 and np.isclose(ratio, round(ratio), rtol=1e-6)):
                raise InputError(
                    f"control_period = {shown(self.control_period)}: must be a multiple of the timestep "
                    f"{self.timestep!r} s"
                )
