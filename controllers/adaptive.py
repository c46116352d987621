"""The paper's adaptive controller: tracking law, slope estimator and re-planning put together.

Its laws are those of every chain of segments, with straight legs and with knees (`mjbiped.controllers.kneed`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from mjbiped.control.controller import Memory, Numbers, Room
from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.controllers.dynamics import observe, write_torques
from mjbiped.controllers.footholds import feel
from mjbiped.controllers.layout import ADAPTATION_GAIN
from mjbiped.controllers.memory import COS, LOCKED, SIN
from mjbiped.controllers.replanning import next_discontinuity, plan
from mjbiped.controllers.settings import PaperSettings
from mjbiped.controllers.slope_estimator import estimate_rates, slope_estimate, update_estimate
from mjbiped.controllers.tracking import track
from mjbiped.robots.compass import Compass


def torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    """Write the torques (14) of ankle, hip and swing knee, and the rates (17) of the estimates; see `Law.torque`."""
    joints = len(q)
    observe(joints, q, dq, out)
    n, chain, first = track(parameters, memory, t, (memory[SIN], memory[COS]), out)
    out[joints - 1] = 0.0  # of a locked knee
    write_torques(n, out, out, 0)
    out[joints], out[joints + 1] = estimate_rates(parameters[ADAPTATION_GAIN], chain, first, n, out)


def touchdown(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    """Update the estimate by (27), and plan the new step (IV-B); see `Law.touchdown`."""
    thigh, rise = feel(parameters, memory, q_before)
    update_estimate(parameters, memory, thigh, q[1])
    plan(parameters, memory, rise, q, dq)


def knee_strike(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    """Follow the branch of the straight knee from now on; see `Law.knee_strike`."""
    memory[LOCKED] = 1.0


@dataclass(frozen=True)
class AdaptiveController(PaperSettings, AdaptiveTracking):
    """Imitates a passive gait on ground of unknown slope.

    The torque is (14): a backstepping law that tracks the reference q_r(t) with the estimates of the slope's sine and
    cosine in its gravity term. The estimates follow the adaptive law (17) and are corrected at touchdown by (27). A
    step that starts off the limit cycle is led back to it by a Bézier curve within the time zeta T (section IV-B).

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated.
    """

    robot: Compass

    with_knees: ClassVar[str | None] = "mjbiped.controllers.kneed:KneedController"
    functions: ClassVar[tuple[Any, ...]] = torque, touchdown, slope_estimate, next_discontinuity, None, knee_strike

    def reference(self, memory: Memory, t: float) -> tuple[float, float, float, float, float, float]:
        """Tracked angles q_r (rad), rates and accelerations at time t of the step, each with the stance leg first."""
        (q1, q2), (dq1, dq2), (ddq1, ddq2) = self.reference_of(memory, t)
        return q1, q2, dq1, dq2, ddq1, ddq2

    def tracking_errors(
        self, memory: Memory, t: float, q: Numbers, dq: Numbers
    ) -> tuple[float, float, float, float, float, float]:
        """Errors z1, its rate, and z2 of (5), (6) and (9) at time t of the step."""
        reference = self.reference(memory, t)
        z1a, z1b, dz1a, dz1b = reference[0] - q[0], reference[1] - q[1], reference[2] - dq[0], reference[3] - dq[1]
        return z1a, z1b, dz1a, dz1b, dz1a + self.position_gain * z1a, dz1b + self.position_gain * z1b
