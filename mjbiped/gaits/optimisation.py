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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import GaitError, InputError, shown
from mjbiped.gaits.bezier import DEGREE, Numbers
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain

LEAST_LOAD = 0.05  # of the weight: the ground bears at least this much
LANDING_RATE = 0.02  # of sqrt(g l): the swing foot comes down at the end at least so fast
HALF_ANGLE = Domain(0.02, 0.7, "rad")
"""Half the angle between the legs at the impact."""
CLEARANCE_PHASES = (0.5, 0.95)  # between which the swing foot has its clearance

_FINER = 20  # times as many intervals as the optimiser's are checked and told at the end
_STAIRS = 0.04  # leg lengths by which the clearance is raised from solution to solution
_SMOOTHING = (1e-2, 3e-3, 1e-3, 2e-4)  # of the absolute power, in weights times speed
_TORQUE_WEIGHT = 1e-3  # of the mean square torque in (weight x leg length)², beside the cost of transport
_FAR = 0.05  # leg lengths or weights: a trial that breaks a constraint by more is not worked on
TOLERANCE = 5e-4  # leg lengths, weights: what a constraint may be broken by between the points where it is kept


class Course(NamedTuple):
    """What happens along a motion, at m moments; shapes (..., m), torques and powers (..., m, actuators).

    Attributes:
        torques: Of the actuators, N m.
        powers: Of the actuators, W.
        tangential_force: Of the ground on the stance foot, N.
        normal_force: N.
        ahead: Place of the swing foot ahead of the stance foot, m.
        height: Of the swing foot over the ground, m.
        ahead_rate: m/s.
        height_rate: m/s.
    """

    torques: Numbers
    powers: Numbers
    tangential_force: Numbers
    normal_force: Numbers
    ahead: Numbers
    height: Numbers
    ahead_rate: Numbers
    height_rate: Numbers


class Motion(NamedTuple):
    """A step as it is tried; shapes may have further axes in front.

    Attributes:
        half: Half the angle between the legs at the impact, rad.
        points: Control points, rad, shape (..., DEGREE + 1, joints).
        own: What the robot adds, shape (..., n).
        period: s.
    """

    half: Numbers
    points: Numbers
    own: Numbers
    period: Numbers


