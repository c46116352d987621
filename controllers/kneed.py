"""The paper's adaptive controller for the biped with knees: three joints until the knee strike, two after it.

Law (14), adaptive law (17), update (27) and re-planning are those of `controllers.adaptive`. What knees add:

- The reference has a branch for the bent and one for the straight knee, and the law follows the one of the knee that
  the robot has, not of the clock (reference spreading). The bent branch drives on past the stop, so that a knee that is
  late still strikes.
- After a touchdown with a bent knee the stance leg stays bent. The law takes it for what it is (`bent_leg`), and (27)
  compares thighs, which are then not where the leg's line is.
- A re-planned curve would lead a straight leg straight on. So a bump is added to the shank's curve, higher where the
  robot has felt a step at its touchdown.

The memory holds the estimates of the slope's sine and cosine, whether this step is re-planned and the swing knee is
locked, the bump of the shank's curve (rad), the flexion of the locked stance knee (rad), and the curves' points.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple, TypeAlias

import numpy as np

from controllers.replanning import POINTS, begin_step, discontinuity_after, lay, legs_at, transition, transition_at
from controllers.settings import COS, REPLANNED, SIN, Gains, PaperSettings
from controllers.slope_estimator import estimate_rates_of_chain, slope_estimate_law, update_estimate
from controllers.tracking import angle_errors, commanded, feedback_gains
from mjbiped.control.controller import Law, Memory
from mjbiped.control.tracking import Tracking
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Branched
from mjbiped.gaits.reference import Table, reference_at, table_of
from mjbiped.robots.bent_leg import ACROSS, FLEXION, LEAN, gravity_beside, stand, straight_leg
from mjbiped.robots.chain import Array, accelerate, inverse_dynamics, solve, weighted
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains

# indices in the memory
LOCKED, _BUMP, BENT, CURVES = REPLANNED + 1, REPLANNED + 2, REPLANNED + 3, REPLANNED + 4

ANGLES = 3

Angle: TypeAlias = tuple[float, float, float]
"""Of one angle: where it is to be (rad), its rate and its acceleration."""


class Segments(NamedTuple):
    """The robot model as a chain of n segments, and room to compute in, which holds nothing between two calls.

    Attributes:
        weights: A of `mjbiped.robots.chain.Chain`, shape (n, n), kg m².
        moments: b of it, shape (n,), N m.
        q: Room for angles, rad, shape (n,).
        dq: Room for their rates, rad/s.
        motion: Room for accelerations, rad/s².
        forces: Room for generalised forces, N m.
        errors: Room for z2, rad/s.
        even: Room for the mass matrix, shape (n, n); see `mjbiped.robots.chain.weighted`.
        odd: Room for its sines, shape (n, n).
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
        free: The chain of three segments while the swing knee is free, with the stance leg as it stands.
        locked: The chain of two segments once it is locked.
        reach: Levers of the swing foot of three segments, shape (3,), m.
        locked_reach: Levers of the swing foot of two segments, shape (2,), m.
        weights: A of four segments, kg m².
        moments: b of four segments, N m.
        standing: How the stance leg stands; see `mjbiped.robots.bent_leg.stand`.
        gains: Gains and switches.
        bump: Of a re-planned knee, rad.
        bump_per_step: Of a step felt at touchdown, rad/m.
        cycle: First state on the limit cycle, shape (6,).
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
    gains: Gains
    bump: float
    bump_per_step: float
    cycle: Array
    legs: Table
    shank: Table
    straight: Table


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
            standing=straight_leg(self.robot.leg_length),
            gains=self.gains,
            bump=self.knee_bump,
            bump_per_step=self.knee_bump_per_step,
            cycle=np.array(gait.start, dtype=np.float64),
            legs=table_of(gait.rate, gait.bent[..., [0, 1]]),
            shank=table_of(gait.rate, gait.bent[..., [2, 2]]),
            straight=table_of(gait.rate, gait.straight),
        )

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module; see `LawController.plain_law`."""
        return Law(
            self.parameters,
            torque_law,
            touchdown_law,
            slope_estimate_law,
            next_discontinuity_law,
            knee_strike=knee_strike_law,
        )

    def plan_first_step(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Lay the transition curves where the walk starts off the limit cycle."""
        # walks in threads begin at the same time
        own = self.parameters._replace(free=_segments(self.robot, ANGLES), standing=straight_leg(self.robot.leg_length))
        plan(own, memory, 0.0, tuple(q), tuple(dq))

    def reference(self, memory: Memory, t: float) -> tuple[tuple[float, float, float], ...]:
        """What is tracked at time t of the step: of stance leg, swing thigh and swing shank each angle and derivatives.

        Once the knee is locked, thigh and shank are one.
        """
        given = self.parameters
        locked = memory[LOCKED] != 0.0
        legs = legs_at(given.gains, memory, CURVES, given.straight if locked else given.legs, t)
        return legs[::2], legs[1::2], legs[1::2] if locked else shank_at(given, memory, t)

    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Angles and rates of `reference`."""
        angles, rates, _ = zip(*self.reference(memory, t), strict=True)
        return angles, rates


def _segments(robot: KneedBiped, n: int) -> Segments:
    chain = robot.chains[n]
    return Segments(chain.weights.copy(), chain.moments.copy(), *np.zeros((5, n)), *np.zeros((2, n, n)))


def torque_law(
    parameters: Parameters, memory: Memory, t: float, *state: float
) -> tuple[float, float, float, float, float]:
    """Torque (14) of ankle, hip and swing knee, and the rates of the estimates (17), in a state q1, ..., dq3."""
    gains, locked = parameters.gains, memory[LOCKED] != 0.0
    if locked:
        segments, table = parameters.locked, parameters.straight
    else:
        segments, table = parameters.free, parameters.legs
        _aim(gains, segments, 2, shank_at(parameters, memory, t), state)
    legs = legs_at(gains, memory, CURVES, table, t)
    for leg in range(2):
        _aim(gains, segments, leg, (legs[leg], legs[2 + leg], legs[4 + leg]), state)
    _stand(parameters, memory[BENT])
    across = parameters.standing[ACROSS]
    weights, moments, q, dq, motion, forces, errors, even, odd = segments
    weighted(weights, q, q, even, odd)
    inverse_dynamics(moments, memory[SIN], memory[COS], q, dq, even, odd, motion, forces)
    if across != 0.0:
        forces[0] += gravity_beside(across, state[0], memory[SIN], memory[COS])
    solve(even, errors)
    sin_rate, cos_rate = estimate_rates_of_chain(moments, across, gains.adaptation, q, errors)
    knee = 0.0 if locked else forces[2]
    hip = forces[1] + knee
    return forces[0] + hip, hip, knee, sin_rate, cos_rate


def _stand(parameters: Parameters, flexion: float) -> None:
    """Adapt the model to a stance leg whose knee is locked at a flexion, rad."""
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


def _aim(gains: Gains, segments: Segments, index: int, wanted: Angle, state: tuple[float, ...]) -> None:
    """Note the state of one angle, its error z2, and the acceleration that (12) asks of it."""
    q, dq = state[index], state[ANGLES + index]
    on_position, on_rate = feedback_gains(gains.position, gains.velocity)
    z1, dz1, z2 = angle_errors(gains.position, wanted[0], wanted[1], q, dq)
    segments.q[index], segments.dq[index], segments.errors[index] = q, dq, z2
    segments.motion[index] = commanded(wanted[2], on_position, z1, on_rate, dz1)


def touchdown_law(parameters: Parameters, memory: Memory, *postures: float) -> None:
    """Estimate update (27) and plan of the new step (IV-B); `postures` are q1 to q3 before, then after, dq1 to dq3."""
    before, q, dq = postures[:3], postures[3:6], postures[6:]
    _stand(parameters, memory[BENT])
    standing, reach = parameters.standing, parameters.reach
    thigh = before[0] + standing[LEAN] - standing[FLEXION]  # q1 is the angle of the line from foot to hip
    felt = reach[0] * math.cos(before[0]) + reach[1] * math.cos(before[1]) + reach[2] * math.cos(before[2])
    memory[BENT] = 0.0 if memory[LOCKED] != 0.0 else max(0.0, before[2] - before[1])
    update_estimate(parameters.gains, memory, thigh, q[1])
    plan(parameters, memory, abs(felt), q, dq)


def knee_strike_law(parameters: Parameters, memory: Memory, t: float, *state: float) -> None:
    """Follow the branch of the straight knee from now on."""
    memory[LOCKED] = 1.0


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    table = parameters.straight if memory[LOCKED] else parameters.legs
    return discontinuity_after(parameters.gains, memory, table, t)


def shank_at(parameters: Parameters, memory: Memory, t: float) -> Angle:
    """What the swing shank is to do while the knee is free: the transition with its bump until it ends, then the gait.

    The bump is A 64 u³ (1 - u)³, whose rate and acceleration are zero at both ends.
    """
    gains = parameters.gains
    duration = gains.transition_time
    if memory[REPLANNED] == 0.0 or t >= duration:
        gait = reference_at(parameters.shank, t)
        return gait[0], gait[2], gait[4]
    u, rate, height = t / duration, 1.0 / duration, 64.0 * memory[_BUMP]
    v = 1.0 - u
    product, change = u * v, v - u
    bump = height * product * product * product
    speed = 3.0 * height * product * product * change * rate
    acceleration = 6.0 * height * product * (change * change - product) * rate * rate
    curve = transition_at(memory, CURVES + 2 * POINTS, duration, t)
    q, dq, ddq = curve[0] + bump, curve[1] + speed, curve[2] + acceleration
    if not gains.additive:
        return q, dq, ddq
    gait = reference_at(parameters.shank, t)
    return gait[0] + q, gait[2] + dq, gait[4] + ddq


def plan(parameters: Parameters, memory: Memory, felt: float, q: tuple[float, ...], dq: tuple[float, ...]) -> None:
    """Lay the transition curves if the step starts off the limit cycle; `felt` is the last step's height, m."""
    gains = parameters.gains
    memory[LOCKED] = 0.0
    on_its_own = begin_step(gains, memory, CURVES, parameters.cycle, q, dq)
    if memory[REPLANNED] != 0.0:
        memory[_BUMP] = parameters.bump_per_step * felt
    if not on_its_own:
        return
    memory[_BUMP] += parameters.bump
    # the curve leaves the measured state with the acceleration that the imitated passive walker would have there
    _stand(parameters, memory[BENT])
    weights, moments, angles, rates, motion, _, _, even, odd = parameters.free
    for index in range(ANGLES):
        angles[index], rates[index], motion[index] = q[index], dq[index], 0.0
    sine, cosine = math.sin(gains.imitated_slope), math.cos(gains.imitated_slope)
    motion[0] = -gravity_beside(parameters.standing[ACROSS], q[0], sine, cosine)
    accelerate(weights, moments, gains.imitated_slope, angles, rates, even, odd, motion)
    duration = gains.transition_time
    legs, shank = reference_at(parameters.legs, duration), reference_at(parameters.shank, duration)
    for leg in range(2):
        end = legs[leg], legs[2 + leg], legs[4 + leg]
        lay(memory, CURVES, leg, transition(duration, q[leg], dq[leg], motion[leg], *end))
    lay(memory, CURVES, 2, transition(duration, q[2], dq[2], motion[2], shank[0], shank[2], shank[4]))
