"""Settings of the MuJoCo engine."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from mjbiped.errors import InputError, shown
from mjbiped.robots.robot import Robot
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
        lands: Whether a physics step ends at each touchdown; otherwise all physics steps have the length `timestep`,
            which should be at most 0.1 ms.
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


SERVO_STIFFNESS = 30.0
"""In weights times leg lengths per rad: 0.3 of those, twice what stairs of 4 cm ask for, bend the knee by 10 mrad."""

SERVO_PACE = 0.75
"""Greatest product of timestep and natural frequency: critically damped, an explicit step is stable to 0.83."""


def servo_of(robot: Robot) -> tuple[float, float, float]:
    """Stiffness (N m/rad), damping (N m s/rad) and natural frequency (rad/s) of the servo that holds a stance knee.

    A spring and a damper about the flexion of its landing hold the knee in place of its lock: the motor's own loop,
    which acts at every physics step whatever the controller's period is. The frequency, that of a foot in the air, is
    its highest, and there it is critically damped. A foot that slides or hops leaves the servo little more than the
    shank to move: more damping would then be unstable.
    """
    chain, between = robot.chains[4], np.array([1.0, -1.0, 0.0, 0.0])
    first = chain.moments / robot.gravity  # of mass about the foot, which is free to go along: the legs hang straight
    weights = chain.weights - np.outer(first, first) / chain.mass
    inertia = 1.0 / float(between @ np.linalg.solve(weights, between))
    stiffness = SERVO_STIFFNESS * robot.weight * robot.leg_length
    return stiffness, 2.0 * math.sqrt(stiffness * inertia), math.sqrt(stiffness / inertia)
