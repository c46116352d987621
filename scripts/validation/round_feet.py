"""Straight legs on round feet: McGeer's machine, and that of Bhounsule's program, whose impact has a term too many."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import scipy

import mjbiped
from mjbiped.controllers import PassiveController
from mjbiped.gaits.passive import PassiveGait, find_passive_gait
from mjbiped.robots.chain import Array
from mjbiped.robots.round import RoundCompass
from scripts.validation.published import (
    MCGEER_ROBOT,
    MCGEER_SLOPE,
    ROUND_FEET_ROBOT,
    ROUND_FEET_SLOPE,
    Computations,
    Computed,
)

MUJOCO_STEPS = 40
"""Steps after which a walk in MuJoCo has settled: the multipliers' moduli are below one half."""
Number: TypeAlias = Callable[[], Computed]
"""Computes a number of ours."""

AHEAD = 0.2  # the swing foot lands once the legs are so far apart, rad


@cache
def mcgeers() -> PassiveGait:
    """The gait of McGeer's machine."""
    return find_passive_gait(MCGEER_ROBOT, MCGEER_SLOPE)


@cache
def bhounsules() -> PassiveGait:
    """The gait of the program's machine, with an impact that conserves angular momentum."""
    return find_passive_gait(ROUND_FEET_ROBOT, ROUND_FEET_SLOPE)


def program_impact(robot: RoundCompass, q: Array, dq: Array) -> Array:
    """Rates after the heel strike as the program has them, in the new roles, rad/s.

    The trailing leg's angular momentum about the hip lacks its inertia times the rate of the hip's angle.
    """
    spurious = robot.leg_inertia * (dq[0] - dq[1]) * np.array([1.0, -1.0])
    more: Array = np.linalg.solve(robot.mass_matrix(q[::-1]), spurious)
    return robot.rates_after_touchdown(q, dq) + more


def repeated(robot: RoundCompass, slope: float, impact: Callable[[RoundCompass, Array, Array], Array]) -> Array:
    """Find the angle and the rates (q1, dq1, dq2) just after a heel strike that a step repeats, by SciPy alone."""
    free = robot.chains[2].free_motion

    def rates(_: float, y: Array) -> Array:
        return np.concatenate([y[2:], free(y[:2], y[2:], slope)])

    def height(_: float, y: Array) -> float:
        return float(robot.swing_foot(y[:2])[1]) if y[0] - y[1] > AHEAD else 1.0

    def mismatch(start: Array) -> Array:
        height.terminal, height.direction = True, -1  # type: ignore[attr-defined]  # SciPy's way
        y0 = np.array([start[0], -start[0], start[1], start[2]])
        span = (0.0, 10.0 * math.sqrt(robot.leg_length / robot.gravity))
        settings: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12, "events": height}
        end = scipy.integrate.solve_ivp(rates, span, y0, **settings).y[:, -1]
        return np.concatenate([end[1:2], impact(robot, end[:2], end[2:])]) - start

    guess = bhounsules().start[[0, 2, 3]]
    return np.asarray(scipy.optimize.root(mismatch, guess, tol=1e-11).x)


def in_mujoco() -> Array:
    """Period, q1, u1 and u2 of the program's machine that has walked in MuJoCo."""
    gait = bhounsules()
    ground = mjbiped.Terrain.incline(math.degrees(ROUND_FEET_SLOPE))
    walk = mjbiped.walk(PassiveController(), ground, robot=ROUND_FEET_ROBOT, steps=MUJOCO_STEPS, initial=gait.start)
    time, q, dq = (walk.touchdowns[name] for name in ("time", "q", "dq"))
    return np.array([time[-1] - time[-2], -q[-1, 0], -dq[-1, 0], dq[-1, 1] - dq[-1, 0]])


def _multiplier(gait: PassiveGait) -> complex:
    """The real multiplier."""
    return complex(min(gait.multipliers.tolist(), key=lambda one: abs(one.imag)))


def _pair(gait: PassiveGait) -> complex:
    """Of the pair of multipliers the one above the real axis."""
    return complex(max(gait.multipliers.tolist(), key=lambda one: one.imag))


def _of(gait: Callable[[], PassiveGait], number: Callable[[PassiveGait], complex], error: float) -> Number:
    return lambda: Computed(number(gait()), error)


MCGEERS: Computations = {
    "half angle": _of(mcgeers, lambda gait: -gait.start[0], 1e-11),
    "period": _of(mcgeers, lambda gait: gait.period, 1e-11),
    "multiplier": _of(mcgeers, _multiplier, 1e-7),
    "pair": _of(mcgeers, _pair, 1e-7),
}

ROUND_FEETS: Computations = {
    "angle": _of(bhounsules, lambda gait: -gait.start[0], 1e-11),
    "rate": _of(bhounsules, lambda gait: -gait.start[2], 1e-11),
    "hip angle": _of(bhounsules, lambda gait: gait.start[1] - gait.start[0], 1e-11),
    "hip rate": _of(bhounsules, lambda gait: gait.start[3] - gait.start[2], 1e-11),
    "period": _of(bhounsules, lambda gait: gait.period, 1e-11),
    "multiplier": _of(bhounsules, _multiplier, 1e-7),
    "pair": _of(bhounsules, _pair, 1e-7),
    "program's angle": lambda: Computed(
        -bhounsules().start[0], 1e-11, -float(repeated(ROUND_FEET_ROBOT, ROUND_FEET_SLOPE, program_impact)[0])
    ),
}
