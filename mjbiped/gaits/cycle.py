"""One unpowered step of any robot from heel strike to heel strike, and the limit cycle near a guess.

A step begins just after a heel strike, with both feet on the plane: its start is (q1, dq1, dq2). The first part lasts
until the knee strikes its stop, or until straight legs pass each other; the second one until the swing foot comes down
ahead of the stance foot, where q1 + q2 rises through zero. Straight legs may scuff beside the stance foot (eq. 4).

Angles are in rad, times in the robot's own unit (`unit_of`): so similar robots have equal gaits, to the last digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy  # it loads a part when that is first used: half a second for all of these
from numpy.typing import NDArray

from mjbiped.errors import GaitError
from mjbiped.robots.chain import Chain
from mjbiped.robots.robot import Array, Robot

FINEST, FINE, COARSE = (1e-13, 0.02), (1e-11, 0.05), (1e-6, 0.1)
"""Tolerance of an integration, relative and absolute, and its longest step, by which no event is missed; the finest
one is as good between its steps as at their ends, and the coarse one leads to guesses, which are searched again."""

LONGEST = 10.0  # longest part of a step; steps take 2
WIDEST = 2.0  # no leg of a walker turns so far from the normal, rad
MOST_TRIALS = 100  # steps tried for one gait; those that are found take 10 to 60
MOST_COARSE = 20  # in a coarse search, from a close guess: 10 to 17
MOST_ASKED = 100.0
"""Evaluations of a motion times its longest step: those that walk need some 40 of it, a wild one would take seconds."""


class Part(NamedTuple):
    """Part of a step: its duration, the state at its end, and what finds the states in between, by time."""

    duration: float
    end: Array
    motion: Callable[[], Any]


class Step(NamedTuple):
    """A step: its two parts, and the start of the next one."""

    first: Part
    second: Part
    after: Array


def upright_modes(robot: Robot) -> tuple[Array, Array]:
    """Squares of the rates at which two straight legs fall and swing about the upright posture, 1/s^2, and modes.

    The first square is negative where the legs fall.
    """
    chain = robot.chains[2]
    pull = chain.gravity_vector(np.full(2, 0.5 * math.pi), 0.0)  # at right angles to gravity: the whole moments
    squares, modes = scipy.linalg.eigh(np.diag(pull), chain.mass_matrix(np.zeros(2)))
    return squares, modes


@lru_cache(maxsize=256)
def unit_of(robot: Robot) -> float:
    """The unit of time, s: sqrt(l/g), or more where the legs swing so slowly that their own time is longer."""
    pendulum = math.sqrt(robot.leg_length / robot.gravity)
    return pendulum if len(robot.angles) == 1 else max(pendulum, 1.0 / math.sqrt(upright_modes(robot)[0][1]))


def no_gait(slope: float, reason: str) -> GaitError:
    """Make the error that a robot has no gait on a slope."""
    return GaitError(f"no passive gait on a slope of {math.degrees(slope):.6g} degrees: {reason}")


def free_motion(chain: Chain, slope: float, unit: float) -> Callable[[float, Array], Sequence[float]]:
    """The unpowered motion of a chain on a slope (rad): a function from the state to its rates."""
    move, n = chain.free_motion, len(chain.reach)

    def rates(_: float, state: Array) -> Sequence[float]:
        values = state.tolist()
        ddq = move(values[:n], [rate / unit for rate in values[n:]], slope)
        return [*values[n:], *(unit * unit * each for each in ddq)]

    return rates


def glide(
    law: Callable[[float, Array], Sequence[float]],
    start: Array,
    span: float,
    ends: tuple[Callable[[float, Array], float], ...] = (),
    precision: tuple[float, float] = FINE,
    *,
    between: bool = True,
) -> Any:
    """SciPy's integration of an unpowered motion, until one of some functions falls through zero.

    The states in between take a quarter of the time, and the end is the same without them.
    """
    events: list[Any] = list(ends)
    for event in events:
        event.terminal, event.direction = True, -1
    with np.errstate(all="ignore"):  # a start that leads nowhere
        return scipy.integrate.solve_ivp(
            law, (0.0, span), start, "DOP853", dense_output=between,
            rtol=precision[0], atol=precision[0], max_step=precision[1], events=events,
        )  # fmt: skip


def part_of(
    robot: Robot,
    slope: float,
    start: Array,
    ends: Callable[[Array], float],
    others: dict[str, Callable[[Array], float]],
    precision: tuple[float, float] = FINE,
) -> Part:
    """The motion from a start until `ends` falls through zero.

    Raises:
        GaitError: A leg turns over, one of the others falls through zero before, or nothing does.
    """
    law, asked = free_motion(robot.chains[len(start) // 2], slope, unit_of(robot)), 0

    def counted(t: float, state: Array) -> Sequence[float]:
        nonlocal asked
        asked += 1
        if asked * precision[1] > MOST_ASKED or not math.isfinite(sum(state.tolist())):
            raise no_gait(slope, "the motion is too wild")
        return law(t, state)

    others = {"a leg turns over": lambda y: WIDEST - float(np.abs(y[: len(y) // 2]).max()), **others}
    functions = tuple((lambda _, y, f=f: float(f(y))) for f in (ends, *others.values()))
    solution = glide(counted, start, LONGEST, functions, precision, between=False)
    if not solution.t_events[0].size:
        happened = [name for name, times in zip(others, solution.t_events[1:], strict=True) if times.size]
        raise no_gait(slope, happened[0] if happened else "the step does not end")
    duration, end = float(solution.t_events[0][0]), solution.y_events[0][0]
    return Part(duration, end, lambda: glide(law, start, LONGEST, functions, precision).sol)


def step(robot: Robot, slope: float, places: Array, precision: tuple[float, float] = FINE) -> Step:
    """The step from a start.

    Raises:
        GaitError: There is none.
    """
    start, n = robot.after_touchdown(places), len(robot.angles)
    if n == 3:
        height: dict[str, Callable[[Array], float]] = {
            "the swing foot touches the ground before the knee is straight": lambda y: robot.chains[3].end(y[:3])[1]
        }
        first = part_of(robot, slope, start, lambda y: y[2] - y[1], height, precision)
        if first.duration < 1e-3:
            raise no_gait(slope, "the knee does not bend")
        struck = np.concatenate(robot.knee_impact(first.end[:3], first.end[3:]))  # type: ignore[attr-defined]
    else:
        first = part_of(robot, slope, start, lambda y: y[1] - y[0], {}, precision)
        struck = first.end
    second = part_of(robot, slope, struck, lambda y: -y[0] - y[1], {}, precision)
    q, dq = second.end[:2], second.end[2:]
    if q[0] <= q[1]:
        raise no_gait(slope, "the swing foot lands behind the stance foot")
    columns = [0, 1, 1][:n]
    return Step(first, second, np.array([q[1], *robot.rates_after_touchdown(q[columns], dq[columns])[:2]]))


def limit_cycle(robot: Robot, slope: float, guess: Array, precision: tuple[float, float] = FINE) -> Array | None:
    """The start near a guess that repeats itself, by SciPy's root finder; None where there is none.

    A coarse search is for a guess that is close: it ends at the first start from which there is no step.
    """

    def mismatch(places: Array) -> Array:
        try:
            difference: Array = step(robot, slope, places, precision).after - places
        except GaitError:
            if precision is COARSE:
                raise
            return np.full(3, 10.0)  # far from any walking: turn back
        return difference

    # eps: relative differences of 1e-5, for the integration's noise is 1e-11
    exact, most = (1e-7, MOST_COARSE) if precision is COARSE else (1e-12, MOST_TRIALS)
    try:
        solution = scipy.optimize.root(  # type: ignore[call-overload]  # the stubs misspell maxfev
            mismatch, guess, method="hybr", tol=exact, options={"eps": 1e-10, "maxfev": most}
        )
    except GaitError:
        return None
    return solution.x if np.abs(solution.fun).max() < 1e3 * exact * np.abs(guess).max() else None


def attributes(robot: Robot, slope: float, places: Array, walked: Step) -> dict[str, Any]:
    """What is known of the gait of a start that repeats itself, but for its trajectories."""
    unit, end = unit_of(robot), walked.second.end
    scale, columns = np.array([1.0, unit, unit]), [0, 1, 1][: len(robot.angles)]
    # a round stance foot has rolled
    rolled = robot.radius * (end[0] - places[0])
    # truncation ~1e-9 of maps as curved as these, and less noise
    jacobian = differences(lambda shift: step(robot, slope, places + shift).after, 3, 2e-4 * abs(places[0]))
    return {
        "start": robot.after_touchdown(places / scale),
        "end": np.concatenate([end[:2][columns], end[2:][columns] / unit]),
        "period": (walked.first.duration + walked.second.duration) * unit,
        "step_length": float(robot.swing_foot(end[:2])[0] + rolled),
        "multipliers": eigenvalues(jacobian),
    }


def eigenvalues(matrix: Array) -> NDArray[np.complex128]:
    """Eigenvalues of a square matrix, the largest modulus first."""
    values = np.linalg.eigvals(matrix).astype(np.complex128)
    return values[np.argsort(-np.abs(values), kind="stable")]


def differences(function: Callable[[Array], Array], size: int, width: float) -> Array:
    """The Jacobian of a function of `size` numbers at zero, by central differences of fourth order."""
    columns = []
    for step in width * np.eye(size):
        near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
        columns.append((8 * near - far) / (12 * width))
    return np.column_stack(columns)
