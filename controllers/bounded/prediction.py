"""Steps ahead, simulated by the model that a law has: on a plane of the slope that it estimates."""

from __future__ import annotations

import math
from typing import NamedTuple

from mjbiped.control.controller import Memory
from mjbiped.controllers import adaptive
from mjbiped.controllers.bounded import bounded_ankle, recovery
from mjbiped.controllers.bounded.recovery import RECOVERING, Ankle
from mjbiped.controllers.bounded.stance import SUPPORT, Driven, set_support
from mjbiped.robots import compass
from mjbiped.rules.scuffing import swing_foot_collides


class Limits(NamedTuple):
    """How a simulation is made, and what makes it fail.

    Attributes:
        step: Length of an integration step, s.
        longest: Greatest duration of a gait step, s.
        greatest: Greatest angle of the stance leg, rad.
        least_force: Least normal force, N.
        friction: Greatest friction that may be used.
        length: Leg length, m.
        reach: Of the scuffing rule, m.
        clear: Distance ahead of the stance foot at which the swing foot has to be above the ground, m.
    """

    step: float
    longest: float
    greatest: float
    least_force: float
    friction: float
    length: float
    reach: float
    clear: float


class Parameters(NamedTuple):
    """Parameters of predictions.

    Attributes:
        bounded: Those of the tracking law.
        ankle: The ankle in recovery steps.
        limits: How simulations are made.
    """

    bounded: bounded_ankle.Parameters
    ankle: Ankle
    limits: Limits


class State(NamedTuple):
    """State after a support transfer.

    Attributes:
        q1: Angle of the stance leg, rad.
        q2: Angle of the swing leg, rad.
        dq1: Rate of the stance leg, rad/s.
        dq2: Rate of the swing leg, rad/s.
    """

    q1: float
    q2: float
    dq1: float
    dq2: float


def motion(parameters: Parameters, memory: Memory, t: float, state: State) -> Driven:
    """Torques and accelerations of the step that the memory plans."""
    q1, q2, dq1, dq2 = state
    if memory[RECOVERING] != 0.0:
        return recovery.motion(parameters.bounded.model, parameters.ankle, memory, t, q1, q2, dq1, dq2)
    return bounded_ankle.motion(parameters.bounded, memory, t, q1, q2, dq1, dq2)


def step_ahead(parameters: Parameters, memory: Memory, state: State, rise: float) -> tuple[float, State]:
    """Simulate the step that the memory plans, by the midpoint rule.

    Args:
        parameters: Of predictions.
        memory: Plans the step; only read.
        state: With which the step begins.
        rise: Height of the next foothold over the plane, m.

    Returns:
        Absolute work of both joints, J, infinite where the step fails; and the state after it.
    """
    limits = parameters.limits
    h, t, work = limits.step, 0.0, 0.0
    collides, height = False, 0.0
    while t < limits.longest:
        first = motion(parameters, memory, t, state)
        half = _moved(state, 0.5 * h, state.dq1, state.dq2, first)
        middle = motion(parameters, memory, t + 0.5 * h, half)
        if not (_bears(limits, first) and _bears(limits, middle)):
            return math.inf, state
        work += h * (abs(middle.ankle * half.dq1) + abs(middle.hip * (half.dq2 - half.dq1)))
        after = _moved(state, h, half.dq1, half.dq2, middle)
        t += h
        ahead, above = compass.swing_foot(limits.length, compass.legs_of(after.q1, after.q2))
        above -= rise
        if collides and above <= 0.0:
            share = height / (height - above)
            return work, _transferred(parameters.bounded.model.constants, state, after, share)
        if not abs(after.q1) < limits.greatest or (above <= 0.0 and ahead > limits.clear):
            return math.inf, state
        collides = swing_foot_collides(limits.reach, 0.0, t, ahead, above)
        state, height = after, above
    return math.inf, state


def nominal_steps(parameters: Parameters, memory: Memory, state: State, count: int) -> tuple[int, float]:
    """Simulate steps of the tracking law, all but the first on all of the sole; the memory's plan is lost.

    Returns:
        The number of steps until one fails, `count` at most, and their work, J.
    """
    total, steps = 0.0, 0
    behind, ahead = memory[SUPPORT], memory[SUPPORT + 1]
    while steps < count:
        plan_nominal(parameters, memory, state)
        work, state = step_ahead(parameters, memory, state, 0.0)
        if work == math.inf:
            break
        set_support(memory, 0.0, 0.0)
        total += work
        steps += 1
    set_support(memory, behind, ahead)
    return steps, total


def plan_nominal(parameters: Parameters, memory: Memory, state: State) -> None:
    """Plan a step of the tracking law."""
    memory[RECOVERING] = 0.0
    adaptive.plan(parameters.bounded.tracking, memory, state.q1, state.q2, state.dq1, state.dq2)


def _bears(limits: Limits, made: Driven) -> bool:
    """Whether the ground holds the stance foot."""
    return made.normal >= limits.least_force and abs(made.along) <= limits.friction * made.normal


def _moved(state: State, h: float, dq1: float, dq2: float, made: Driven) -> State:
    """The state a time h later, with given rates and accelerations."""
    return State(state.q1 + h * dq1, state.q2 + h * dq2, state.dq1 + h * made.ddq1, state.dq2 + h * made.ddq2)


def _transferred(constants: compass.Constants, before: State, after: State, share: float) -> State:
    """The state after a support transfer at a share of the way between two states."""
    q1, q2 = before.q1 + share * (after.q1 - before.q1), before.q2 + share * (after.q2 - before.q2)
    dq1, dq2 = before.dq1 + share * (after.dq1 - before.dq1), before.dq2 + share * (after.dq2 - before.dq2)
    new1, new2 = compass.impact_rates(constants, q1, q2, dq1, dq2)
    return State(q2, q1, new1, new2)
