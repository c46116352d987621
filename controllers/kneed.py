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
from typing import ClassVar, NamedTuple

import numpy as np

from controllers.replanning import transition, transition_at
from controllers.settings import COS, SIN, PaperSettings
from controllers.slope_estimator import estimate_rates_of_chain, slope_of, updated_estimate
from controllers.tracking import angle_errors, commanded, feedback_gains
from mjbiped.control.controller import Law, Memory
from mjbiped.errors import InputError
from mjbiped.gaits.branches import Branched
from mjbiped.gaits.reference import Table, in_arrays, reference_at, reference_discontinuity, table_of
from mjbiped.robots.bent_leg import ACROSS, FLEXION, LEAN, gravity_beside, stand
from mjbiped.robots.chain import Array, accelerate, inverse_dynamics, solve, weighted
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains

# indices in the memory
_REPLANNED, _LOCKED, _BUMP, _FLEXION, _CURVES = 2, 3, 4, 5, 6
_POINTS = 6  # of a curve

ANGLES = 3

Angle = tuple[float, float, float]
"""Of one angle: where it is to be (rad), its rate and its acceleration."""


class Segments(NamedTuple):
    """The robot model as a chain of n segments, and room to compute in, which holds nothing between two calls.

    Attributes:
        weights: See `mjbiped.robots.chain.Chain`.
        moments: The same.
        q: Room for angles, shape (n,).
        dq: For rates.
        motion: For accelerations.
        forces: For generalised forces.
        errors: For z2.
        even: Shape (n, n).
        odd: The same.
    """

    weights: Array
    moments: Array
    q: Array
    dq: Array
    motion: Array
    forces: Array
    errors: Array
    even: Array
    odd: Array


class Parameters(NamedTuple):
    """What the laws of this module take: `KneedController`'s attributes in plain numbers.

    Attributes:
        free: Of three segments, and
        locked: of two, both of the stance leg as it stands.
        reach: Levers of the swing foot, shape (3,), m.
        locked_reach: The same of two segments.
        weights: Of four segments.
        moments: The same.
        standing: How the stance leg stands; see `mjbiped.robots.bent_leg.stand`.
        position_gain: K1, 1/s.
        velocity_gain: K2, 1/s.
        adaptation_gain: gamma.
        transition_time: t_c = zeta T, s; 0 where re-planning is off.
        additive: Whether the transition is added to the gait, or leads to it in its stead.
        estimate_update: Whether (27) acts.
        update_threshold: epsilon of (27), rad.
        replanning_threshold: rad and rad/s.
        bump: Of a re-planned knee, rad.
        bump_per_step: Of a step felt at touchdown, rad/m.
        cycle: First state on the limit cycle, shape (6,).
        imitated_slope: phi_r, rad.
        legs: The bent branch's stance leg and swing thigh.
        shank: Its swing shank, twice.
        straight: The straight branch.
    """

    free: Segments
    locked: Segments
    reach: Array
    locked_reach: Array
    weights: Array
    moments: Array
    standing: Array
    position_gain: float
    velocity_gain: float
    adaptation_gain: float
    transition_time: float
    additive: bool
    estimate_update: bool
    update_threshold: float
    replanning_threshold: float
    bump: float
    bump_per_step: float
    cycle: Array
    imitated_slope: float
    legs: Table
    shank: Table
    straight: Table


@dataclass(frozen=True)
class KneedController(PaperSettings):
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
    memory_size: ClassVar[int] = _CURVES + ANGLES * _POINTS

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
        _plan(own, memory, 0.0, q[0], q[1], q[2], dq[0], dq[1], dq[2])

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
        if memory[_LOCKED]:
            stance, swing = _straight(self.parameters, memory, t)
            return stance, swing, swing
        return _bent(self.parameters, memory, t)

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


