"""The paper's adaptive controller: tracking law, slope estimator and re-planning put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import mjbiped.compass as compass
from controllers.base import Controller, Memory, is_number, require_positive
from controllers.replanning import transition, transition_at
from controllers.slope_estimator import estimate_rates, slope_of, updated_estimate
from controllers.tracking import tracking_errors, tracking_torque
from mjbiped.compass import Compass
from mjbiped.errors import InputError
from mjbiped.gait import Gait
from mjbiped.reference import reference_at

# places in the memory
_SIN, _COS, _REPLANNED, _STANCE_CURVE, _SWING_CURVE = 0, 1, 2, 3, 9


@dataclass(frozen=True)
class AdaptiveController(Controller):
    """Imitates a passive gait on ground of unknown slope.

    The torque is (14): a backstepping law that tracks the reference q_r(t) with the estimates of the slope's sine and
    cosine in its gravity term. The estimates follow the adaptive law (17) and are corrected at touchdown by (27). A
    step that starts off the limit cycle is led back to it by a Bézier curve within the time zeta T (section IV-B).

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Passive gait that is imitated.
        position_gain: K1 = diag(k, k), 1/s.
        velocity_gain: K2 = diag(k, k), 1/s.
        adaptation_gain: gamma_1 = gamma_2.
        replanning_delay: zeta in (0, 1], the transition's time in gait periods; None switches re-planning off.
        estimate_update: Whether (27) corrects the estimate at touchdown.
        update_threshold: epsilon of (27), rad. The paper gives no number.
        replanning_threshold: A step is re-planned when one of its first angles (rad) or rates (rad/s) is further than
            this from the limit cycle. Above the error of a simulated impact (some 5e-3 rad/s), so that walking on
            constant ground is never re-planned. A slope change of 1 degree brings 1.3e-2 to 4.7e-2, by where between
            the feet the corner lies, and always is; one of 0.3 degrees brings 0.4e-2 to 1.4e-2, and mostly is not.
        initial_slope_estimate: Estimate at the walk's start, rad.
    """

    robot: Compass
    gait: Gait
    position_gain: float = 5.0
    velocity_gain: float = 12.0
    adaptation_gain: float = 0.3
    replanning_delay: float | None = 0.8
    estimate_update: bool = True
    update_threshold: float = 2e-3
    replanning_threshold: float = 1e-2
    initial_slope_estimate: float = 0.0

    states: ClassVar[tuple[str, ...]] = ("sin_slope_estimate", "cos_slope_estimate")
    memory_size: ClassVar[int] = 15

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain.

        Raises:
            InputError: A gain is not positive, zeta is outside (0, 1], or the start's estimate is no slope.
        """
        require_positive(
            position_gain=self.position_gain,
            velocity_gain=self.velocity_gain,
            adaptation_gain=self.adaptation_gain,
            update_threshold=self.update_threshold,
            replanning_threshold=self.replanning_threshold,
        )
        if not isinstance(self.robot, Compass) or not isinstance(self.gait, Gait):
            raise InputError(
                "an AdaptiveController needs a mjbiped.Compass and a mjbiped.Gait (see mjbiped.find_passive_gait), "
                f"got {type(self.robot).__name__} and {type(self.gait).__name__}"
            )
        if not isinstance(self.estimate_update, bool):
            raise InputError(f"estimate_update must be True or False, got {self.estimate_update!r}")
        zeta = self.replanning_delay
        if zeta is not None and not (is_number(zeta) and 0.0 < zeta <= 1.0):
            raise InputError(f"replanning_delay (zeta) must lie in (0, 1], or be None to switch it off; got {zeta!r}")
        if not (is_number(self.initial_slope_estimate) and abs(self.initial_slope_estimate) < math.pi / 2):
            raise InputError(
                f"initial_slope_estimate must lie within (-pi/2, pi/2) rad, got {self.initial_slope_estimate!r}"
            )

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the initial estimate, and plan the way from the first state to the limit cycle."""
        memory[_SIN] = math.sin(self.initial_slope_estimate)
        memory[_COS] = math.cos(self.initial_slope_estimate)
        self._plan(memory, q, dq)

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Update the estimate (27), then plan the new step (IV-B)."""
        if self.estimate_update:
            memory[_SIN], memory[_COS] = updated_estimate(
                memory[_SIN], memory[_COS], self.update_threshold, q_before[0], q[1]
            )
        self._plan(memory, q, dq)

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Control law (14) and adaptive law (17); see `Controller.torque`."""
        q1, q2 = q
        dq1, dq2 = dq
        constants = self.robot.constants
        reference = self.reference(memory, t)
        errors = tracking_errors(self.position_gain, reference, q1, q2, dq1, dq2)
        ankle, hip = tracking_torque(
            constants,
            self.position_gain,
            self.velocity_gain,
            reference,
            errors,
            q1,
            q2,
            dq1,
            dq2,
            memory[_SIN],
            memory[_COS],
        )
        sin_rate, cos_rate = estimate_rates(constants, self.adaptation_gain, q1, q2, errors[4], errors[5])
        return ankle, hip, sin_rate, cos_rate

    def slope_estimate(self, memory: Memory) -> float:
        """Slope estimate arcsin(s), rad."""
        return slope_of(memory[_SIN])

    def reference(self, memory: Memory, t: float) -> tuple[float, float, float, float, float, float]:
        """What is tracked at time t of the step: q_r (rad), its rates and accelerations, stance leg first each."""
        if memory[_REPLANNED]:
            duration = self._transition_time
            if t < duration:
                q1, dq1, ddq1 = transition_at(memory, _STANCE_CURVE, duration, t)
                q2, dq2, ddq2 = transition_at(memory, _SWING_CURVE, duration, t)
                return q1, q2, dq1, dq2, ddq1, ddq2
        return reference_at(self.gait.table, t)

    @property
    def _transition_time(self) -> float:
        return (self.replanning_delay or 0.0) * self.gait.period

    def _plan(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Lay the transition curves if the step starts off the limit cycle."""
        cycle = self.gait.start
        off = max(abs(q[0] - cycle[0]), abs(q[1] - cycle[1]), abs(dq[0] - cycle[2]), abs(dq[1] - cycle[3]))
        memory[_REPLANNED] = 0.0
        if self.replanning_delay is None or off <= self.replanning_threshold:
            return
        memory[_REPLANNED] = 1.0
        duration = self._transition_time
        # the curve leaves the measured state with the acceleration that the imitated passive walker would have there
        slope = self.gait.slope
        ddq = compass.acceleration(
            self.robot.constants, q[0], q[1], dq[0], dq[1], math.sin(slope), math.cos(slope), 0.0, 0.0
        )
        end = reference_at(self.gait.table, duration)
        for leg, first in ((0, _STANCE_CURVE), (1, _SWING_CURVE)):
            points = transition(duration, q[leg], dq[leg], ddq[leg], end[leg], end[2 + leg], end[4 + leg])
            for index, point in enumerate(points):
                memory[first + index] = point
