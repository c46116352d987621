"""The paper's tracking law on a sole: what the ankle cannot give is left to the stance leg, not to the swing leg."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar, NamedTuple

from mjbiped.control.controller import Law, Memory
from mjbiped.control.tracking import Tracking
from mjbiped.controllers import adaptive
from mjbiped.controllers.bounded.identifier import MOMENTUM, SLOPE, compass_about_foot, identifier_rates, update_slope
from mjbiped.controllers.bounded.stance import SUPPORT, Driven, Model, driven, model_of, standing
from mjbiped.controllers.replanning import legs_at
from mjbiped.controllers.settings import PaperSettings, check_imitation
from mjbiped.controllers.tracking import commanded, computed_torque, feedback_gains, tracking_errors
from mjbiped.gaits.gait import Gait
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass
from mjbiped.utils import domains


class Parameters(NamedTuple):
    """Parameters of the laws of this module.

    Attributes:
        tracking: Those of `controllers.adaptive`.
        model: What the law knows of the robot and its sole.
    """

    tracking: adaptive.Parameters
    model: Model


@dataclass(frozen=True)
class BoundedAnkleController(PaperSettings, Tracking):
    """Imitates a gait as `AdaptiveController` does, with an ankle torque that the robot's sole transmits.

    Where the tracking law (14) asks the ankle for more than the sole bears, the swing leg still follows its reference,
    and the stance leg moves as it must. The slope comes from what the angular momentum about the foot does
    (`controllers.bounded.identifier`), since tracking errors are no longer the slope's alone. Without a sole it differs
    from `AdaptiveController` in the identifier only. On feet with mass the sole is what the ground bears of it in
    this step (`Controller.support`), and the ankle's height over it counts.

    Attributes:
        robot: Robot model of the law, with the sole on which it leans; it may differ from the robot that walks.
        gait: Gait that is imitated.
        adaptation_gain: gamma of the slope identifier.
        replanning: See `AdaptiveController`, as for all attributes not named here.
        sole_share: Share of the sole on which the law leans; the rest is left to errors of its model.
    """

    robot: Compass
    gait: Gait
    replanning: str = "additive"
    sole_share: Annotated[float, domains.SOLE_SHARE] = 0.95

    states: ClassVar[tuple[str, ...]] = ("slope_estimate", "predicted_momentum")
    with_knees: ClassVar[str | None] = "mjbiped.controllers.bounded.kneed:BoundedKneedController"
    memory_size: ClassVar[int] = SUPPORT + 2
    support: ClassVar[int] = SUPPORT

    def check_imitated(self) -> None:
        """Refuse robots other than a compass biped, and gaits of other robots."""
        check_imitation(self)

    @cached_property
    def parameters(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        start = tuple(self.gait.start.tolist())
        tracking = adaptive.Parameters(self.robot.constants, self.gains, start, self.gait.table)
        return Parameters(tracking, model_of(self.robot, self.sole_share))

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module; see `LawController.plain_law`."""
        return Law(self.parameters, torque_law, touchdown_law, slope_law, next_discontinuity_law)

    def parameters_of(self, memory: Memory) -> adaptive.Parameters:
        """Return the parameters of the tracking law."""
        return self.parameters.tracking

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the initial estimate, and plan the first step."""
        memory[SLOPE] = self.initial_slope_estimate
        begin(self.robot.constants, memory, *q, *dq)
        self.plan_first_step(memory, q, dq)

    def plan_first_step(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Lay the transition curves where the walk starts off the limit cycle."""
        adaptive.plan(self.parameters_of(memory), memory, q[0], q[1], dq[0], dq[1])

    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Angles and rates that are tracked at time t of the step, with the stance leg first."""
        tracking = self.parameters_of(memory)
        reference = legs_at(tracking.gains, memory, adaptive.CURVES, tracking.table, t)
        return reference[:2], reference[2:4]


def motion(parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float) -> Driven:
    """Torques of the tracking law within the sole, and the accelerations that the law's model has under them."""
    constants, gains, _, table = parameters.tracking
    legs = compass.legs_of(q1, q2)
    sine, cosine = math.sin(memory[SLOPE]), math.cos(memory[SLOPE])
    reference = legs_at(gains, memory, adaptive.CURVES, table, t)
    errors = tracking_errors(gains.position, reference, q1, q2, dq1, dq2)
    on_position, on_rate = feedback_gains(gains.position, gains.velocity)
    asked, _ = computed_torque(constants, on_position, on_rate, reference, errors, legs, dq1, dq2, sine, cosine)
    swing = commanded(reference[5], on_position, errors[1], on_rate, errors[3])
    return driven(standing(parameters.model, memory), legs, dq1, dq2, (sine, cosine), asked, swing, 0.0)


def torque_law(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float, float]:
    """Ankle and hip torque, and the rates of the slope's estimate and of the predicted momentum."""
    made = motion(parameters, memory, t, q1, q2, dq1, dq2)
    return with_rates(parameters.tracking, memory, made, q1, q2, dq1, dq2)


def with_rates(
    tracking: adaptive.Parameters, memory: Memory, made: Driven, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float, float]:
    """Torques together with the identifier's rates."""
    sine, cosine = math.sin(memory[SLOPE]), math.cos(memory[SLOPE])
    about = compass_about_foot(tracking.constants, compass.legs_of(q1, q2), dq1, dq2, sine, cosine)
    slope_rate, momentum_rate = identifier_rates(tracking.gains.adaptation, memory, about, made.ankle)
    return made.ankle, made.hip, slope_rate, momentum_rate


def touchdown_law(
    parameters: Parameters, memory: Memory, before1: float, before2: float, q1: float, q2: float, dq1: float, dq2: float
) -> None:
    """Estimate update (27), a new prediction of the momentum, and the plan of the new step (IV-B)."""
    feel(parameters.tracking, memory, before1, q1, q2, dq1, dq2)
    adaptive.plan(parameters.tracking, memory, q1, q2, dq1, dq2)


def feel(
    tracking: adaptive.Parameters, memory: Memory, before1: float, q1: float, q2: float, dq1: float, dq2: float
) -> None:
    """Estimate update (27), and a new prediction of the momentum."""
    update_slope(tracking.gains, memory, before1, q2)
    begin(tracking.constants, memory, q1, q2, dq1, dq2)


def begin(constants: compass.Constants, memory: Memory, q1: float, q2: float, dq1: float, dq2: float) -> None:
    """Let the prediction begin with the momentum that a step begins with."""
    memory[MOMENTUM] = compass_about_foot(constants, compass.legs_of(q1, q2), dq1, dq2, 0.0, 1.0).momentum


def slope_law(parameters: object, memory: Memory) -> float:
    """The slope estimate, rad."""
    return memory[SLOPE]


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    return adaptive.next_discontinuity_law(parameters.tracking, memory, t)
