"""Prediction of steps by the law's own model, on a plane of the estimated slope."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from mjbiped.control.controller import Memory, Numbers
from mjbiped.controllers import replanning
from mjbiped.controllers.bounded.bounded_ankle import move
from mjbiped.controllers.bounded.identifier import SLOPE
from mjbiped.controllers.dynamics import observe
from mjbiped.controllers.layout import SUPERVISION
from mjbiped.controllers.room import ALONG, MOTION, NORMAL, RECOVERING, SUPPORT, SUPPORT_AHEAD, TORQUE
from mjbiped.robots import compass
from mjbiped.rules.scuffing import swing_foot_collides

COUNTED_SHARE, STEP, LONGEST, GREATEST, LEAST_FORCE, FRICTION, LENGTH, REACH, CLEAR = range(9)
"""Indices in the block of parameters that begins at `layout.SUPERVISION`: share of the sole that predictions count on;
length of an integration step and greatest duration of a gait step, s; greatest angle of the stance leg, rad; least
normal force, N; greatest friction that may be used; leg length, m; reach of the scuffing rule, m; and distance ahead of
the stance foot at which the swing foot has to be above the ground, m."""

LUMPED, FAILURE, UNEVENNESS, GRID = 9, 16, 17, 18
"""Indices there of the robot model's `compass.Constants`; of what a failure counts, m g l, J; of the
difference of height between footholds that a recovery step should bear, m; and of the recovery steps that are tried:
first value, distance and number of times (s), half angles (rad) and retractions."""


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


def step_ahead(parameters: Numbers, memory: Memory, state: State, rise: float) -> tuple[float, State]:
    """Simulate the step that the memory plans, by the midpoint rule.

    Args:
        parameters: Of the law; see `mjbiped.controllers.layout`.
        memory: Plans the step; only its room is written.
        state: With which the step begins.
        rise: Height of the next foothold over the plane, m.

    Returns:
        Absolute work of both joints, J, infinite where the step fails; and the state after it.
    """
    limits = int(parameters[SUPERVISION])
    h, t, work = parameters[limits + STEP], 0.0, 0.0
    collides, height = False, 0.0
    while t < parameters[limits + LONGEST]:
        borne = _move(parameters, memory, t, state)
        half = _moved(memory, state, 0.5 * h, state.dq1, state.dq2)
        borne = _move(parameters, memory, t + 0.5 * h, half) and borne
        if not borne:
            return math.inf, state
        work += h * (abs(memory[TORQUE] * half.dq1) + abs(memory[TORQUE + 1] * (half.dq2 - half.dq1)))
        after = _moved(memory, state, h, half.dq1, half.dq2)
        t += h
        ahead, above = compass.swing_foot(parameters[limits + LENGTH], compass.legs_of(after.q1, after.q2))
        above -= rise
        if collides and above <= 0.0:
            return work, _transferred(parameters, state, after, height / (height - above))
        fallen = not abs(after.q1) < parameters[limits + GREATEST]
        if fallen or (above <= 0.0 and ahead > parameters[limits + CLEAR]):
            return math.inf, state
        collides = swing_foot_collides(parameters[limits + REACH], 0.0, t, ahead, above)
        state, height = after, above
    return math.inf, state


def nominal_steps(parameters: Numbers, memory: Memory, state: State, count: int) -> tuple[int, float]:
    """Simulate steps of the tracking law, all but the first on all of the sole; the memory's plan is lost.

    Returns:
        The number of steps until one fails, `count` at most, and their work, J.
    """
    total, steps = 0.0, 0
    behind, ahead = memory[SUPPORT], memory[SUPPORT_AHEAD]
    while steps < count:
        plan_nominal(parameters, memory, state)
        work, state = step_ahead(parameters, memory, state, 0.0)
        if work == math.inf:
            break
        memory[SUPPORT], memory[SUPPORT_AHEAD] = 0.0, 0.0
        total += work
        steps += 1
    memory[SUPPORT], memory[SUPPORT_AHEAD] = behind, ahead
    return steps, total


def plan_nominal(parameters: Numbers, memory: Memory, state: State) -> None:
    """Plan a step of the tracking law."""
    memory[RECOVERING] = 0.0
    replanning.plan(parameters, memory, 0.0, (state.q1, state.q2), (state.dq1, state.dq2))


def _move(parameters: Numbers, memory: Memory, t: float, state: State) -> bool:
    """Write torques, accelerations and the ground's force in a state; return whether the ground holds the foot."""
    limits, slope = int(parameters[SUPERVISION]), memory[SLOPE]
    observe(2, (state.q1, state.q2), (state.dq1, state.dq2), memory)
    move(parameters, memory, t, parameters[limits + COUNTED_SHARE], (math.sin(slope), math.cos(slope)), memory)
    normal, along = memory[NORMAL], memory[ALONG]
    return normal >= parameters[limits + LEAST_FORCE] and abs(along) <= parameters[limits + FRICTION] * normal


def _moved(memory: Numbers, state: State, h: float, dq1: float, dq2: float) -> State:
    """Return the state a time h later, with given rates and the accelerations in the room."""
    ddq1, ddq2 = memory[MOTION], memory[MOTION + 1]
    return State(state.q1 + h * dq1, state.q2 + h * dq2, state.dq1 + h * ddq1, state.dq2 + h * ddq2)


def _transferred(parameters: Numbers, before: State, after: State, share: float) -> State:
    """Return the state after a support transfer at a share of the way between two states."""
    q1, q2 = before.q1 + share * (after.q1 - before.q1), before.q2 + share * (after.q2 - before.q2)
    dq1, dq2 = before.dq1 + share * (after.dq1 - before.dq1), before.dq2 + share * (after.dq2 - before.dq2)
    lumped = int(parameters[SUPERVISION]) + LUMPED
    constants: Any = parameters[lumped : lumped + 7]
    new1, new2 = compass.impact_rates(constants, q1, q2, dq1, dq2)
    return State(q2, q1, new1, new2)