class StepModel(Protocol):
    """What a robot brings to the optimiser. Its functions take complex arrays, and are analytic in them.

    Attributes:
        joints: How many angles are Bézier curves over the whole step.
        own: Bounds of the numbers that the robot adds, each of the kind (least, greatest).
        intervals: Of the quadrature between the moments at which something changes abruptly: the clearance's phase and
            those of `breaks`. All even.
        starts: Half angles (rad) and phases of clearance from which searches begin.
        lifted: Leg lengths by which the foot is lifted even where no clearance is asked for; 0: it may scuff.
        length: Of a leg, m.
        weight: N.
        gravity: m/s².
    """

    @property
    def joints(self) -> int: ...  # noqa: D102
    @property
    def own(self) -> Sequence[tuple[float, float]]: ...  # noqa: D102
    @property
    def intervals(self) -> tuple[int, ...]: ...  # noqa: D102
    @property
    def starts(self) -> Sequence[tuple[float, float]]: ...  # noqa: D102
    @property
    def lifted(self) -> float: ...  # noqa: D102
    @property
    def length(self) -> float: ...  # noqa: D102
    @property
    def weight(self) -> float: ...  # noqa: D102
    @property
    def gravity(self) -> float: ...  # noqa: D102

    def postures(self, half: Numbers) -> tuple[Numbers, Numbers]:
        """Angles after and before the impact, rad, shape half.shape + (joints,), of half the angle between the legs."""

    def step_length(self, half: Numbers) -> Numbers:
        """Between the feet, m."""

    def rates_after_impact(self, half: Numbers, rates: Numbers) -> Numbers:
        """Rates after the impact, in the new roles, of the rates before it (rad/s)."""

    def breaks(self, own: Numbers) -> tuple[Numbers, ...]:
        """Phases after the clearance's at which the motion changes abruptly, of its own numbers, shape (..., n)."""

    def along(self, motion: Motion, stretches: Sequence[Numbers]) -> Course:
        """What a motion asks of the robot at phases in each stretch between the breaks, each of shape (..., m)."""

    def keeps(self, goal: Goal, motion: Motion, course: Course, phases: Numbers, second: int) -> Mapping[str, Numbers]:
        """What must not be negative for the way that this robot swings its leg, scaled, shapes (..., n), by name.

        Args:
            goal: What is asked.
            motion: As it is tried.
            course: Along it.
            phases: Of the course, shape (..., m).
            second: Index of the moment at which the swing foot has its clearance.
        """

    def guess(self, half: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Control points to begin the search with, shape (DEGREE + 1, joints), and the robot's own numbers."""


@dataclass(frozen=True)
class Goal:
    """What is asked of a reference.

    Attributes:
        speed: Mean speed, m/s.
        clearance: Height of the swing foot over level ground at some moment, m; 0 for no demand on the foot's path but
            that it lands where it shall.
        retraction: Whether the foot goes no further forward from that moment on.
        torque_limit: No actuator gives more, N m; None for no limit.
        friction: Greatest ratio of tangential to normal force.

    Raises:
        InputError: One is outside its domain.
    """

    speed: float
    clearance: float
    retraction: bool
    torque_limit: float | None
    friction: float

    def __post_init__(self) -> None:
        """Check the values."""
        domains.check_fields(self, speed=domains.SPEED, clearance=domains.CLEARANCE, friction=domains.NEEDED_FRICTION)
        domains.check_given_fields(self, torque_limit=domains.TORQUE)
        if not isinstance(self.retraction, bool):
            raise InputError(f"retraction = {shown(self.retraction)}: must be True or False")


class Solution(NamedTuple):
    """A reference.

    Attributes:
        clearance_phase: Phase, 0 to 1, at which the swing foot has its clearance.
        half: Half the angle between the legs, rad.
        points: Control points, rad, shape (DEGREE + 1, joints).
        own: Numbers of the robot's own; none of the compass.
        period: s.
    """

    clearance_phase: float
    half: float
    points: NDArray[np.float64]
    own: NDArray[np.float64]
    period: float


class Told(NamedTuple):
    """What a reference asks, found on a grid twenty times as fine as the optimiser's.

    Attributes:
        cost_of_transport: Absolute work for weight and distance.
        peak_torque: Greatest torque of each actuator, N m.
        normal_force: Least, N.
        friction: Greatest ratio of tangential to normal force.
        clearance: Height of the swing foot at its phase, m.
        greatest_clearance: Greatest height of the swing foot while it is ahead of the stance foot, m.
        broken: By how much each constraint is broken, scaled; zero or less where it is kept.
    """

    cost_of_transport: float
    peak_torque: tuple[float, ...]
    normal_force: float
    friction: float
    clearance: float
    greatest_clearance: float
    broken: Mapping[str, float]


def optimise(model: StepModel, goal: Goal) -> Solution:
    """The cheapest reference of several searches.

    Raises:
        GaitError: None keeps the constraints; the message says what stands in the way, and what to do.
    """
    found, broken = _best(model, goal)
    if found is None:
        raise GaitError(f"no reference was found for {_asked(goal)}: {_hindrance(model, goal, broken)}")
    return found


def _best(model: StepModel, goal: Goal) -> tuple[Solution | None, Mapping[str, float]]:
    """The cheapest solution that keeps the constraints, if any; and by how much the least bad one breaks them."""
    found = [solution for start in model.starts for solution in _search(model, goal, *start)]
    told = [tell(model, goal, solution) for solution in found]
    kept = [k for k, each in enumerate(told) if max(each.broken.values()) < TOLERANCE]
    best = found[min(kept, key=lambda k: told[k].cost_of_transport)] if kept else None
    return best, min((each.broken for each in told), key=lambda broken: max(broken.values()), default={})


def solution_of(model: StepModel, goal: Goal, clearance_phase: float, free: NDArray[np.float64]) -> Solution:
    """A reference of the numbers that are chosen: half the angle between the legs, free control points, robot's own."""
    motion = _motion(model, goal, free)
    return Solution(clearance_phase, float(motion.half), motion.points, motion.own, float(motion.period))


def free_numbers(solution: Solution) -> NDArray[np.float64]:
    """What `solution_of` makes a solution of again, bit by bit."""
    return np.concatenate([[solution.half], solution.points[2:-1].ravel(), solution.own])


def tell(model: StepModel, goal: Goal, solution: Solution) -> Told:
    """What a reference asks, on a grid twenty times as fine as the optimiser's."""
    motion = Motion(np.array(solution.half), solution.points, solution.own, np.array(solution.period))
    stretches, weights, second = _grid(
        (np.array(solution.clearance_phase), *model.breaks(motion.own)), [_FINER * count for count in model.intervals]
    )
    course = model.along(motion, stretches)
    work = float((np.abs(course.powers).sum(axis=-1) * weights).sum() * solution.period)
    distance = goal.speed * solution.period
    ahead = course.ahead > 0.0
    kept = _constraints(model, goal, motion, course, np.concatenate(stretches, axis=-1), second)
    broken = {name: float(-values.min()) for name, values in kept.items()}
    return Told(
        cost_of_transport=work / (model.weight * distance),
        peak_torque=tuple(np.abs(course.torques).max(axis=0).tolist()),
        normal_force=float(course.normal_force.min()),
        friction=float(np.abs(course.tangential_force / course.normal_force).max()),
        clearance=float(course.height[second]),
        greatest_clearance=float(course.height[ahead].max()),
        broken=broken,
    )


def _search(model: StepModel, goal: Goal, half: float, phase: float) -> Iterator[Solution]:
    """One search: without clearance first, then with more and more of it, then with the cost's corners sharpened."""
    from scipy.optimize import minimize

    points, own = model.guess(half)
    x = np.concatenate([[phase, half], points[2:-1].ravel(), own])
    wide = [*[(-3.0, 3.0)] * (model.joints * (DEGREE - 2)), *model.own]
    stairs = math.ceil(goal.clearance / (_STAIRS * model.length) - 1e-9)
    stages = [(goal.clearance * k / max(stairs, 1), _SMOOTHING[0]) for k in range(stairs + 1)]
    stages += [(goal.clearance, smoothing) for smoothing in _SMOOTHING[1:]]
    for clearance, smoothing in stages:
        problem = _Problem(model, replace(goal, clearance=clearance), smoothing)
        bounds = [
            CLEARANCE_PHASES if clearance or model.lifted else (x[0], x[0]),
            (HALF_ANGLE.low, HALF_ANGLE.high),
            *wide,
        ]
        kept = {"type": "ineq", "fun": problem.kept, "jac": problem.kept_jacobian}
        options = {"maxiter": 150, "ftol": 1e-9}
        done = minimize(  # type: ignore[call-overload]  # the stubs know no constraints with keys of type str
            problem.cost, x, jac=problem.gradient, bounds=bounds, constraints=kept, method="SLSQP", options=options
        )
        if not np.isfinite(done.x).all():
            return
        x = np.clip(done.x, *np.array(bounds).T)
        if problem.kept(x).min() < -_FAR:
            break  # hopeless, for more clearance too; told below what it lacks
    yield solution_of(model, goal, float(x[0]), x[1:])


class _Problem:
    """Cost and constraints of the numbers (clearance's phase, half angle, free control points), with derivatives."""

    _STEP = 1e-30  # so small that no derivative has any error but rounding

    def __init__(self, model: StepModel, goal: Goal, smoothing: float) -> None:
        self._model, self._goal, self._smoothing = model, goal, smoothing
        self._at: bytes = b""
        self._values: tuple[Any, ...] = ()

    def cost(self, x: NDArray[np.float64]) -> float:
        return float(self._evaluated(x)[0])

    def gradient(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self._evaluated(x)[1])

    def kept(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self._evaluated(x)[2])

    def kept_jacobian(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self._evaluated(x)[3])

    def _evaluated(self, x: NDArray[np.float64]) -> tuple[Any, ...]:
        """Cost, its gradient, what must not be negative, and its Jacobian: one evaluation for all."""
        if x.tobytes() != self._at:
            directions = np.vstack([np.zeros((1, len(x))), np.eye(len(x))])
            cost, kept = self._of(x + 1j * self._STEP * directions)
            derivative, jacobian = cost.imag / self._STEP, kept.imag / self._STEP
            self._values = float(cost[0].real), derivative[1:], kept[0].real, jacobian[1:].T
            self._at = x.tobytes()
        return self._values

    def _of(self, x: Numbers) -> tuple[Numbers, Numbers]:
        model, goal = self._model, self._goal
        motion = _motion(model, goal, x[:, 1:])
        stretches, weights, second = _grid((x[:, 0], *model.breaks(motion.own)), model.intervals)
        course = model.along(motion, stretches)
        power = course.powers / (model.weight * goal.speed)
        smooth = np.sqrt(power * power + self._smoothing**2) - self._smoothing
        squares = (course.torques / (model.weight * model.length)) ** 2
        cost = ((smooth + _TORQUE_WEIGHT * squares).sum(axis=-1) * weights).sum(axis=-1)
        kept = _constraints(model, goal, motion, course, np.concatenate(stretches, axis=-1), second)
        return cost, np.concatenate(list(kept.values()), axis=-1)


def _constraints(
    model: StepModel, goal: Goal, motion: Motion, course: Course, phases: Numbers, second: int
) -> dict[str, Numbers]:
    """What must not be negative, scaled by weight, leg length and gravity, shapes (..., n), by name.

    Args:
        model: The robot.
        goal: What is asked.
        motion: As it is tried.
        course: Along it.
        phases: Of the course.
        second: Index of the moment at which the swing foot has its clearance.
    """
    length, weight = model.length, model.weight
    rate = math.sqrt(model.gravity * length)
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
    return found


def _motion(model: StepModel, goal: Goal, free: Numbers) -> Motion:
    """The motion of the numbers that are chosen; the second control points follow from the impact map."""
    half = free[..., 0]
    start, end = model.postures(half)
    count = 1 + (DEGREE - 2) * model.joints
    inner = free[..., 1:count].reshape(*free.shape[:-1], DEGREE - 2, model.joints)
    period = model.step_length(half) / goal.speed
    share = period[..., None] / DEGREE
    after = model.rates_after_impact(half, (end - inner[..., -1, :]) / share)
    points = np.concatenate([np.stack([start, start + share * after], axis=-2), inner, end[..., None, :]], -2)
    return Motion(half, points, free[..., count:], period)


def _grid(breaks: Sequence[Numbers], intervals: Sequence[int]) -> tuple[list[Numbers], Numbers, int]:
    """Phases in the stretches between breaks, weights of Simpson's rule, and where the second stretch begins."""
    ends = [np.zeros_like(breaks[0]), *breaks, np.ones_like(breaks[0])]
    stretches, weights = [], []
    for first, last, count in zip(ends[:-1], ends[1:], intervals, strict=True):
        width = (last - first)[..., None]
        stretches.append(first[..., None] + width * np.linspace(0.0, 1.0, count + 1))
        weights.append(width * _simpson(count))
    return stretches, np.concatenate(weights, axis=-1), intervals[0] + 1


def _simpson(intervals: int) -> NDArray[np.float64]:
    weights = np.ones(intervals + 1)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    return np.asarray(weights / weights.sum())


def _asked(goal: Goal) -> str:
    words = f"a speed of {goal.speed:.4g} m/s"
    words += f", a clearance of {goal.clearance:.4g} m" if goal.clearance else " without clearance"
    return words + (f" and a torque limit of {goal.torque_limit:.4g} N m" if goal.torque_limit is not None else "")


def _hindrance(model: StepModel, goal: Goal, broken: Mapping[str, float]) -> str:
    """What stands in the way of a reference, found by asking for less; and what to do."""
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
        found, _ = _best(model, replace(goal, clearance=share * goal.clearance))
        if found is not None:
            return f"with a clearance of {share * goal.clearance:.3g} m there is one; ask for less clearance"
    if not broken:
        return "the search failed; ask for another speed"
    name = max(broken, key=broken.__getitem__)
    return f"the best one breaks the constraint '{name}'; ask for another speed, or allow more friction"
