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
from typing import Annotated, ClassVar, NamedTuple, TypeAlias

import numpy as np

from mjbiped.control.controller import Law, Memory
from mjbiped.control.tracking import Tracking
from mjbiped.controllers.replanning import (
    POINTS,
    begin_step,
    discontinuity_after,
    lay,
    legs_at,
    transition,
    transition_at,
)
from mjbiped.controllers.settings import COS, REPLANNED, SIN, Gains, PaperSettings
from mjbiped.controllers.slope_estimator import estimate_rates_of_chain, slope_estimate_law, update_estimate
from mjbiped.controllers.tracking import angle_errors, commanded, feedback_gains
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Branched
from mjbiped.gaits.reference import Table, reference_at, table_of
from mjbiped.robots.bent_leg import ACROSS, FLEXION, LEAN, gravity_beside, stand, straight_leg
from mjbiped.robots.chain import Array, Chain, accelerate, inverse_dynamics, solve, weighted
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains

# indices in the memory
LOCKED, _BUMP, BENT, CURVES = REPLANNED + 1, REPLANNED + 2, REPLANNED + 3, REPLANNED + 4

ANGLES = 3

Angle: TypeAlias = tuple[float, float, float]
"""Reference of one angle: angle (rad), rate and acceleration."""


class Segments(NamedTuple):
    """The robot model as a chain of n segments, with arrays for intermediate results, which hold nothing between calls.

    Attributes:
        weights: A of `mjbiped.robots.chain.Chain`, shape (n, n), kg m².
        moments: b of it, shape (n,), N m.
        reach: Levers of the swing foot, shape (n,), m.
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
    reach: Array
    q: Array
    dq: Array
    motion: Array
    forces: Array
    errors: Array
    even: Array
    odd: Array


class Parameters(NamedTuple):
    """Parameters of the laws of this module: `KneedController`'s attributes in plain numbers.

    Attributes:
        free: The chain of three segments while the swing knee is free, with the stance leg as it stands.
        locked: The chain of two segments once it is locked.
        whole: The chain of four segments.
        standing: Posture of the stance leg; see `mjbiped.robots.bent_leg.stand`.
        gains: Gains and switches.
        bump: Flexion that is added in a re-planned step, rad.
        bump_per_step: Further flexion for each metre of a step felt at touchdown, rad/m.
        cycle: First state on the limit cycle, shape (6,).
        legs: Trajectory of stance leg and swing thigh while the knee is bent.
        shank: Trajectory of the swing shank while the knee is bent, in both columns.
        straight: Trajectory of both legs once the knee is straight.
    """

    free: Segments
    locked: Segments
    whole: Chain
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
        knee_bump_per_step: Increase of that flexion for each metre by which the last touchdown was higher or lower than
            the one before, rad/m.
    """

    robot: KneedBiped
    gait: Branched
    knee_bump: Annotated[float, domains.KNEE_BUMP] = 0.5
    knee_bump_per_step: Annotated[float, domains.KNEE_BUMP_PER_STEP] = 5.0

    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints
    memory_size: ClassVar[int] = CURVES + ANGLES * POINTS

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
        gait = self.gait
        return Parameters(
            free=_segments(self.robot, 3),
            locked=_segments(self.robot, 2),
            whole=self.robot.chains[4],
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
        plan(own_room(self.parameters, self.robot), memory, 0.0, tuple(q), tuple(dq))

    def reference(self, memory: Memory, t: float) -> tuple[tuple[float, float, float], ...]:
        """Tracked angle, rate and acceleration of stance leg, swing thigh and swing shank at time t of the step.

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
    return Segments(*(each.copy() for each in chain[:3]), *np.zeros((5, n)), *np.zeros((2, n, n)))


def own_room(parameters: Parameters, robot: KneedBiped) -> Parameters:
    """The same parameters with room of their own, for walks in threads that begin at the same time."""
    return parameters._replace(
        free=_segments(robot, ANGLES), locked=_segments(robot, 2), standing=straight_leg(robot.leg_length)
    )


def torque_law(
    parameters: Parameters, memory: Memory, t: float, *state: float
) -> tuple[float, float, float, float, float]:
    """Torque (14) of ankle, hip and swing knee, and the rates of the estimates (17), in a state q1, ..., dq3."""
    sine, cosine = memory[SIN], memory[COS]
    segments = track(parameters, memory, t, sine, cosine, state)
    solve(segments.even, segments.errors)
    across, gain = parameters.standing[ACROSS], parameters.gains.adaptation
    sin_rate, cos_rate = estimate_rates_of_chain(segments.moments, across, gain, segments.q, segments.errors)
    ankle, hip, knee = joint_torques(segments.forces)
    return ankle, hip, knee, sin_rate, cos_rate


def track(
    parameters: Parameters, memory: Memory, t: float, sine: float, cosine: float, state: tuple[float, ...]
) -> Segments:
    """Write the forces of the tracking law (12), and what they come from, into the chain that moves now.

    Args:
        parameters: Of the law.
        memory: Memory of the controller.
        t: Time since the support transfer, s.
        sine: Estimate of the slope's sine.
        cosine: Estimate of its cosine.
        state: q1, ..., dq3.

    Returns:
        That chain, of two segments once the knee is locked: its state, M in `even`, the motion that is asked for, z2
        in `errors`, and the generalised forces that make the motion.
    """
    gains, locked = parameters.gains, memory[LOCKED] != 0.0
    if locked:
        segments, table = parameters.locked, parameters.straight
    else:
        segments, table = parameters.free, parameters.legs
        _aim(gains, segments, 2, shank_at(parameters, memory, t), state)
    legs = legs_at(gains, memory, CURVES, table, t)
    for leg in range(2):
        _aim(gains, segments, leg, (legs[leg], legs[2 + leg], legs[4 + leg]), state)
    stand_bent(parameters, memory[BENT])
    across = parameters.standing[ACROSS]
    weights, moments, _, q, dq, motion, forces, _, even, odd = segments
    weighted(weights, q, q, even, odd)
    inverse_dynamics(moments, sine, cosine, q, dq, even, odd, motion, forces)
    if across != 0.0:
        forces[0] += gravity_beside(across, q[0], sine, cosine)
    return segments


def joint_torques(forces: Array) -> tuple[float, float, float]:
    """Torques of ankle, hip and swing knee of generalised forces on two or three segments, N m; 0 of a locked knee."""
    knee = forces[2] if len(forces) == ANGLES else 0.0
    hip = forces[1] + knee
    return forces[0] + hip, hip, knee


def stand_bent(parameters: Parameters, flexion: float) -> None:
    """Adapt the model to a stance leg whose knee is locked at a flexion, rad."""
    if flexion == parameters.standing[FLEXION]:
        return
    stand(parameters.standing, flexion, parameters.whole, parameters.free, parameters.locked)


def _aim(gains: Gains, segments: Segments, index: int, wanted: Angle, state: tuple[float, ...]) -> None:
    """Store the state of one angle, its error z2, and the acceleration that (12) asks for."""
    q, dq = state[index], state[ANGLES + index]
    on_position, on_rate = feedback_gains(gains.position, gains.velocity)
    z1, dz1, z2 = angle_errors(gains.position, wanted[0], wanted[1], q, dq)
    segments.q[index], segments.dq[index], segments.errors[index] = q, dq, z2
    segments.motion[index] = commanded(wanted[2], on_position, z1, on_rate, dz1)


def touchdown_law(parameters: Parameters, memory: Memory, *postures: float) -> None:
    """Estimate update (27) and plan of the new step (IV-B); `postures` are q1 to q3 before, then after, dq1 to dq3."""
    q, dq = postures[3:6], postures[6:]
    thigh, height = feel(parameters, memory, postures[:3])
    update_estimate(parameters.gains, memory, thigh, q[1])
    plan(parameters, memory, height, q, dq)


def feel(parameters: Parameters, memory: Memory, before: tuple[float, ...]) -> tuple[float, float]:
    """What a touchdown tells by the angles before it, rad; the memory keeps how the new stance leg is bent.

    Returns:
        The angle of the thigh of the leg that stood, rad, and how much higher or lower the new foothold is, m.
    """
    stand_bent(parameters, memory[BENT])
    standing, reach = parameters.standing, parameters.free.reach
    thigh = before[0] + standing[LEAN] - standing[FLEXION]  # q1 is the angle of the line from foot to hip
    height = reach[0] * math.cos(before[0]) + reach[1] * math.cos(before[1]) + reach[2] * math.cos(before[2])
    memory[BENT] = 0.0 if memory[LOCKED] != 0.0 else max(0.0, before[2] - before[1])
    return thigh, abs(height)


def knee_strike_law(parameters: Parameters, memory: Memory, t: float, *state: float) -> None:
    """Follow the branch of the straight knee from now on."""
    memory[LOCKED] = 1.0


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    table = parameters.straight if memory[LOCKED] else parameters.legs
    return discontinuity_after(parameters.gains, memory, table, t)


def shank_at(parameters: Parameters, memory: Memory, t: float) -> Angle:
    """Reference of the swing shank while the knee is free: the transition with its bump until it ends, then the gait.

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
    stand_bent(parameters, memory[BENT])
    weights, moments, _, angles, rates, motion, _, _, even, odd = parameters.free
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
