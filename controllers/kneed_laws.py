"""The laws of `KneedController`, for plain Python as for Numba, and what they take.

The memory holds the estimates of the slope's sine and cosine, whether this step is re-planned and the swing knee is
locked, the bump of the shank's curve (rad), the flexion of the locked stance knee (rad), and the curves' points.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from controllers.replanning import transition, transition_at
from controllers.settings import COS, SIN
from controllers.slope_estimator import estimate_rates_of_chain, slope_of, updated_estimate
from controllers.tracking import angle_errors, commanded, feedback_gains
from mjbiped.control.controller import Memory
from mjbiped.gaits.reference import Table, reference_at, reference_discontinuity
from mjbiped.robots.bent_leg import ACROSS, FLEXION, LEAN, gravity_beside, stand
from mjbiped.robots.chain import Array, accelerate, inverse_dynamics, solve, weighted

# indices in the memory
REPLANNED, LOCKED, _BUMP, BENT, CURVES = 2, 3, 4, 5, 6
POINTS = 6  # of a curve

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
    if memory[LOCKED] != 0.0:
        segments, three = parameters.locked, False
        stance, thigh = straight_branch(parameters, memory, t)
        shank = thigh
    else:
        segments, three = parameters.free, True
        stance, thigh, shank = bent_branch(parameters, memory, t)
        _aim(parameters, segments, 2, shank, q3, dq3)
    _aim(parameters, segments, 0, stance, q1, dq1)
    _aim(parameters, segments, 1, thigh, q2, dq2)
    _stand(parameters, memory[BENT])
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
    _stand(parameters, memory[BENT])
    standing, reach = parameters.standing, parameters.reach
    thigh = q1_before + standing[LEAN] - standing[FLEXION]  # q1 is the angle of the line from foot to hip
    felt = reach[0] * math.cos(q1_before) + reach[1] * math.cos(q2_before) + reach[2] * math.cos(q3_before)
    memory[BENT] = 0.0 if memory[LOCKED] != 0.0 else max(0.0, q3_before - q2_before)
    if parameters.estimate_update:
        memory[SIN], memory[COS] = updated_estimate(memory[SIN], memory[COS], parameters.update_threshold, thigh, q2)
    plan(parameters, memory, abs(felt), q1, q2, q3, dq1, dq2, dq3)


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
    memory[LOCKED] = 1.0


def slope_estimate_law(parameters: Parameters, memory: Memory) -> float:
    """The slope estimate, rad."""
    return slope_of(memory[SIN])


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    if memory[REPLANNED] and t < parameters.transition_time:
        return parameters.transition_time
    return reference_discontinuity(parameters.straight if memory[LOCKED] else parameters.legs, t)


def bent_branch(parameters: Parameters, memory: Memory, t: float) -> tuple[Angle, Angle, Angle]:
    """What stance leg, swing thigh and swing shank are to do while the knee is free."""
    duration = parameters.transition_time
    planned = memory[REPLANNED] != 0.0 and t < duration
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


def straight_branch(parameters: Parameters, memory: Memory, t: float) -> tuple[Angle, Angle]:
    """What stance and swing leg are to do while the knee is locked."""
    duration = parameters.transition_time
    planned = memory[REPLANNED] != 0.0 and t < duration
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
    return transition_at(memory, CURVES + POINTS * index, duration, t)


def _bumped(memory: Memory, duration: float, t: float) -> Angle:
    """The shank's transition with the bump A 64 u³ (1 - u)³, whose rate and acceleration are zero at both ends."""
    u, rate, height = t / duration, 1.0 / duration, 64.0 * memory[_BUMP]
    v = 1.0 - u
    product, change = u * v, v - u
    bump = height * product * product * product
    speed = 3.0 * height * product * product * change * rate
    acceleration = 6.0 * height * product * (change * change - product) * rate * rate
    return _sum(_curve(memory, 2, duration, t), (bump, speed, acceleration))


def plan(
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
    memory[REPLANNED] = memory[LOCKED] = 0.0
    if duration == 0.0 or off <= parameters.replanning_threshold:
        return
    memory[REPLANNED] = 1.0
    memory[_BUMP] = parameters.bump_per_step * felt
    if parameters.additive:
        _lay(memory, 0, transition(duration, q1 - cycle[0], dq1 - cycle[3], 0.0, 0.0, 0.0, 0.0))
        _lay(memory, 1, transition(duration, q2 - cycle[1], dq2 - cycle[4], 0.0, 0.0, 0.0, 0.0))
        _lay(memory, 2, transition(duration, q3 - cycle[2], dq3 - cycle[5], 0.0, 0.0, 0.0, 0.0))
        return
    memory[_BUMP] += parameters.bump
    # the curve leaves the measured state with the acceleration that the imitated passive walker would have there
    _stand(parameters, memory[BENT])
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
    for point in range(POINTS):
        memory[CURVES + POINTS * index + point] = points[point]
