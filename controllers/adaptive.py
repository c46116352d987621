"""The paper's adaptive controller: tracking law, slope estimator and re-planning put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

from mjbiped.control.controller import Law, Memory
from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.controllers.replanning import POINTS, Motion, begin_step, discontinuity_after, lay, legs_at, transition
from mjbiped.controllers.settings import COS, REPLANNED, SIN, Gains, PaperSettings, check_imitation
from mjbiped.controllers.slope_estimator import estimate_rates, slope_estimate_law, update_estimate
from mjbiped.controllers.tracking import tracking_errors, tracking_torque
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.reference import Table, reference_at
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass

CURVES = REPLANNED + 1
"""Index in the memory of the control points of re-planned steps."""


class Parameters(NamedTuple):
    """Parameters of the laws of this module: `AdaptiveController`'s attributes in plain numbers.

    Attributes:
        constants: Lumped constants of the robot model.
        gains: Gains and switches.
        cycle: First state on the limit cycle.
        table: The gait's trajectory.
    """

    constants: compass.Constants
    gains: Gains
    cycle: tuple[float, ...]
    table: Table


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
    gait: Gait

    memory_size: ClassVar[int] = CURVES + 2 * POINTS
    with_knees: ClassVar[str | None] = "mjbiped.controllers.kneed:KneedController"

    def check_imitated(self) -> None:
        """Refuse robots other than a compass biped, and gaits of other robots."""
        check_imitation(self)

    @cached_property
    def parameters(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        return Parameters(self.robot.constants, self.gains, tuple(self.gait.start.tolist()), self.gait.table)

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module; see `LawController.plain_law`."""
        return Law(self.parameters, torque_law, touchdown_law, slope_estimate_law, next_discontinuity_law)

    def plan_first_step(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Lay the transition curves where the walk starts off the limit cycle."""
        plan(self.parameters_of(memory), memory, q[0], q[1], dq[0], dq[1])

    def reference(self, memory: Memory, t: float) -> Motion:
        """Tracked angles q_r (rad), rates and accelerations at time t of the step, each with the stance leg first."""
        parameters = self.parameters_of(memory)
        return legs_at(parameters.gains, memory, CURVES, parameters.table, t)

    def tracking_errors(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Motion:
        """Errors z1, its rate, and z2 of (5), (6) and (9) at time t of the step."""
        return tracking_errors(self.position_gain, self.reference(memory, t), q[0], q[1], dq[0], dq[1])


def torque_law(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float, float]:
    """Ankle and hip torque (14), and the rates of the estimates (17)."""
    constants, gains = parameters.constants, parameters.gains
    reference = legs_at(gains, memory, CURVES, parameters.table, t)
    legs = compass.legs_of(q1, q2)
    errors = tracking_errors(gains.position, reference, q1, q2, dq1, dq2)
    ankle, hip = tracking_torque(
        constants, gains.position, gains.velocity, reference, errors, legs, dq1, dq2, memory[SIN], memory[COS]
    )
    sin_rate, cos_rate = estimate_rates(constants, gains.adaptation, legs, errors[4], errors[5])
    return ankle, hip, sin_rate, cos_rate


def touchdown_law(
    parameters: Parameters, memory: Memory, before1: float, before2: float, q1: float, q2: float, dq1: float, dq2: float
) -> None:
    """Estimate update (27) and plan of the new step (IV-B)."""
    update_estimate(parameters.gains, memory, before1, q2)
    plan(parameters, memory, q1, q2, dq1, dq2)


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    return discontinuity_after(parameters.gains, memory, parameters.table, t)


def plan(parameters: Parameters, memory: Memory, q1: float, q2: float, dq1: float, dq2: float) -> None:
    """Lay the transition curves if the step starts off the limit cycle."""
    gains = parameters.gains
    if not begin_step(gains, memory, CURVES, parameters.cycle, (q1, q2), (dq1, dq2)):
        return
    # the curve leaves the measured state with the acceleration that the imitated passive walker would have there
    sine, cosine = math.sin(gains.imitated_slope), math.cos(gains.imitated_slope)
    ddq1, ddq2 = compass.acceleration(parameters.constants, q1, q2, dq1, dq2, sine, cosine, 0.0, 0.0)
    duration = gains.transition_time
    end = reference_at(parameters.table, duration)
    lay(memory, CURVES, 0, transition(duration, q1, dq1, ddq1, end[0], end[2], end[4]))
    lay(memory, CURVES, 1, transition(duration, q2, dq2, ddq2, end[1], end[3], end[5]))
