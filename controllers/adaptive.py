"""The paper's adaptive controller: tracking, slope estimator and re-planning, for straight legs and knees.

Law (14), adaptive law (17), update (27) and re-planning are the same for every chain of segments. Knees add:

- The reference has a branch for the bent knee and a branch for the straight knee. The law follows the branch of the
  actual knee, whatever the time (reference spreading). The bent branch goes on past the stop, so that a late knee still
  strikes.
- After a touchdown with a bent knee the stance leg stays bent. The law models the bent leg
  (`mjbiped.controllers.slope_estimator`), and (27) compares thighs, whose angle then differs from that of the leg.
- A re-planned curve would keep a straight leg straight. So a bump is added to the shank's curve, a higher one after a
  touchdown at which the robot has felt a step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np

from mjbiped.control.controller import Controller, Law, LawController, Memory, Numbers, Room
from mjbiped.control.tracking import AdaptiveTracking, Tracking, check_tracking
from mjbiped.controllers import layout, replanning
from mjbiped.controllers import room as places
from mjbiped.controllers.dynamics import observe, write_torques
from mjbiped.controllers.layout import ADAPTATION_GAIN, TRANSITION_TIME
from mjbiped.controllers.replanning import next_discontinuity, plan
from mjbiped.controllers.slope_estimator import estimate_rates, feel, slope_estimate, update_estimate
from mjbiped.controllers.tracking import track
from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains

REPLANNINGS = ("paper", "additive")
"""Values of `PaperSettings.replanning`."""


@dataclass(frozen=True)
class PaperSettings(LawController):
    """Gains and switches of the paper's law, with the checks of their domains.

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated.
        position_gain: Gain k in K1 = diag(k, k) of the tracking law (14), 1/s.
        velocity_gain: Gain k in K2 = diag(k, k) of the tracking law (14), 1/s.
        adaptation_gain: gamma_1 = gamma_2 of the slope estimator.
        replanning_delay: Time zeta of the transition back to the gait, in gait periods; None switches re-planning off.
        replanning: "paper": the curve leads from the measured state to the gait, in its stead. "additive": it leads
            from the measured state's distance from the gait to zero, and is added to the gait, so that the clearance
            of the gait's swing foot is not lost.
        estimate_update: Whether the paper's update (27) corrects the slope estimate at each touchdown.
        update_threshold: epsilon of (27), rad. The paper gives no number.
        replanning_threshold: A step is re-planned when one of its first angles (rad) or rates (rad/s) is further than
            this from the limit cycle. Above the error of a simulated impact (some 5e-3 rad/s), so that walking on
            constant ground is never re-planned. A slope change of 1 degree brings 1.3e-2 to 4.7e-2, by where between
            the feet the corner lies, and always is; one of 0.3 degrees brings 0.4e-2 to 1.4e-2, and mostly is not.
        initial_slope_estimate: Estimate at the walk's start, rad.
    """

    robot: Robot
    gait: Gait
    position_gain: Annotated[float, domains.GAIN] = 5.0
    velocity_gain: Annotated[float, domains.GAIN] = 12.0
    adaptation_gain: Annotated[float, domains.Domain(1e-9, 1e9, "s^2")] = 0.3
    replanning_delay: Annotated[float | None, domains.Domain(1e-3, 1.0, "gait periods")] = 0.8
    estimate_update: bool = True
    update_threshold: Annotated[float, domains.Domain(0.0, 1e3, "rad")] = 2e-3
    replanning_threshold: Annotated[float, domains.Domain(0.0, 1e6, "rad and rad/s")] = 1e-2
    initial_slope_estimate: Annotated[float, domains.SLOPE] = 0.0
    replanning: str = "paper"

    functions: ClassVar[Law]
    """The class's law, without parameters."""
    states: ClassVar[tuple[str, ...]] = ("sin_slope_estimate", "cos_slope_estimate")
    memory_size: ClassVar[int] = places.STRAIGHT_LEGS_SIZE

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain.

        Raises:
            InputError: One is; see `mjbiped.utils.domains`.
        """
        domains.check_fields(self)
        domains.known_name("replanning", self.replanning, REPLANNINGS)
        self.check_imitated()
        if not isinstance(self.estimate_update, bool):
            raise InputError(f"estimate_update = {shown(self.estimate_update)}: must be True or False")

    def check_imitated(self) -> None:
        """Refuse a robot or a gait that the law is not made for: other ones than a compass biped's.

        Raises:
            InputError: One is not.
        """
        check_imitation(self)

    @cached_property
    def plain_law(self) -> Law:
        """The functions of the class with the parameters of this object; see `LawController.plain_law`."""
        return self.functions._replace(parameters=self.parameters)

    @cached_property
    def parameters(self) -> list[float]:
        """The numbers of the laws, as `mjbiped.controllers.layout` lays them out."""
        parameters, delay = layout.flat(self.scalars(), self.chains()), self.replanning_delay or 0.0
        for index, gait in self.gaits().items():
            first = len(parameters)
            parameters[index] = float(first)
            parameters += [delay * gait.period, gait.slope, 0.0, 0.0, *np.asarray(gait.start).tolist()]
            for place, table in zip((layout.BENT_TABLE, layout.STRAIGHT_TABLE), gait.tables, strict=False):
                parameters[first + place] = float(len(parameters))
                parameters += table
        return parameters

    def scalars(self) -> dict[int, float]:
        """Return the scalars among the parameters, by their indices."""
        k1, k2 = self.position_gain, self.velocity_gain
        return {
            layout.SEGMENTS: len(self.robot.angles),
            layout.POSITION_GAIN: k1,
            layout.ON_ANGLE: k1 * k2 + 1.0,
            layout.ON_RATE: k1 + k2,
            layout.ADAPTATION_GAIN: self.adaptation_gain,
            layout.ADDITIVE: self.replanning == "additive",
            layout.ESTIMATE_UPDATE: self.estimate_update,
            layout.UPDATE_THRESHOLD: self.update_threshold,
            layout.REPLANNING_THRESHOLD: self.replanning_threshold,
        }

    def chains(self) -> dict[int, Numbers]:
        """Return the robot model's chains, and other blocks of parameters, by the indices of their starts."""
        chain = self.robot.chains[2]
        return {layout.FREE: layout.chain_block(*chain[:3])}

    def gaits(self) -> dict[int, Gait]:
        """Return the gaits that are imitated, by the indices of their starts."""
        return {layout.GAIT: self.gait}

    def start(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Begin with the initial estimate, and plan the transition from the first state to the limit cycle."""
        slope = self.initial_slope_estimate
        memory[places.SIN], memory[places.COS] = math.sin(slope), math.cos(slope)
        self.plan_first_step(memory, q, dq)

    def plan_first_step(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Lay the transition curves where the walk starts off the limit cycle."""
        replanning.plan(self.parameters, memory, 0.0, q, dq)

    def transition_end(self, memory: Memory) -> float:
        """Time at which the re-planned transition of the step ends, s; 0 where the step was not re-planned."""
        parameters = self.parameters
        return parameters[layout.gait_of(parameters, memory) + TRANSITION_TIME] if memory[places.REPLANNED] else 0.0

    def tracked(self, memory: Memory, t: float) -> tuple[Numbers, Numbers]:
        """Angles (rad) and rates (rad/s) that are tracked at time t of the step.

        Once the knee is locked, thigh and shank are one.
        """
        angles, rates, _ = self.reference_of(memory, t)
        return angles, rates

    def reference_of(self, memory: Memory, t: float) -> tuple[Numbers, Numbers, Numbers]:
        """Tracked angles (rad), rates and accelerations at time t of the step, each of all segments."""
        count = len(self.robot.angles)
        n, room = 2 if memory[places.LOCKED] else count, [0.0] * places.CURVES
        replanning.reference(self.parameters, memory, t, n, room)
        angles, rates, accelerations = (
            tuple(room[places.REFERENCE + places.ANGLES * kind + min(i, n - 1)] for i in range(count))
            for kind in range(3)
        )
        return angles, rates, accelerations


def check_imitation(controller: Controller) -> None:
    """Refuse a controller whose robot or gait is not a compass biped's, or whose law needs a passive gait.

    Args:
        controller: The controller.

    Raises:
        InputError: Its robot or gait is of another kind.
    """
    robot, gait = controller.robot, controller.gait
    if not isinstance(robot, Compass) or not isinstance(gait, Gait) or not isinstance(gait.robot, Compass):
        of = f" of a {type(gait.robot).__name__}" if isinstance(gait, Gait) else ""
        raise InputError(
            f"{type(controller).__name__} needs a mjbiped.Compass and a mjbiped.Gait of one (see "
            "mjbiped.find_passive_gait; in space controllers.SpatialController and mjbiped.find_gait_in_space), got "
            f"{type(robot).__name__} and {type(gait).__name__}{of}"
        )
    if not isinstance(controller.gait, PassiveGait):
        check_tracking(type(controller))


def torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    """Write the torques (14) of ankle, hip and swing knee, and the rates (17) of the estimates; see `Law.torque`."""
    joints = len(q)
    observe(joints, q, dq, out)
    n, chain, first = track(parameters, memory, t, (memory[places.SIN], memory[places.COS]), out)
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
    memory[places.LOCKED] = 1.0


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

    for_joints: ClassVar[Mapping[str, str]] = {
        "ankle_roll": "mjbiped.controllers.space:SpatialController",
        "knee": "mjbiped.controllers.adaptive:KneedController",
    }
    functions: ClassVar[Law] = Law((), torque, touchdown, slope_estimate, next_discontinuity, knee_strike=knee_strike)

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
    knee_bump: Annotated[float, domains.Domain(0.0, 3.0, "rad")] = 0.5
    knee_bump_per_step: Annotated[float, domains.Domain(0.0, 1e3, "rad/m")] = 5.0

    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints
    memory_size: ClassVar[int] = places.KNEES_SIZE
    functions: ClassVar[Law] = AdaptiveController.functions

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
        segments = {layout.FREE: 3, layout.STIFF: 2, layout.WHOLE: 4}
        return {place: layout.chain_block(*self.robot.chains[n][:3]) for place, n in segments.items()}
