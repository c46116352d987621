"""The law in space for a sole: its width bounds the torque about the heading, so that the roll cannot be tracked.

The legs are led as by `mjbiped.controllers.space`, by the same equations, into which the roll's acceleration enters as
it will be. The roll is led by the divergent component of motion (Takenaka 2009, Englsberger 2015) of the centre of mass
across the heading, xi = y + dy / omega: the centre of pressure p = (1 + k) (xi - xi_r) leads it back to the gait's xi_r
at the rate k omega, as far as the sole is wide. How the ground falls to the side is not felt in the legs; the estimate
of it grows with xi's deviation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from mjbiped.control.controller import Memory
from mjbiped.controllers.space import Sideways, SpatialController
from mjbiped.robots.space import Array, SpatialLinkage
from mjbiped.utils.domains import Domain


@dataclass(frozen=True)
class SidewaysController(SpatialController):
    """Imitates a gait in space on a sole whose width bounds the torque about the heading.

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated.
        capture_gain: k, by which the centre of pressure leads the divergent component back.
        lateral_gain: Rate of the estimate of the ground's fall to the side, by deviation of the divergent component,
            1/(m s).
    """

    capture_gain: Annotated[float, Domain(0.0, 1e3)] = 1.5
    lateral_gain: Annotated[float, Domain(0.0, 1e3, "1/(m s)")] = 1.0

    def _led_sideways(self, memory: Memory, t: float, linkage: SpatialLinkage, q: Array, dq: Array) -> Sideways:
        """Lead the divergent component back to the gait's, as far as the sole is wide."""
        away = self._away(memory, t, q, dq)
        return Sideways(self._moment(linkage, away), self.lateral_gain * away)

    @property
    def _half(self) -> float:
        """Half of the width on which the law leans, m."""
        return 0.5 * (self.robot.sole_width or math.inf)

    def _moment(self, linkage: SpatialLinkage, away: float) -> float:
        """Torque about the heading, N m, that leads a deviation of the divergent component, m, back."""
        pressure = min(max((1.0 + self.capture_gain) * away, -self._half), self._half)
        return float(linkage.gravity * linkage.masses.sum() * pressure)

    def _away(self, memory: Memory, t: float, q: Array, dq: Array) -> float:
        """How far the divergent component is from the gait's, m towards the swing side; see `_led_sideways`."""
        fallen = np.append(q[:-1], q[-1] - self.lateral_estimate(memory))
        return self.robot.divergent_component(fallen, dq) - self._imitated(memory, t)

    def _imitated(self, memory: Memory, t: float) -> float:
        """The divergent component of the gait at time t of the step, m."""
        q, dq, _ = self.imitated(memory, t)
        return self.robot.divergent_component(q, dq)
