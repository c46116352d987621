"""McGeer's machine with knees and round feet: its gait, and four multipliers by SciPy alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

import mjbiped
from mjbiped.controllers import PassiveController
from mjbiped.gaits.cycle import differences, eigenvalues, free_motion
from mjbiped.gaits.kneed import KneedGait, find_kneed_gait
from mjbiped.robots.robot import Array
from scripts.validation.published import MCGEER_KNEED_ROBOT, MCGEER_KNEED_SLOPE, Computations, Computed

MUJOCO_STEPS = 20
"""Steps after which a walk in MuJoCo has settled: the multipliers' moduli are below one half."""


@cache
def gait() -> KneedGait:
    """The gait of the machine."""
    return find_kneed_gait(MCGEER_KNEED_ROBOT, MCGEER_KNEED_SLOPE)


def step(start: Array) -> Array:
    """The numbers (q1, dq1, dq2, dq3) just after the next heel strike, of those just after one, by SciPy alone."""
    robot, slope = MCGEER_KNEED_ROBOT, MCGEER_KNEED_SLOPE

    def until(y: Array, event: Callable[[float, Array], float]) -> Array:
        n = len(y) // 2
        rates = free_motion(robot.chains[n], slope, 1.0)
        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]  # SciPy's way
        settings: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12, "events": event, "max_step": 0.1}
        solution: Any = scipy.integrate.solve_ivp(rates, (0.0, 10.0), y, **settings)
        return np.asarray(solution.y_events[0][0])

    q1, *rates = start.tolist()
    bent = until(np.array([q1, -q1, -q1, *rates]), lambda _, y: float(y[2] - y[1]))
    straight = np.concatenate(robot.knee_impact(bent[:3], bent[3:]))
    end = until(straight, lambda _, y: float(robot.swing_foot(y[:2])[1]))
    q, dq = robot.heel_impact(end[:2], end[2:])
    return np.array([q[0], *dq])


@cache
def multipliers() -> NDArray[np.complex128]:
    """Eigenvalues of the Jacobian of `step` at the gait, shape (4,), complex."""
    start = gait().start[[0, 3, 4, 5]]
    return eigenvalues(differences(lambda shift: step(start + shift), 4, 1e-4))


NAMES = ("period", "half angle, rad", "rate of the stance leg", "rate of the swing thigh", "time of the knee strike")
"""Of what is compared with MuJoCo."""


def in_mujoco() -> Array:
    """The numbers of `NAMES` of the machine that has walked in MuJoCo."""
    ground = mjbiped.Terrain.incline(math.degrees(MCGEER_KNEED_SLOPE))
    walk = mjbiped.walk(PassiveController(), ground, robot=MCGEER_KNEED_ROBOT, steps=MUJOCO_STEPS, initial=gait().start)
    time, q, dq, strike = (walk.touchdowns[name] for name in ("time", "q", "dq", "knee_strike"))
    return np.array([time[-1] - time[-2], -q[-1, 0], dq[-1, 0], dq[-1, 1], strike[-1]])


def exact() -> Array:
    """The numbers of `NAMES` of the gait."""
    found = gait()
    return np.array([found.period, -found.start[0], *found.start[3:5], found.knee_strike])


def _multiplier(place: int, of: Callable[[complex], float] = abs) -> Callable[[], Computed]:
    return lambda: Computed(of(complex(multipliers()[place])), 1e-6)


MCGEERS_KNEED: Computations = {
    "modulus": _multiplier(0),
    "angle": _multiplier(0, lambda value: abs(math.atan2(value.imag, value.real))),
    "real": _multiplier(2, lambda value: value.real),
    "least": _multiplier(3),
}