def torque_law(
    parameters: Parameters,
    memory: Memory,
    t: float,
    q1: float,
    q2: float,
    q3: float,
    dq1: float,
    dq2: float,
    dq3: float,
) -> tuple[float, float, float, float, float]:
    """Torque (14) of ankle, hip and swing knee, and the rates of the estimates (17)."""
    if memory[_LOCKED] != 0.0:
        segments, three = parameters.locked, False
        stance, thigh = _straight(parameters, memory, t)
        shank = thigh
    else:
        segments, three = parameters.free, True
        stance, thigh, shank = _bent(parameters, memory, t)
        _aim(parameters, segments, 2, shank, q3, dq3)
    _aim(parameters, segments, 0, stance, q1, dq1)
    _aim(parameters, segments, 1, thigh, q2, dq2)
    _stand(parameters, memory[_FLEXION])
    across = parameters.standing[ACROSS]
    weights, moments, q, dq, motion, forces, errors, even, odd = segments
    weighted(weights, q, q, even, odd)
    inverse_dynamics(moments, memory[SIN], memory[COS], q, dq, even, odd, motion, forces)
    if across != 0.0:
        forces[0] += gravity_beside(across, q1, memory[SIN], memory[COS])
    solve(even, errors)
    sin_rate, cos_rate = estimate_rates_of_chain(moments, across, parameters.adaptation_gain, q, errors)
    knee = forces[2] if three else 0.0
    hip = forces[1] + knee
    return forces[0] + hip, hip, knee, sin_rate, cos_rate


def _stand(parameters: Parameters, flexion: float) -> None:
    """Let the model be that of a stance leg whose knee is locked at a flexion, rad."""
    if flexion == parameters.standing[FLEXION]:
        return
    three, two = parameters.free, parameters.locked
    stand(
        parameters.standing,
        flexion,
        parameters.weights,
        parameters.moments,
        three.weights,
        three.moments,
        parameters.reach,
        two.weights,
        two.moments,
        parameters.locked_reach,
    )


def _aim(parameters: Parameters, segments: Segments, index: int, wanted: Angle, q: float, dq: float) -> None:
    """Note the state of one angle, its error z2, and the acceleration that (12) asks of it."""
    on_position, on_rate = feedback_gains(parameters.position_gain, parameters.velocity_gain)
    z1, dz1, z2 = angle_errors(parameters.position_gain, wanted[0], wanted[1], q, dq)
    segments.q[index], segments.dq[index], segments.errors[index] = q, dq, z2
    segments.motion[index] = commanded(wanted[2], on_position, z1, on_rate, dz1)


def touchdown_law(
    parameters: Parameters,
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q3_before: float,
    q1: float,
    q2: float,
    q3: float,
    dq1: float,
    dq2: float,
    dq3: float,
) -> None:
    """Estimate update (27) and plan of the new step (IV-B)."""
    _stand(parameters, memory[_FLEXION])
    standing, reach = parameters.standing, parameters.reach
    thigh = q1_before + standing[LEAN] - standing[FLEXION]  # q1 is the angle of the line from foot to hip
    felt = reach[0] * math.cos(q1_before) + reach[1] * math.cos(q2_before) + reach[2] * math.cos(q3_before)
    memory[_FLEXION] = 0.0 if memory[_LOCKED] != 0.0 else max(0.0, q3_before - q2_before)
    if parameters.estimate_update:
        memory[SIN], memory[COS] = updated_estimate(memory[SIN], memory[COS], parameters.update_threshold, thigh, q2)
    _plan(parameters, memory, abs(felt), q1, q2, q3, dq1, dq2, dq3)


def knee_strike_law(
    parameters: Parameters,
    memory: Memory,
    t: float,
    q1: float,
    q2: float,
    q3: float,
    dq1: float,
    dq2: float,
    dq3: float,
) -> None:
    """The straight branch from now on."""
    memory[_LOCKED] = 1.0


def slope_estimate_law(parameters: Parameters, memory: Memory) -> float:
    """The slope estimate, rad."""
    return slope_of(memory[SIN])


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    if memory[_REPLANNED] and t < parameters.transition_time:
        return parameters.transition_time
    return reference_discontinuity(parameters.straight if memory[_LOCKED] else parameters.legs, t)


def _bent(parameters: Parameters, memory: Memory, t: float) -> tuple[Angle, Angle, Angle]:
    """What stance leg, swing thigh and swing shank are to do while the knee is free."""
    duration = parameters.transition_time
    planned = memory[_REPLANNED] != 0.0 and t < duration
    if planned and not parameters.additive:
        return _curve(memory, 0, duration, t), _curve(memory, 1, duration, t), _bumped(memory, duration, t)
    legs, shanks = reference_at(parameters.legs, t), reference_at(parameters.shank, t)
    stance, thigh = (legs[0], legs[2], legs[4]), (legs[1], legs[3], legs[5])
    shank = (shanks[0], shanks[2], shanks[4])
    if not planned:
        return stance, thigh, shank
    return (
        _sum(stance, _curve(memory, 0, duration, t)),
        _sum(thigh, _curve(memory, 1, duration, t)),
        _sum(shank, _bumped(memory, duration, t)),
    )


