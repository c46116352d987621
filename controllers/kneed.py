"""The paper's adaptive controller for the biped with knees: three joints until the knee strike, two after it.

Law (14), adaptive law (17), update (27) and re-planning are those of `controllers.adaptive`. What knees add:

- The reference has a branch for the bent and one for the straight knee, and the law follows the one of the knee that
  the robot has, not of the clock (reference spreading). The bent branch drives on past the stop, so that a knee that is
  late still strikes.
- After a touchdown with a bent knee the stance leg stays bent. The law takes it for what it is (`bent_leg`), and (27)
  compares thighs, which are then not where the leg's line is.
- A re-planned curve would lead a straight leg straight on. So a bump is added to the shank's curve, higher where the
  robot has felt a step at its touchdown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from controllers.kneed_laws import (
    ANGLES,
    CURVES,
    LOCKED,
    POINTS,
    REPLANNED,
    Angle,
    Parameters,
    Segments,
    bent_branch,
    knee_strike_law,
    next_discontinuity_law,
    plan,
    slope_estimate_law,
    straight_branch,
    torque_law,
    touchdown_law,
)
from controllers.settings import COS, SIN, PaperSettings
from mjbiped.control.controller import Law, Memory
from mjbiped.control.tracking import Tracking
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Branched
from mjbiped.gaits.reference import in_arrays, table_of
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains


@dataclass(frozen=True)
class KneedController(PaperSettings, Tracking):
    """Imitates a gait with knees on ground of unknown slope, as `AdaptiveController` does without knees.

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated, `mjbiped.find_kneed_gait`'s or `mjbiped.find_reference`'s.
        knee_bump: Flexion that is added to a re-planned step, rad: 64 A u³ (1 - u)³ over the transition.
        knee_bump_per_step: What it grows by for each metre that the last touchdown was higher or lower than the ground
            before it, rad/m.
    """

    robot: KneedBiped
    gait: Branched
    knee_bump: float = 0.5
    knee_bump_per_step: float = 5.0

    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints
    memory_size: ClassVar[int] = CURVES + ANGLES * POINTS

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain.

        Raises:
            InputError: One is; see `mjbiped.utils.domains`.
        """
        super().__post_init__()
        domains.check_fields(self, knee_bump=domains.KNEE_BUMP, knee_bump_per_step=domains.KNEE_BUMP_PER_STEP)

    def check_imitated(self) -> None:
        """Refuse a robot or a gait without knees."""
        if not isinstance(self.robot, KneedBiped) or not isinstance(self.gait, Branched):
            raise InputError(
                f"{type(self).__name__} needs a mjbiped.KneedBiped and a gait with knees (see mjbiped.find_kneed_gait "
                f"and mjbiped.find_reference), got {type(self.robot).__name__} and {type(self.gait).__name__}"
            )

    @cached_property
    def parameters(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        gait, four = self.gait, self.robot.chains[4]
        return Parameters(
            free=_segments(self.robot, 3),
            locked=_segments(self.robot, 2),
            reach=self.robot.chains[3].reach.copy(),
            locked_reach=self.robot.chains[2].reach.copy(),
            weights=four.weights,
            moments=four.moments,
            standing=np.zeros(3),
            position_gain=self.position_gain,
            velocity_gain=self.velocity_gain,
            adaptation_gain=self.adaptation_gain,
            transition_time=float((self.replanning_delay or 0.0) * gait.period),
            additive=self.replanning == "additive",
            estimate_update=self.estimate_update,
            update_threshold=self.update_threshold,
            replanning_threshold=self.replanning_threshold,
            bump=self.knee_bump,
            bump_per_step=self.knee_bump_per_step,
            cycle=np.array(gait.start, dtype=np.float64),
            imitated_slope=float(gait.slope),
            legs=table_of(gait.rate, gait.bent[..., [0, 1]]),
            shank=table_of(gait.rate, gait.bent[..., [2, 2]]),
            straight=table_of(gait.rate, gait.straight),
        )

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the initial estimate, and plan the way from the first state to the limit cycle."""
        memory[SIN] = math.sin(self.initial_slope_estimate)
        memory[COS] = math.cos(self.initial_slope_estimate)
        # walks in threads begin at the same time
        own = self.parameters._replace(free=_segments(self.robot, ANGLES), standing=np.zeros(3))
        plan(own, memory, 0.0, q[0], q[1], q[2], dq[0], dq[1], dq[2])

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Update the estimate (27), then plan the new step (IV-B)."""
        touchdown_law(self.parameters, memory, *q_before, *q, *dq)

    def on_knee_strike(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Follow the branch of the straight knee from now on."""
        knee_strike_law(self.parameters, memory, t, *q, *dq)

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Control law (14) and adaptive law (17); see `Controller.torque`."""
        return torque_law(self.parameters, memory, t, *q, *dq)

    def reference(self, memory: Memory, t: float) -> tuple[Angle, Angle, Angle]:
        """What is tracked at time t of the step: of stance leg, swing thigh and swing shank each angle and derivatives.

        Once the knee is locked, thigh and shank are one.
        """
        if memory[LOCKED]:
            stance, swing = straight_branch(self.parameters, memory, t)
            return stance, swing, swing
        return bent_branch(self.parameters, memory, t)

    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Angles and rates of `reference`."""
        angles, rates, _ = zip(*self.reference(memory, t), strict=True)
        return angles, rates

    def transition_end(self, memory: Memory) -> float:
        """Until when a re-planned transition is tracked in the step, s; 0 where the step was not re-planned."""
        return self.parameters.transition_time if memory[REPLANNED] else 0.0

    def next_discontinuity(self, memory: Memory, t: float) -> float:
        """The transition's end, then the end of the gait's trajectory; see `Controller.next_discontinuity`."""
        return next_discontinuity_law(self.parameters, memory, t)

    def law(self) -> Law:
        """The same laws for compilation; see `Controller.law`."""
        given = self.parameters
        legs, shank, straight = map(in_arrays, (given.legs, given.shank, given.straight))
        return Law(
            given._replace(legs=legs, shank=shank, straight=straight),
            torque_law,
            touchdown_law,
            slope_estimate_law,
            next_discontinuity_law,
            knee_strike=knee_strike_law,
        )


def _segments(robot: KneedBiped, n: int) -> Segments:
    chain = robot.chains[n]
    return Segments(chain.weights.copy(), chain.moments.copy(), *np.zeros((5, n)), *np.zeros((2, n, n)))
