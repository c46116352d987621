"""The law in space for a narrow sole and hips that abduct: the next foot is placed where the robot is falling to.

What the sole's width does not hold of the deviation of the divergent component grows by exp(omega t). So the swing foot
is always where it would have to be if it touched the ground a little later, at a constant distance beyond the divergent
component that is predicted for then (the constant offset of Hof 2008; Englsberger 2015, Khadiv 2016). The prediction
has two parts: what comes of the deviation from the gait, and the gait's own component, which on uneven ground meets the
touchdown too early or too late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from mjbiped.control.controller import Memory
from mjbiped.controllers.bounded.sideways import SidewaysController
from mjbiped.controllers.space import Sideways
from mjbiped.robots.space import Array, SpatialLinkage
from mjbiped.utils.domains import Domain

_TIMES = np.linspace(0.0, 2.0, 1001)  # of a step, in periods of the gait, at which the gait's component is tabulated


@dataclass(frozen=True)
class PlacementController(SidewaysController):
    """Imitates a gait in space on a narrow sole, and places the feet by the abduction of the hips.

    Attributes:
        sole_share: Share of the sole's width on which the law leans; 0: it balances by the places of the feet alone.
        placement_gain: Distance by which the foot is set aside, in those by which the divergent component will be away.
        timing_share: Share of the gait's own divergent component that a touchdown before or after the gait's has less
            or more, which the foot makes up for.
        margin: Distance by which the foot is always set aside, m.
        lead: Time for which the divergent component is predicted, s.
        pace: Rate at which the abduction follows its target, 1/s.
        closest: Least distance between the feet across the heading, m.
        farthest: Greatest one, m.
        trusted: Deviation of the divergent component up to which the estimate of the ground's fall grows by it, m.
    """

    sole_share: Annotated[float, Domain(0.0, 1.0)] = 1.0
    placement_gain: Annotated[float, Domain(0.0, 1e3)] = 1.0
    timing_share: Annotated[float, Domain(0.0, 1e3)] = 1.0
    margin: Annotated[float, Domain(-1.0, 1.0, "m")] = 0.01
    lead: Annotated[float, Domain(0.0, 1.0, "s")] = 0.17
    pace: Annotated[float, Domain(1e-3, 1e3, "1/s")] = 12.0
    closest: Annotated[float, Domain(-1.0, 1.0, "m")] = 0.03
    farthest: Annotated[float, Domain(0.0, 10.0, "m")] = 0.4
    trusted: Annotated[float, Domain(0.0, 10.0, "m")] = 0.02

    def _led_sideways(self, memory: Memory, t: float, linkage: SpatialLinkage, q: Array, dq: Array) -> Sideways:
        """Lead the divergent component back as far as the sole is wide, and place the next foot by the rest."""
        robot, away = self.robot, self._away(memory, t, q, dq)
        held, growth = min(max(away, -self._half), self._half), math.exp(robot.falling * self.lead)
        coming = (away - held) * growth + held * growth**-self.capture_gain
        timing = self._imitated(memory, t + self.lead) - self._imitated(memory, self.gait.period)
        apart = robot.hip_width + self.margin + self.placement_gain * coming + self.timing_share * timing
        target = (min(max(apart, self.closest), self.farthest) - robot.hip_width) / robot.leg_length
        return Sideways(
            moment=self._moment(linkage, away),
            fall_rate=self.lateral_gain * away if abs(away) < self.trusted else 0.0,
            opening=self.pace * (self.pace * (target - q[2]) - 2.0 * dq[2]),
        )

    @property
    def _half(self) -> float:
        """Half of the share of the sole's width, m."""
        return self.sole_share * super()._half

    @cached_property
    def _of_gait(self) -> Array:
        """The gait's divergent component at `_TIMES`, m."""
        memory = [0.0] * self.memory_size
        return np.array([super(PlacementController, self)._imitated(memory, t) for t in self.gait.period * _TIMES])

    def _imitated(self, memory: Memory, t: float) -> float:
        """The divergent component of the gait at time t of the step, m."""
        return float(np.interp(t / self.gait.period, _TIMES, self._of_gait))
