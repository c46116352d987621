"""The walker with knees of Hsu Chen: integrated exactly, and as the program integrates that the numbers come from.

That program takes explicit Euler steps of 1 ms and finds each strike by halving the last one. Its angles are measured
from the vertical, counterclockwise, and so are its rates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial

import numpy as np
from scipy.optimize import root

from mjbiped.gaits.kneed import KneedGait, find_kneed_gait
from mjbiped.robots.chain import SWING_LOCKED, Array
from mjbiped.robots.kneed import KneedBiped
from scripts.validation.published import HSU_CHEN_ROBOT, HSU_CHEN_SECOND, HSU_CHEN_SLOPE, Computations, Computed

WIDTH = 1e-3
"""The program's time step, s."""
RUNS = 25
"""Of a walker disturbed, to which the published multipliers are fitted."""
QUANTITIES = ("stance angle", "swing angle", "stance rate", "swing rate")


@cache
def gait(robot: KneedBiped) -> KneedGait:
    """The gait on the published slope, integrated to 1e-11."""
    return find_kneed_gait(robot, HSU_CHEN_SLOPE)


def as_the_program_has_it(start: Array) -> Mapping[str, float]:
    """The published quantities of a state (q1, dq1, dq2) just after the heel strike."""
    angle, stance, swing = start.tolist()
    numbers = (-angle - HSU_CHEN_SLOPE, angle - HSU_CHEN_SLOPE, -stance, -swing)
    return dict(zip(QUANTITIES, numbers, strict=True))


@cache
def euler_gait(robot: KneedBiped, width: float = WIDTH) -> Array:
    """The fixed point (q1, dq1, dq2) of the Euler steps, near that of the exact motion."""
    guess = gait(robot).start[[0, 3, 4]]

    def mismatch(start: Array) -> Array:
        return euler_step(robot, start, width) - start

    return np.asarray(root(mismatch, guess, tol=1e-11).x)


def euler_step(robot: KneedBiped, start: Array, width: float = WIDTH) -> Array:
    """One step of the walker by explicit Euler steps of some width, s: (q1, dq1, dq2) after the next heel strike."""

    def until(n: int, state: Array, struck: Callable[[Array], bool]) -> Array:
        move = robot.chains[n].free_motion

        def after(state: Array, width: float) -> Array:
            return state + width * np.concatenate([state[n:], move(state[:n], state[n:], HSU_CHEN_SLOPE)])

        for _ in range(2000):
            ahead = after(state, width)
            if struck(ahead):
                break
            state = ahead
        part = width
        while part > 1e-17:
            part /= 2
            ahead = after(state, part)
            if not struck(ahead):
                state = ahead
        return state

    q1, dq1, dq2 = start
    bent = until(3, np.array([q1, -q1, -q1, dq1, dq2, dq2]), lambda y: bool(y[2] < y[1]))
    rates = robot.chains[3].joints_lock(SWING_LOCKED, bent[:3], bent[3:])
    straight = until(2, np.array([bent[0], bent[1], *rates]), lambda y: bool(y[0] + y[1] >= 0 and y[0] > y[1]))
    q, dq = robot.heel_impact(straight[:2], straight[2:])
    return np.array([q[0], *dq])


def fitted_multipliers(size: float, seed: int) -> Array:
    """Multipliers of the linear map fitted by least squares to `RUNS` steps from normally disturbed states.

    Args:
        size: Standard deviation of the disturbances, rad and rad/s.
        seed: Of their random numbers.

    Returns:
        Shape (3,), ascending by their real parts.
    """
    robot, point = HSU_CHEN_ROBOT, euler_gait(HSU_CHEN_ROBOT)
    disturbed = size * np.random.default_rng(seed).standard_normal((RUNS, 3))
    after = np.array([euler_step(robot, point + each) - point for each in disturbed])
    fitted = np.linalg.lstsq(disturbed, after, rcond=None)[0]
    return np.asarray(np.sort_complex(np.linalg.eigvals(fitted)))


def _state(robot: KneedBiped, quantity: str) -> Computed:
    exact = as_the_program_has_it(gait(robot).start[[0, 3, 4]])
    return Computed(exact[quantity], 1e-9, as_the_program_has_it(euler_gait(robot))[quantity])


def _states(robot: KneedBiped, prefix: str) -> Iterator[tuple[str, Callable[[], Computed]]]:
    for quantity in QUANTITIES:
        yield prefix + quantity, partial(_state, robot, quantity)


HSU_CHENS: Computations = {
    **dict(_states(HSU_CHEN_ROBOT, "")),
    "pair": lambda: Computed(max(gait(HSU_CHEN_ROBOT).multipliers, key=lambda value: value.imag), 1e-5),
    "real": lambda: Computed(min(gait(HSU_CHEN_ROBOT).multipliers, key=abs), 1e-5),
    **dict(_states(HSU_CHEN_SECOND, "second ")),
}
