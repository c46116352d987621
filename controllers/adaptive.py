"""The paper's adaptive controller: tracking, slope estimator and re-planning, for straight legs and knees.

Law (14), adaptive law (17), update (27) and re-planning are those of every chain of segments. What knees add:

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

from mjbiped.control.controller import Memory, Numbers, Room
from mjbiped.control.tracking import AdaptiveTracking, Tracking
from mjbiped.controllers import layout
from mjbiped.controllers.dynamics import observe, write_torques
from mjbiped.controllers.footholds import feel
from mjbiped.controllers.layout import ADAPTATION_GAIN
from mjbiped.controllers.replanning import next_discontinuity, plan
from mjbiped.controllers.room import COS, KNEES_SIZE, LOCKED, SIN
from mjbiped.controllers.settings import PaperSettings
from mjbiped.controllers.slope_estimator import estimate_rates, slope_estimate, update_estimate
from mjbiped.controllers.tracking import track
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Gait
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains


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

    with_knees: ClassVar[str | None] = "mjbiped.controllers.adaptive:KneedController"
    functions: ClassVar[tuple[Any, ...]] = torque, touchdown, slope_estimate, next_discontinuity, None, knee_strike

    def reference(self, memory: Memory, t: float) -> tuple[float, float, float, float, float, float]:
        """Tracked angles q_r (rad), rates and accelerations at time t of the step, each with the stance leg first."""
        (q1, q2), (dq1, dq2), (ddq1, ddq2) = self.reference_of(memory, t)
        return q1, q2, dq1, dq2, ddq1, ddq2


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
