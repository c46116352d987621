"""The paper's adaptive controller: tracking law, slope estimator and re-planning put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

from controllers.imitation import check_imitation
from controllers.replanning import transition, transition_at
from controllers.settings import COS, SIN, PaperSettings
from controllers.slope_estimator import estimate_rates, slope_of, updated_estimate
from controllers.tracking import tracking_errors, tracking_torque
from mjbiped.control.controller import Law, Memory
from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.reference import Table, in_arrays, reference_at, reference_discontinuity
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass

# indices in the memory
_REPLANNED, _STANCE_CURVE, _SWING_CURVE = 2, 3, 9

Motion = tuple[float, float, float, float, float, float]
"""q (rad), its rates and its accelerations, stance leg first in each pair."""

Curve = tuple[float, float, float, float, float, float]
"""Control points of one leg's transition, rad."""


class Parameters(NamedTuple):
    """What the laws of this module take: `AdaptiveController`'s attributes in plain numbers.

    Attributes:
        constants: Of the robot model.
        position_gain: K1, 1/s.
        velocity_gain: K2, 1/s.
        adaptation_gain: gamma.
        transition_time: t_c = zeta T, s; 0 where re-planning is off.
        additive: Whether the transition is added to the gait, or leads to it in its stead.
        estimate_update: Whether (27) acts.
        update_threshold: epsilon of (27), rad.
        replanning_threshold: rad and rad/s.
        cycle: First state on the limit cycle.
        imitated_slope: phi_r, rad.
        table: The gait's trajectory.
    """

    constants: compass.Constants
    position_gain: float
    velocity_gain: float
    adaptation_gain: float
    transition_time: float
    additive: bool
    estimate_update: bool
    update_threshold: float
    replanning_threshold: float
    cycle: tuple[float, float, float, float]
    imitated_slope: float
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

    memory_size: ClassVar[int] = 15
    with_knees: ClassVar[str | None] = "controllers.kneed:KneedController"

    def check_imitated(self) -> None:
        """Refuse a robot or a gait that is none of the compass biped's."""
        check_imitation(self)

    @cached_property
    def parameters(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        q1, q2, dq1, dq2 = self.gait.start.tolist()
        return Parameters(
            constants=self.robot.constants,
            position_gain=self.position_gain,
            velocity_gain=self.velocity_gain,
            adaptation_gain=self.adaptation_gain,
            transition_time=float((self.replanning_delay or 0.0) * self.gait.period),
            additive=self.replanning == "additive",
            estimate_update=self.estimate_update,
            update_threshold=self.update_threshold,
            replanning_threshold=self.replanning_threshold,
            cycle=(q1, q2, dq1, dq2),
            imitated_slope=float(self.gait.slope),
            table=self.gait.table,
        )

    def parameters_of(self, memory: Memory) -> Parameters:
        """The parameters that act in the step that the memory is of; here the same in all."""
        return self.parameters

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the initial estimate, and plan the way from the first state to the limit cycle."""
        memory[SIN] = math.sin(self.initial_slope_estimate)
        memory[COS] = math.cos(self.initial_slope_estimate)
        _plan(self.parameters_of(memory), memory, q[0], q[1], dq[0], dq[1])

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Update the estimate (27), then plan the new step (IV-B)."""
        touchdown_law(self.parameters, memory, q_before[0], q_before[1], q[0], q[1], dq[0], dq[1])

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Control law (14) and adaptive law (17); see `Controller.torque`."""
        return torque_law(self.parameters_of(memory), memory, t, q[0], q[1], dq[0], dq[1])

    def reference(self, memory: Memory, t: float) -> Motion:
        """What is tracked at time t of the step: q_r (rad), its rates and accelerations, stance leg first each."""
        return _reference(self.parameters_of(memory), memory, t)

    def tracking_errors(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Motion:
        """Errors z1, its rate, and z2 of (5), (6) and (9) at time t of the step."""
        return tracking_errors(self.position_gain, self.reference(memory, t), q[0], q[1], dq[0], dq[1])

    def transition_end(self, memory: Memory) -> float:
        """Until when a re-planned transition is tracked in the step, s; 0 where the step was not re-planned."""
        return self.parameters_of(memory).transition_time if memory[_REPLANNED] else 0.0

    def next_discontinuity(self, memory: Memory, t: float) -> float:
        """The transition's end, then the end of the gait's trajectory; see `Controller.next_discontinuity`."""
        return next_discontinuity_law(self.parameters_of(memory), memory, t)

    def law(self) -> Law:
        """The same laws for compilation; see `Controller.law`."""
        arrays = self.parameters._replace(table=in_arrays(self.gait.table))
        return Law(arrays, torque_law, touchdown_law, slope_estimate_law, next_discontinuity_law)


def torque_law(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float, float]:
    """Ankle and hip torque (14), and the rates of the estimates (17)."""
    constants = parameters.constants
    reference = _reference(parameters, memory, t)
    legs = compass.legs_of(q1, q2)
    errors = tracking_errors(parameters.position_gain, reference, q1, q2, dq1, dq2)
    ankle, hip = tracking_torque(
        constants,
        parameters.position_gain,
        parameters.velocity_gain,
        reference,
        errors,
        legs,
        dq1,
        dq2,
        memory[SIN],
        memory[COS],
    )
    sin_rate, cos_rate = estimate_rates(constants, parameters.adaptation_gain, legs, errors[4], errors[5])
    return ankle, hip, sin_rate, cos_rate


def touchdown_law(
    parameters: Parameters,
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> None:
    """Estimate update (27) and plan of the new step (IV-B)."""
    if parameters.estimate_update:
        memory[SIN], memory[COS] = updated_estimate(
            memory[SIN], memory[COS], parameters.update_threshold, q1_before, q2
        )
    _plan(parameters, memory, q1, q2, dq1, dq2)


def slope_estimate_law(parameters: Parameters, memory: Memory) -> float:
    """The slope estimate, rad."""
    return slope_of(memory[SIN])


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    if memory[_REPLANNED] and t < parameters.transition_time:
        return parameters.transition_time
    return reference_discontinuity(parameters.table, t)


def _reference(parameters: Parameters, memory: Memory, t: float) -> Motion:
    """The transition's curves until they end, then the gait."""
    if memory[_REPLANNED]:
        duration = parameters.transition_time
        if t < duration:
            q1, dq1, ddq1 = transition_at(memory, _STANCE_CURVE, duration, t)
            q2, dq2, ddq2 = transition_at(memory, _SWING_CURVE, duration, t)
            if parameters.additive:
                gait = reference_at(parameters.table, t)
                return gait[0] + q1, gait[1] + q2, gait[2] + dq1, gait[3] + dq2, gait[4] + ddq1, gait[5] + ddq2
            return q1, q2, dq1, dq2, ddq1, ddq2
    return reference_at(parameters.table, t)


def _plan(parameters: Parameters, memory: Memory, q1: float, q2: float, dq1: float, dq2: float) -> None:
    """Lay the transition curves if the step starts off the limit cycle."""
    cycle, duration = parameters.cycle, parameters.transition_time
    off = max(abs(q1 - cycle[0]), abs(q2 - cycle[1]), abs(dq1 - cycle[2]), abs(dq2 - cycle[3]))
    memory[_REPLANNED] = 0.0
    if duration == 0.0 or off <= parameters.replanning_threshold:
        return
    memory[_REPLANNED] = 1.0
    if parameters.additive:
        stance = transition(duration, q1 - cycle[0], dq1 - cycle[2], 0.0, 0.0, 0.0, 0.0)
        swing = transition(duration, q2 - cycle[1], dq2 - cycle[3], 0.0, 0.0, 0.0, 0.0)
        _keep(memory, stance, swing)
        return
    # the curve leaves the measured state with the acceleration that the imitated passive walker would have there
    slope = parameters.imitated_slope
    ddq1, ddq2 = compass.acceleration(
        parameters.constants, q1, q2, dq1, dq2, math.sin(slope), math.cos(slope), 0.0, 0.0
    )
    end = reference_at(parameters.table, duration)
    stance = transition(duration, q1, dq1, ddq1, end[0], end[2], end[4])
    swing = transition(duration, q2, dq2, ddq2, end[1], end[3], end[5])
    _keep(memory, stance, swing)


def _keep(memory: Memory, stance: Curve, swing: Curve) -> None:
    for index in range(6):
        memory[_STANCE_CURVE + index] = stance[index]
        memory[_SWING_CURVE + index] = swing[index]
