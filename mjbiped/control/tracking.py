"""What figures, videos and the analysis of Theorem 1 need of a controller beyond the contract: what it tracks."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from mjbiped.control.controller import Controller, Memory
from mjbiped.gaits.gait import Gait
from mjbiped.robots.compass import Compass


class Tracking(Controller):
    """A controller that tracks a reference, to which it may lead each step by a transition of its own.

    What it tracks stands in the figures and videos of its walks.
    """

    @abstractmethod
    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """What is tracked at time t of the step: the angles (rad) and their rates (rad/s), in the robot's order."""

    @abstractmethod
    def transition_end(self, memory: Memory) -> float:
        """Time at which the re-planned transition of the step ends, s; 0 where the step was not re-planned."""


class AdaptiveTracking(Tracking):
    """A controller that tracks a reference by the paper's law (14) and adapts its slope estimate by (17).

    The first two states of its memory are the estimates of the slope's sine and cosine. A law of your own that derives
    from this class can be given to `mjbiped.stability` and to the figures of a walk.

    Attributes:
        robot: Robot model of the law.
        gait: Gait that is imitated.
        position_gain: K1 = diag(k, k), 1/s.
        velocity_gain: K2 = diag(k, k), 1/s.
        adaptation_gain: gamma of the estimator.
        replanning_delay: zeta, the time of a re-planned transition in gait periods; None without re-planning.
    """

    robot: Compass
    gait: Gait
    position_gain: float
    velocity_gain: float
    adaptation_gain: float
    replanning_delay: float | None

    @abstractmethod
    def reference(self, memory: Memory, t: float) -> tuple[float, float, float, float, float, float]:
        """What is tracked at time t of the step: q_r (rad), its rates and accelerations, stance leg first each."""

    @abstractmethod
    def tracking_errors(
        self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]
    ) -> tuple[float, float, float, float, float, float]:
        """z1 of (5) (rad), its rate, and z2 of (9) (rad/s) at time t of the step, stance leg first each."""

    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Angles and rates of `reference`."""
        reference = self.reference(memory, t)
        return reference[:2], reference[2:4]
