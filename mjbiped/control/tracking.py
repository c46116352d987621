"""Controllers that track a reference, which figures, videos and the analysis of Theorem 1 show."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from mjbiped.control.controller import Controller, Memory
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Gait
from mjbiped.robots.compass import Compass


class Tracking(Controller):
    """A controller that tracks a reference, after a transition in steps that start off it.

    Figures and videos of its walks show what it tracks.
    """

    @abstractmethod
    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Tracked angles (rad) and rates (rad/s) at time t of the step, in the robot's order."""

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
        position_gain: Gain k in K1 = diag(k, k) of the tracking law (14), 1/s.
        velocity_gain: Gain k in K2 = diag(k, k) of the tracking law (14), 1/s.
        adaptation_gain: gamma of the estimator.
        replanning_delay: Time zeta of the transition back to the gait, in gait periods; None switches re-planning off.
    """

    robot: Compass
    gait: Gait
    position_gain: float
    velocity_gain: float
    adaptation_gain: float
    replanning_delay: float | None

    @abstractmethod
    def reference(self, memory: Memory, t: float) -> tuple[float, float, float, float, float, float]:
        """Tracked angles q_r (rad), rates and accelerations at time t of the step, each with the stance leg first."""

    def tracking_errors(
        self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]
    ) -> tuple[float, float, float, float, float, float]:
        """z1 of (5) (rad), its rate, and z2 of (9) (rad/s) at time t of the step, each with the stance leg first."""
        reference = self.reference(memory, t)
        z1a, z1b, dz1a, dz1b = reference[0] - q[0], reference[1] - q[1], reference[2] - dq[0], reference[3] - dq[1]
        return z1a, z1b, dz1a, dz1b, dz1a + self.position_gain * z1a, dz1b + self.position_gain * z1b

    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Angles and rates of `reference`."""
        reference = self.reference(memory, t)
        return reference[:2], reference[2:4]


def check_tracking(kind: type[Controller]) -> None:
    """Refuse an optimised reference for a law that imitates passive walking itself.

    Raises:
        InputError: The class does not follow a gait's trajectory in time.
    """
    if not kind.follows:
        raise InputError(
            f"{kind.__name__} imitates how a passive walker's energy goes, and needs a passive gait (see "
            "mjbiped.find_passive_gait); an optimised reference is tracked by controllers that follow it in time, as "
            "AdaptiveController and LimitCycleController"
        )
