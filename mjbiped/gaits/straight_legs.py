"""What the steps of all robots share that begin and end on two straight legs."""

from __future__ import annotations

import numpy as np

from mjbiped.gaits.bezier import Numbers
from mjbiped.robots.robot import Robot


class StraightLegs:
    """Size of the robot, and its postures on both feet, for a `mjbiped.gaits.optimisation.StepModel`.

    Attributes:
        robot: Whose step it is.
    """

    robot: Robot

    @property
    def length(self) -> float:
        """Of a leg, m."""
        return self.robot.leg_length

    @property
    def weight(self) -> float:
        """Of the robot, N."""
        return self.robot.weight

    @property
    def gravity(self) -> float:
        """m/s²."""
        return self.robot.gravity

    def postures(self, half: Numbers) -> tuple[Numbers, Numbers]:
        """Angles after and before the impact: both feet on the ground, the legs `half` from the vertical."""
        return np.stack([-half, half], axis=-1), np.stack([half, -half], axis=-1)

    def step_length(self, half: Numbers) -> Numbers:
        """Between the feet, m."""
        return 2.0 * self.length * np.sin(half)