def _straight(parameters: Parameters, memory: Memory, t: float) -> tuple[Angle, Angle]:
    """What stance and swing leg are to do while the knee is locked."""
    duration = parameters.transition_time
    planned = memory[_REPLANNED] != 0.0 and t < duration
    if planned and not parameters.additive:
        return _curve(memory, 0, duration, t), _curve(memory, 1, duration, t)
    legs = reference_at(parameters.straight, t)
    stance, swing = (legs[0], legs[2], legs[4]), (legs[1], legs[3], legs[5])
    if not planned:
        return stance, swing
    return _sum(stance, _curve(memory, 0, duration, t)), _sum(swing, _curve(memory, 1, duration, t))


def _sum(first: Angle, second: Angle) -> Angle:
    return first[0] + second[0], first[1] + second[1], first[2] + second[2]


def _curve(memory: Memory, index: int, duration: float, t: float) -> Angle:
    """One angle of the transition."""
    return transition_at(memory, _CURVES + _POINTS * index, duration, t)


def _bumped(memory: Memory, duration: float, t: float) -> Angle:
    """The shank's transition with the bump A 64 u³ (1 - u)³, whose rate and acceleration are zero at both ends."""
    u, rate, height = t / duration, 1.0 / duration, 64.0 * memory[_BUMP]
    v = 1.0 - u
    product, change = u * v, v - u
    bump = height * product * product * product
    speed = 3.0 * height * product * product * change * rate
    acceleration = 6.0 * height * product * (change * change - product) * rate * rate
    return _sum(_curve(memory, 2, duration, t), (bump, speed, acceleration))


def _plan(
    parameters: Parameters,
    memory: Memory,
    felt: float,
    q1: float,
    q2: float,
    q3: float,
    dq1: float,
    dq2: float,
    dq3: float,
) -> None:
    """Lay the transition curves if the step starts off the limit cycle; `felt` is the last step's height, m."""
    cycle, duration = parameters.cycle, parameters.transition_time
    off = max(abs(q1 - cycle[0]), abs(q2 - cycle[1]), abs(q3 - cycle[2]))
    off = max(off, abs(dq1 - cycle[3]), abs(dq2 - cycle[4]), abs(dq3 - cycle[5]))
    memory[_REPLANNED] = memory[_LOCKED] = 0.0
    if duration == 0.0 or off <= parameters.replanning_threshold:
        return
    memory[_REPLANNED] = 1.0
    memory[_BUMP] = parameters.bump_per_step * felt
    if parameters.additive:
        _lay(memory, 0, transition(duration, q1 - cycle[0], dq1 - cycle[3], 0.0, 0.0, 0.0, 0.0))
        _lay(memory, 1, transition(duration, q2 - cycle[1], dq2 - cycle[4], 0.0, 0.0, 0.0, 0.0))
        _lay(memory, 2, transition(duration, q3 - cycle[2], dq3 - cycle[5], 0.0, 0.0, 0.0, 0.0))
        return
    memory[_BUMP] += parameters.bump
    # the curve leaves the measured state with the acceleration that the imitated passive walker would have there
    _stand(parameters, memory[_FLEXION])
    weights, moments, q, dq, motion, _, _, even, odd = parameters.free
    q[0], q[1], q[2], dq[0], dq[1], dq[2] = q1, q2, q3, dq1, dq2, dq3
    sine, cosine = math.sin(parameters.imitated_slope), math.cos(parameters.imitated_slope)
    motion[0], motion[1], motion[2] = -gravity_beside(parameters.standing[ACROSS], q1, sine, cosine), 0.0, 0.0
    accelerate(weights, moments, parameters.imitated_slope, q, dq, even, odd, motion)
    legs, shank = reference_at(parameters.legs, duration), reference_at(parameters.shank, duration)
    _lay(memory, 0, transition(duration, q1, dq1, motion[0], legs[0], legs[2], legs[4]))
    _lay(memory, 1, transition(duration, q2, dq2, motion[1], legs[1], legs[3], legs[5]))
    _lay(memory, 2, transition(duration, q3, dq3, motion[2], shank[0], shank[2], shank[4]))


def _lay(memory: Memory, index: int, points: tuple[float, float, float, float, float, float]) -> None:
    for point in range(_POINTS):
        memory[_CURVES + _POINTS * index + point] = points[point]
