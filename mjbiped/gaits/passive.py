"""Passive gaits: the limit cycle of the unpowered robot on a gentle slope (eq. 28), its stability and its trajectory.

Just after an impact on a plane the feet stand on it, q2 = -q1. A gait is a point (q1, dq1, dq2) of that section and a
period T such that the motion touches down at T and the impact map leads back to the point. It is found by SciPy's root
finder along the branch of gaits that leaves level ground. There, at slope -> 0, the gait is known: angles and rates
shrink like slope^(1/3), the motion about mid-stance is the odd solution of the linearised equations whose legs move as
one at touchdown, and the energy lost at the impact sets the slope. That holds for every mass distribution, so that no
guess, and no other robot's gait, is needed. docs/model.md gives the formulas.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy  # it loads a part when that is first used: half a second for all of these
from numpy.typing import NDArray

from mjbiped.errors import GaitError
from mjbiped.gaits import store
from mjbiped.gaits.gait import Gait, Passive
from mjbiped.gaits.pieces import FALLEN
from mjbiped.gaits.reference import motion_at, table_of
from mjbiped.robots.compass import (
    Array,
    Compass,
    acceleration,
    impact_rates,
    kinetic_energy,
    legs_of,
    mass_terms,
)
from mjbiped.robots.round import RoundCompass
from mjbiped.utils import domains

STEPS = 48  # fixed integration steps per period: the state at touchdown is then good to 1e-13
MOST_TRIALS = 100  # motions tried for one gait; those that are found take 10 to 60
MOST_PLACES = 100  # slopes on the way from level ground to the one asked for; 5 to 50 do
WIDEST = 2.0  # no leg of a walker turns so far from the normal, rad: only on slopes of 40 degrees and more


@dataclass(frozen=True, repr=False)
class PassiveGait(Passive, Gait):
    """A passive gait of period one, made by `find_passive_gait`; its slope is positive.

    Up to the horizon the trajectory is the passive motion (eq. 28), continued beyond the period for a late touchdown:
    up to two periods, or until the stance leg has fallen 60 degrees from the normal.

    Attributes:
        multipliers: Floquet multipliers, the eigenvalues of the return map's Jacobian; complex, shape (3,), the largest
            magnitude first; six digits or better. Fourth-order central differences of a fixed-step integration.
    """

    multipliers: NDArray[np.complex128] = field(compare=False)

    @property
    def energy(self) -> float:
        """Kinetic plus potential energy about the stance foot, constant during the step, J."""
        return self.robot.energy(self.start[:2], self.start[2:], self.slope)


def find_passive_gait(robot: Compass | RoundCompass, slope: float) -> PassiveGait:
    """The passive gait of period one on a plane (equation 28), stable or not.

    Where several gaits exist, it is the one whose swing leg swings out and comes back (the "long" gait), on the branch
    that leaves level ground. Table I has it beyond 20 degrees, stable up to 2.728; a leg with all its mass near the hip
    loses it much earlier. Results are kept in the user's cache folder, or where the environment variable
    MJBIPED_CACHE_DIR says.

    Args:
        robot: Any compass biped, on point feet or on round ones.
        slope: Slope of the plane, rad, > 0 (downhill).

    Raises:
        InputError: The slope is no number within a right angle of level, or the robot is no compass biped.
        GaitError: The robot has no such gait on that slope.
    """
    if not isinstance(robot, RoundCompass):
        domains.check_kind("robot", robot, Compass)
    return _find(robot.flat, checked_slope(slope))


def checked_slope(slope: float) -> float:
    """Check the slope of a passive gait, rad.

    Raises:
        InputError: It is no number within a right angle of level.
        GaitError: It does not lead downhill.
    """
    slope = domains.SLOPE.check("slope", slope)
    if slope < domains.DOWNHILL.low:
        raise no_gait(slope, f"without torques the robot walks only downhill; give a slope {domains.DOWNHILL}")
    return slope


_TABLE_ONE = Compass()


class _Model(NamedTuple):
    """A robot in units in which its legs and gravity are those of Table I: 1 m and 9.81 m/s^2.

    This makes the search and its tolerances the same for all sizes and gravities.

    Attributes:
        motion: (q1, q2, dq1, dq2, sine and cosine of the slope) -> accelerations without torques, rad/s^2.
        strike: (q1, q2, dq1, dq2) -> rates after the heel strike, in the new roles, rad/s.
        energy: (q1, q2, dq1, dq2) -> kinetic energy, J.
        pull: Of gravity on the legs near the upright posture, N m/rad, negative where it topples them, shape (2,).
        mass: Mass matrix in that posture, kg m^2, shape (2, 2).
        weight: Weight, N.
        radius: Of the feet, m.
        metre: The unit of length, m; exactly 1 for the legs of Table I.
        second: The unit of time, s; exactly 1 for its legs and gravity.
    """

    motion: Callable[..., tuple[float, float]]
    strike: Callable[..., tuple[float, float]]
    energy: Callable[..., float]
    pull: Array
    mass: Array
    weight: float
    radius: float
    metre: float
    second: float

    def advance(self, half: float) -> float:
        """Distance from one foot's heel strike to the next one's, m, by half the angle between the legs then, rad."""
        return 2 * ((_TABLE_ONE.leg_length - self.radius) * math.sin(half) + self.radius * half)


def _model(robot: Compass | RoundCompass) -> _Model:
    metre = robot.leg_length / _TABLE_ONE.leg_length
    second = math.sqrt(robot.leg_length / robot.gravity) / math.sqrt(_TABLE_ONE.leg_length / _TABLE_ONE.gravity)
    weight = robot.total_mass * _TABLE_ONE.gravity
    if isinstance(robot, RoundCompass):
        return _rolling(robot, weight, metre, second)
    square, moment = metre * metre, metre * robot.gravity / _TABLE_ONE.gravity
    m11, m12, m22, g1, g2, about_point, about_hip = robot.constants
    constants = (
        *(m11 / square, m12 / square, m22 / square, g1 / moment, g2 / moment),
        *(about_point / square, about_hip / square),
    )
    upright = mass_terms(constants, legs_of(0.0, 0.0))

    def motion(q1: float, q2: float, dq1: float, dq2: float, sine: float, cosine: float) -> tuple[float, float]:
        return acceleration(constants, q1, q2, dq1, dq2, sine, cosine, 0.0, 0.0)

    return _Model(
        motion,
        partial(impact_rates, constants),
        partial(kinetic_energy, constants),
        np.array([-constants[3], constants[4]]),
        np.array([[upright[0], upright[1]], [upright[1], upright[2]]]),
        weight,
        0.0,
        metre,
        second,
    )


def _rolling(robot: RoundCompass, weight: float, metre: float, second: float) -> _Model:
    lengths = {key: getattr(robot, key) / metre for key in ("lower_length", "upper_length", "foot_radius")}
    inertia, gravity = robot.leg_inertia / metre**2, _TABLE_ONE.gravity
    scaled = replace(robot, **lengths, leg_inertia=inertia, gravity=gravity)
    linkage = scaled.chains[2]
    free = linkage.free_motion

    def motion(q1: float, q2: float, dq1: float, dq2: float, sine: float, cosine: float) -> tuple[float, float]:
        ddq = free(np.array([q1, q2]), np.array([dq1, dq2]), math.atan2(sine, cosine))
        return float(ddq[0]), float(ddq[1])

    def strike(q1: float, q2: float, dq1: float, dq2: float) -> tuple[float, float]:
        after = scaled.rates_after_touchdown([q1, q2], [dq1, dq2])
        return float(after[0]), float(after[1])

    def energy(q1: float, q2: float, dq1: float, dq2: float) -> float:
        return linkage.kinetic_energy(np.array([q1, q2]), np.array([dq1, dq2]))

    pull = linkage.gravity_vector(np.full(2, 0.5 * math.pi), 0.0)  # at right angles to gravity: the whole moments
    return _Model(
        motion, strike, energy, pull, linkage.mass_matrix(np.zeros(2)), weight, lengths["foot_radius"], metre, second
    )


@lru_cache(maxsize=256)
def _find(robot: Compass | RoundCompass, slope: float) -> PassiveGait:
    found = store.passive(robot, slope, _search)
    table = table_of(found.pop("rate"), found.pop("coefficients"))
    return PassiveGait(robot, slope, table=table, **found)  # type: ignore[arg-type]  # no law imitates rolling feet


def _search(robot: Compass | RoundCompass, slope: float) -> dict[str, Any]:
    """The attributes of a gait, with the pieces of its table."""
    model = _model(robot)
    scaled = _follow_branch(model, slope)
    start, period = _unscale(slope, scaled)
    end = _motion(model, slope, start, period, STEPS)[-1]
    _check(model, slope, start, period)
    rate, coefficients = _tabulate(model, slope, start, period)
    return {
        "start": start / [1, 1, model.second, model.second],
        "end": end / [1, 1, model.second, model.second],
        "period": period * model.second,
        "step_length": model.advance(end[0]) * model.metre,
        "multipliers": eigenvalues(_return_map_jacobian(model, slope, scaled)),
        "rate": rate / model.second,
        "coefficients": coefficients,
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


def no_gait(slope: float, reason: str, what: str = "passive gait") -> GaitError:
    """Make the error that a robot has no gait on a slope."""
    return GaitError(f"no {what} on a slope of {math.degrees(slope):.6g} degrees: {reason}")


def _passive(model: _Model, slope: float) -> Callable[[Array], list[float]]:
    """The unpowered motion: a function from the state to its rates (dq1, dq2, ddq1, ddq2)."""
    sine, cosine = math.sin(slope), math.cos(slope)

    def rates(state: Array) -> list[float]:
        q1, q2, dq1, dq2 = state.tolist()
        return [dq1, dq2, *model.motion(q1, q2, dq1, dq2, sine, cosine)]

    return rates


def _motion(model: _Model, slope: float, start: Array, duration: float, steps: int, widest: float = math.inf) -> Array:
    """States at `steps` + 1 equal intervals of the unpowered motion, shape (steps + 1, 4).

    The integration steps are fixed, so that the result depends smoothly on `start` and `duration`; DOP853's error
    estimate only decides whether they are short enough, and its own order makes the result far better than `rtol`.

    Raises:
        GaitError: No steps are short enough, or a leg turns from the normal by more than `widest` (rad).
    """
    law = _passive(model, slope)
    for finer in (1, 2, 4, 8, 16, 32):
        count = finer * steps
        width = duration / count

        def scaled(_: float, state: Array, width: float = width) -> Array:
            return np.array([width * rate for rate in law(state)])

        # time counts steps, so that it stays exact
        solver = scipy.integrate.DOP853(
            scaled, 0.0, start, float(count), first_step=1.0, max_step=1.0, rtol=1e-8, atol=1e-8
        )
        states = [solver.y]
        while solver.status == "running":
            solver.step()
            if solver.t != len(states):
                break  # a step was too long
            states.append(solver.y)
            if max(abs(solver.y[0]), abs(solver.y[1])) > widest:
                raise no_gait(slope, "a leg turns over")
        if len(states) == count + 1:
            return np.array(states[::finer])
    raise no_gait(slope, "the motion is too fast to follow; check the robot's lengths and masses")


def _scales(slope: float) -> Array:
    """Scales (r, r w, r w, 1/w) of (q1, dq1, dq2, period), with r = slope^(1/3) and w = sqrt(g/l).

    A gait divided by them, a "scaled" gait, stays finite as the slope vanishes.
    """
    ratio, frequency = math.cbrt(slope), math.sqrt(_TABLE_ONE.gravity / _TABLE_ONE.leg_length)
    return np.array([ratio, ratio * frequency, ratio * frequency, 1 / frequency])


def _unscale(slope: float, scaled: Array) -> tuple[Array, float]:
    """State after the impact, shape (4,), and period of a scaled gait."""
    q1, dq1, dq2, period = (_scales(slope) * scaled).tolist()
    return np.array([q1, -q1, dq1, dq2]), period


def _step(model: _Model, slope: float, scaled: Array, steps: int) -> Array:
    """Scaled (q1 + q2 at the end of the period, then q1, dq1, dq2 after the impact); for a gait, (0, q1, dq1, dq2)."""
    start, period = _unscale(slope, scaled)
    q1, q2, dq1, dq2 = _motion(model, slope, start, period, steps, WIDEST)[-1].tolist()
    after = np.array([q1 + q2, q2, *model.strike(q1, q2, dq1, dq2)])
    return after / _scales(slope)[[0, 0, 1, 2]]


def _solve(model: _Model, slope: float, guess: Array, steps: int, tolerance: float) -> Array | None:
    """The scaled gait near `guess`, by SciPy's root finder; None where there is none."""

    def mismatch(scaled: Array) -> Array:
        if np.abs(scaled).max() > 12 or scaled[3] < 0.1:
            return np.full(4, 1e3)  # far from any walking: turn back
        try:
            difference: Array = _step(model, slope, scaled, steps) - np.concatenate([np.zeros(1), scaled[:3]])
        except GaitError:
            return np.full(4, 1e3)
        return difference

    # eps: relative differences of 1e-7 for the Jacobian
    options = {"eps": 1e-14, "maxfev": MOST_TRIALS}
    solution = scipy.optimize.root(  # type: ignore[call-overload]  # the stubs misspell maxfev
        mismatch, guess, method="hybr", tol=tolerance, options=options
    )
    return solution.x if np.abs(solution.fun).max() < 10 * tolerance else None


