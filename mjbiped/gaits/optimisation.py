"""Periodic references by trajectory optimisation, for any robot that brings its own laws of motion.

Each joint follows a Bézier curve of degree 7 over the step, which begins with the rates that the impact map makes of
those of its end, so that the step repeats itself exactly. What is left to choose (half the angle between the legs, the
other control points, the phase at which the swing foot has its clearance, and what a robot adds of its own, as the
flexion of a knee) is chosen by SciPy's SLSQP, with exact derivatives by complex steps: least absolute work for the
distance, under the constraints of `_constraints`.

Everything is scaled by the robot's weight, leg length and gravity, so that alike robots have alike references.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from mjbiped.errors import GaitError
from mjbiped.gaits.reference import DEGREE, Numbers
from mjbiped.gaits.steps import CompassStep, Course, Goal, Motion
from mjbiped.robots.robot import Array
from mjbiped.utils.domains import Domain

LEAST_LOAD = 0.05  # least normal force, weights
LANDING_RATE = 0.02  # least rate at which the swing foot comes down at the end, sqrt(g l)
HALF_ANGLE = Domain(0.02, 0.7, "rad")
"""Half the angle between the legs at the impact."""
CLEARANCE_PHASES = (0.5, 0.95)  # bounds of the phase at which the swing foot has its clearance

_FINER = 20  # factor on the optimiser's intervals for the final check and the measures
_STAIRS = 0.04  # increment of the clearance from solution to solution, leg lengths
_SMOOTHING = (1e-2, 3e-3, 1e-3, 2e-4)  # of the absolute power, in weights times speed
_TORQUE_WEIGHT = 1e-3  # of the mean square torque in (weight x leg length)², beside the cost of transport
_FAR = 0.05  # violation of a constraint beyond which a search is given up, leg lengths or weights
_COMPLEX_STEP = 1e-30  # so small that no derivative has any error but rounding
TOLERANCE = 5e-4  # violation of a constraint that is tolerated between the optimiser's points, leg lengths or weights


class Told(NamedTuple):
    """Measures of a reference on a grid twenty times as fine as the optimiser's.

    Attributes:
        cost_of_transport: Absolute work for weight and distance.
        peak_torque: Greatest torque of each actuator, N m.
        normal_force: Least normal force, N.
        friction: Greatest ratio of tangential to normal force.
        clearance: Height of the swing foot at its phase, m.
        greatest_clearance: Greatest height of the swing foot while it is ahead of the stance foot, m.
        broken: Violation of each constraint, scaled; zero or less where it holds.
    """

    cost_of_transport: float
    peak_torque: tuple[float, ...]
    normal_force: float
    friction: float
    clearance: float
    greatest_clearance: float
    broken: Mapping[str, float]


def optimise(model: CompassStep, goal: Goal) -> Array:
    """Search from several starts, and return the numbers of the cheapest reference; see `motion_of`.

    Matrices are as small as is best for one thread, and the result does not depend on the number of cores.

    Raises:
        GaitError: None keeps the constraints; the message says what stands in the way, and what to do.
    """
    import scipy.optimize  # noqa: F401 (loads the BLAS that is limited)
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1, "blas"):
        found, broken = _best(model, goal)
        if found is None:
            raise GaitError(f"no reference was found for {_asked(goal)}: {_hindrance(model, goal, broken)}")
    return found


def _best(model: CompassStep, goal: Goal) -> tuple[Array | None, Mapping[str, float]]:
    """The cheapest feasible solution, if any; and the violations of the least infeasible one."""
    found = [x for start in model.starts if (x := _searched(model, goal, *start)) is not None]
    told = [tell(model, goal, x) for x in found]
    kept = [k for k, each in enumerate(told) if max(each.broken.values()) < TOLERANCE]
    best = found[min(kept, key=lambda k: told[k].cost_of_transport)] if kept else None
    return best, min((each.broken for each in told), key=lambda broken: max(broken.values()), default={})


def tell(model: CompassStep, goal: Goal, x: Array) -> Told:
    """The measures of a reference."""
    motion = motion_of(model, goal, x)
    period = float(motion.period)
    course, phases, weights, second = _walked(model, motion, x, _FINER)
    work = float((np.abs(course.powers).sum(axis=-1) * weights).sum() * period)
    kept = _constraints(model, goal, motion, course, phases, second)
    return Told(
        cost_of_transport=work / (model.robot.weight * (goal.speed * period)),
        peak_torque=tuple(np.abs(course.torques).max(axis=0).tolist()),
        normal_force=float(course.normal_force.min()),
        friction=float(np.abs(course.tangential_force / course.normal_force).max()),
        clearance=float(course.height[second]),
        greatest_clearance=float(course.height[course.ahead > 0.0].max()),
        broken={name: float(-values.min()) for name, values in kept.items()},
    )


def _searched(model: CompassStep, goal: Goal, half: float, phase: float) -> Array | None:
    """One search: first without clearance, then with more and more of it, then with the cost's corners sharpened.

    The centre of pressure is kept within the sole last: begun with this, searches for short soles end nowhere.
    """
    soleless = replace(model, robot=replace(model.robot, sole=None))
    points, own = model.guess(half)
    x = np.concatenate([[phase, half], points[2:-1].ravel(), own])
    stairs = math.ceil(goal.clearance / (_STAIRS * model.robot.leg_length) - 1e-9)
    stages = [(soleless, goal.clearance * k / max(stairs, 1), _SMOOTHING[0]) for k in range(stairs + 1)]
    stages += [(soleless, goal.clearance, smoothing) for smoothing in _SMOOTHING[1:]]
    if model.robot.sole is not None:
        stages.append((model, goal.clearance, _SMOOTHING[-1]))
    for stage, clearance, smoothing in stages:
        x, kept = _improved(stage, replace(goal, clearance=clearance), smoothing, x)
        if not np.isfinite(x).all():
            return None
        if kept < -_FAR:
            break  # hopeless, for more clearance too; told below what it lacks
    return x


def _improved(model: CompassStep, goal: Goal, smoothing: float, x: Array) -> tuple[Array, float]:
    """The numbers that SLSQP finds from x, and the least value of the constraints."""
    from scipy.optimize import minimize

    @lru_cache(maxsize=1)
    def at(x: bytes) -> tuple[float, Array, Array, Array]:
        return evaluate(model, goal, smoothing, np.frombuffer(x))

    bounds = [
        CLEARANCE_PHASES if goal.clearance or model.lifted else (x[0], x[0]),
        (HALF_ANGLE.low, HALF_ANGLE.high),
        *[(-3.0, 3.0)] * (model.joints * (DEGREE - 2)),
        *model.own,
    ]
    done = minimize(  # type: ignore[call-overload]  # the stubs know no constraints with keys of type str
        lambda x: at(x.tobytes())[0],
        x,
        jac=lambda x: at(x.tobytes())[1],
        bounds=bounds,
        constraints={"type": "ineq", "fun": lambda x: at(x.tobytes())[2], "jac": lambda x: at(x.tobytes())[3]},
        method="SLSQP",
        options={"maxiter": 150, "ftol": 1e-9},
    )
    x = np.clip(done.x, *np.array(bounds).T)
    return x, float(at(x.tobytes())[2].min()) if np.isfinite(x).all() else -math.inf


def evaluate(model: CompassStep, goal: Goal, smoothing: float, x: Array) -> tuple[float, Array, Array, Array]:
    """Cost and constraints with their derivatives by complex steps.

    Returns:
        The cost and its gradient, shape (n,); the constraints, >= 0 where they hold, shape (m,), and their Jacobian.
    """
    numbers = x + 1j * _COMPLEX_STEP * np.vstack([np.zeros((1, len(x))), np.eye(len(x))])
    motion = motion_of(model, goal, numbers)
    course, phases, weights, second = _walked(model, motion, numbers, 1)
    power = course.powers / (model.robot.weight * goal.speed)
    smooth = np.sqrt(power * power + smoothing**2) - smoothing
    squares = (course.torques / (model.robot.weight * model.robot.leg_length)) ** 2
    cost = ((smooth + _TORQUE_WEIGHT * squares).sum(axis=-1) * weights).sum(axis=-1)
    kept = np.concatenate(list(_constraints(model, goal, motion, course, phases, second).values()), axis=-1)
    derivative, jacobian = cost.imag / _COMPLEX_STEP, kept.imag / _COMPLEX_STEP
    return float(cost[0].real), derivative[1:], kept[0].real, jacobian[1:].T


def _walked(model: CompassStep, motion: Motion, x: Numbers, finer: int) -> tuple[Course, Numbers, Numbers, int]:
    """Dynamics of a motion, its phases, their weights by Simpson's rule, and the index of the clearance's phase."""
    first = x[..., 0]
    zero, *others = (np.full_like(first, phase) for phase in (0.0, *model.breaks, 1.0))
    stretches, weights = [], []
    for begin, end, intervals in zip([zero, first, *others[:-1]], [first, *others], model.intervals, strict=True):
        width, count = (end - begin)[..., None], finer * intervals
        simpson = np.ones(count + 1)
        simpson[1:-1:2], simpson[2:-1:2] = 4.0, 2.0
        stretches.append(begin[..., None] + width * np.linspace(0.0, 1.0, count + 1))
        weights.append(width * np.asarray(simpson / simpson.sum()))
    phases, second = np.concatenate(stretches, axis=-1), finer * model.intervals[0] + 1
    return model.along(motion, stretches), phases, np.concatenate(weights, axis=-1), second


def _constraints(
    model: CompassStep, goal: Goal, motion: Motion, course: Course, phases: Numbers, second: int
) -> dict[str, Numbers]:
    """All constraints: values >= 0, scaled by weight, leg length and gravity, shapes (..., n), by name.

    Args:
        model: The step of the robot.
        goal: What is asked.
        motion: The motion that is tried.
        course: Its dynamics.
        phases: Phases of the course.
        second: Index of the moment at which the swing foot has its clearance.
    """
    length, weight = model.robot.leg_length, model.robot.weight
    rate = math.sqrt(model.robot.gravity * length)
    normal, tangential = course.normal_force / weight, course.tangential_force / weight
    found = {
        "normal force": normal - LEAST_LOAD,
        "friction": np.concatenate([goal.friction * normal - tangential, goal.friction * normal + tangential], axis=-1),
        "landing": -course.height_rate[..., -1:] / rate - LANDING_RATE,
        **model.keeps(goal, motion, course, phases, second),
    }
    if goal.clearance > 0.0:
        found["clearance"] = (course.height[..., second : second + 1] - goal.clearance) / length
    if goal.clearance > 0.0 and goal.retraction:
        found["retraction"] = -course.ahead_rate[..., second:] / rate
    if goal.torque_limit is not None:
        torques = course.torques.reshape(*course.torques.shape[:-2], -1)
        found["torque limit"] = np.concatenate([goal.torque_limit - torques, goal.torque_limit + torques], axis=-1) / (
            weight * length
        )
    if model.robot.sole is not None:
        (behind, ahead), ankle = model.robot.sole, course.torques[..., 0]
        ends = [behind * course.normal_force - ankle, ahead * course.normal_force + ankle]
        found["centre of pressure within the sole"] = np.concatenate(ends, axis=-1) / (weight * length)
    return found


def motion_of(model: CompassStep, goal: Goal, x: Numbers) -> Motion:
    """The motion of the numbers that the optimiser chooses; the second control points follow from the impact map.

    Args:
        model: The step of the robot.
        goal: What is asked.
        x: Phase at which the swing foot has its clearance, half the angle between the legs (rad), free control points
            (rad), and the robot's own numbers, shape (..., n).
    """
    half = x[..., 1]
    start, end = model.postures(half)
    count = 2 + (DEGREE - 2) * model.joints
    inner = x[..., 2:count].reshape(*x.shape[:-1], DEGREE - 2, model.joints)
    period = model.step_length(half) / goal.speed
    share = period[..., None] / DEGREE
    after = model.rates_after_impact(half, (end - inner[..., -1, :]) / share)
    points = np.concatenate([np.stack([start, start + share * after], axis=-2), inner, end[..., None, :]], -2)
    return Motion(half, points, x[..., count:], period)


def _asked(goal: Goal) -> str:
    words = f"a speed of {goal.speed:.4g} m/s"
    words += f", a clearance of {goal.clearance:.4g} m" if goal.clearance else " without clearance"
    return words + (f" and a torque limit of {goal.torque_limit:.4g} N m" if goal.torque_limit is not None else "")


def _hindrance(model: CompassStep, goal: Goal, broken: Mapping[str, float]) -> str:
    """Explain why there is no reference, by asking for less, and what to do."""
    if goal.torque_limit is not None:
        freely = replace(goal, torque_limit=None)
        found, _ = _best(model, freely)
        if found is not None:
            needed = max(tell(model, freely, found).peak_torque)
            return (
                f"without the torque limit there is one, which needs {needed:.3g} N m; raise the limit, or ask for "
                "less clearance or another speed"
            )
        goal = freely
    for share in (0.75, 0.5, 0.25, 0.0) if goal.clearance else ():
        lower = replace(goal, clearance=share * goal.clearance)
        found, _ = _best(model, lower)
        if found is not None:
            return f"with a clearance of {lower.clearance:.3g} m there is one; ask for less clearance"
    if not broken:
        return "the search failed; ask for another speed"
    name = max(broken, key=broken.__getitem__)
    sole = "" if model.robot.sole is None else ", or give the robot a longer sole"
    return f"the best one breaks the constraint '{name}'; ask for another speed, or allow more friction{sole}"