def _follow_branch(model: _Model, slope: float) -> Array:
    """The scaled gait on a slope, found by following the gaits from level ground.

    The scaled gait is smooth in slope^(2/3), in which the steps are taken; one counts only if the gait found is close
    to the one extrapolated, so that the search does not slip onto the other family (the "short" gaits).
    """
    if model.pull[0] >= 0.0:
        raise no_gait(slope, "on feet as large as these the robot stands and does not fall forward; make them smaller")
    places, gaits, step = [0.0], [_level_limit(model)], 1 / 256
    for _ in range(MOST_PLACES):
        if places[-1] >= 1:
            break
        place = places[-1] + min(step, 1 - places[-1])
        guess = np.asarray(scipy.interpolate.KroghInterpolator(places[-3:], gaits[-3:])(place))
        found = _solve(model, slope * place**1.5, guess, STEPS // 3, 1e-7)
        if found is not None and (np.abs(found - guess) < 0.01 * (1 + np.abs(guess))).all():
            places.append(place)
            gaits.append(found)
            step *= 3
        else:
            step /= 2
        gait = gaits[-1]
        limit = math.degrees(slope * places[-1] ** 1.5)
        if gait[1] + gait[2] <= 0:
            raise no_gait(slope, f"at {limit:.3g} degrees the trailing foot already stays down; choose a gentler slope")
        if step < 1e-5 and len(gaits) == 1:
            raise no_gait(slope, "none leaves level ground; check the robot's lengths, masses and inertia")
        if step < 1e-5:
            raise no_gait(slope, f"the gaits from level ground end at {limit:.4g} degrees; choose a gentler slope")
    else:
        raise no_gait(slope, "the search finds no end; choose a gentler slope")
    polished = _solve(model, slope, gaits[-1], STEPS, 1e-12)
    if polished is None:
        raise no_gait(slope, "the search did not converge; choose a gentler slope")
    return polished


def _level_limit(model: _Model) -> Array:
    """The scaled gait in the limit of level ground, shape (4,)."""
    eigenvalues, modes = scipy.linalg.eigh(np.diag(model.pull), model.mass)
    fall, swing = math.sqrt(-eigenvalues[0]), math.sqrt(eigenvalues[1])  # rates of sinh and sin, 1/s
    together, apart = modes.sum(axis=0), modes[0] - modes[1]

    def condition(half: float) -> float:
        """Zero if some odd motion has q1 + q2 = 0 and dq1 = dq2 at `half` a period after mid-stance."""
        falling = together[0] * apart[1] * math.tanh(fall * half) / fall * math.cos(swing * half)
        return float(falling - together[1] * apart[0] * math.sin(swing * half) / swing)

    grid = (np.linspace(0.01, 2, 200) * math.pi / swing).tolist()
    bracket = next((x, y) for x, y in pairwise(grid) if condition(x) * condition(y) <= 0)  # one at pi..2 pi at least
    half = float(scipy.optimize.brentq(condition, *bracket, xtol=1e-14))
    # of that motion, the ratio of the rate to the stance angle at touchdown
    part1 = together[1] * modes[0, 0] * fall / math.tanh(fall * half)
    part2 = together[0] * modes[0, 1] * swing / math.tan(swing * half)
    growth = float((part1 - part2) / np.linalg.det(modes))
    # the slope makes good the impact's loss, which is of fourth order in the angle: any small angle will do
    q, dq = 1e-2, 1e-2 * growth
    loss = model.energy(q, -q, dq, dq) - model.energy(-q, q, *model.strike(q, -q, dq, dq))
    slope = loss / (model.weight * 2 * _TABLE_ONE.leg_length * q)
    return np.array([-q, dq, dq, 2 * half]) / _scales(slope)


def _check(model: _Model, slope: float, start: Array, period: float) -> None:
    """Refuse a closed orbit whose swing foot, once ahead of the stance foot, meets the ground before the period's end.

    The scuffing behind and beside the stance foot, which straight legs cannot avoid, is ignored (eq. 4).
    """
    states = _motion(model, slope, start, period, 4 * STEPS)
    lean, spread = states[:, 0] + states[:, 1], states[:, 0] - states[:, 1]  # H = -2 sin(lean / 2) sin(spread / 2)
    early = (lean[:-2] < 0) & (lean[1:-1] >= 0) & (spread[1:-1] > 0)
    if start[0] >= 0 or spread[-1] <= 0 or lean[-2] >= 0 or early.any():
        raise no_gait(slope, "the swing foot does not land ahead of the stance foot; choose a gentler slope")


def _return_map_jacobian(model: _Model, slope: float, scaled: Array) -> Array:
    """Jacobian of the return map of the scaled (q1, dq1, dq2), shape (3, 3)."""
    # the differences' truncation ~1e-12, the integration's noise ~1e-11
    jacobian = differences(lambda shift: _step(model, slope, scaled + shift, STEPS), 4, 1e-3)
    # the touchdown's time follows from the condition q1 + q2 = 0, the first row
    result: Array = jacobian[1:, :3] - np.outer(jacobian[1:, 3], jacobian[0, :3]) / jacobian[0, 3]
    return result


def _tabulate(model: _Model, slope: float, start: Array, period: float) -> tuple[float, Array]:
    """The motion from `start` in pieces of degree 9, twice continuously differentiable.

    Each piece matches q and dq at its ends and thirds, and ddq at its ends. The pieces are halved until the equations
    of motion hold in their middles to 1e-10 g/l.

    Returns:
        Pieces per second, and their coefficients, as `table_of` takes them.
    """
    powers = np.arange(10)
    values = np.array([0, 1 / 3, 2 / 3, 1])[:, None] ** powers
    derivatives = np.hstack([np.zeros((4, 1)), powers[1:] * values[:, :-1]])
    seconds = np.hstack([np.zeros((4, 1)), powers[1:] * derivatives[:, :-1]])
    matrix = np.vstack([values, derivatives, seconds[::3]])
    law = _passive(model, slope)
    for count in (16, 32, 64, 128, 256, 512, 1024):
        width = period / count
        states = _motion(model, slope, start, 2 * period, 6 * count)
        fallen = np.abs(states[::3, 0]) >= FALLEN
        length = int(np.argmax(fallen)) - 1 if fallen.any() else 2 * count
        q, dq = states[:, :2], width * states[:, 2:]
        ddq = width**2 * np.array([law(state)[2:] for state in states[: 3 * length + 1]])
        known = [np.vstack([q[k : k + 4], dq[k : k + 4], ddq[k : k + 4 : 3]]) for k in range(0, 3 * length, 3)]
        coefficients = np.linalg.solve(matrix, np.hstack(known)).reshape(10, length, 2).swapaxes(0, 1)
        table = table_of(1 / width, coefficients)
        middles = np.array([motion_at(table, (k + 0.5) * width) for k in range(length)])
        defects = np.array([law(state) for state in middles[:, :4]]) - middles[:, 2:]
        if np.abs(defects).max() < 1e-10 * _TABLE_ONE.gravity / _TABLE_ONE.leg_length:
            return 1 / width, coefficients
    raise no_gait(slope, "its trajectory is too fast to tabulate; check the robot's lengths and masses")
