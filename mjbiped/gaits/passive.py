"""Passive gaits: the limit cycle of the unpowered robot on a gentle slope (eq. 28), its stability and its trajectory.

Those of straight legs are found along the branch of gaits that leaves level ground. There, at slope -> 0, the gait is
known: angles and rates shrink like slope^(1/3), the motion about mid-stance is the odd solution of the linearised
equations whose legs have equal rates at touchdown, and the energy lost at the impact sets the slope. That holds for
every mass distribution, so that no guess, and no other robot's gait, is needed. docs/model.md gives the formulas. The
start of a rimless wheel's steady rolling is known in closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.errors import GaitError, InputError
from mjbiped.gaits import store
from mjbiped.gaits.cycle import (
    COARSE,
    FINEST,
    attributes,
    free_motion,
    glide,
    limit_cycle,
    no_gait,
    part_of,
    step,
    unit_of,
    upright_modes,
)
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.reference import FALLEN, motion_at, table_of
from mjbiped.robots.compass import Compass
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.robot import Array, Robot
from mjbiped.robots.round import RimlessWheel, RoundCompass
from mjbiped.utils import domains

MOST_PLACES = 60  # greatest number of slopes on the way from level ground to the final one; 5 to 50 are usual


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class PassiveGait(Gait):
    """A passive gait of period one; its slope is positive.

    Without knees the trajectory is the passive motion (eq. 28), continued beyond the period for a late touchdown: up to
    two periods, or until the stance leg has fallen 60 degrees from the normal.

    Attributes:
        multipliers: Floquet multipliers, the eigenvalues of the return map's Jacobian; complex, shape (3,), the largest
            magnitude first; six digits or better. A wheel has one, of the rate after impacts, shape (1,).
    """

    multipliers: NDArray[np.complex128]

    def __repr__(self) -> str:
        """Return a summary in one line."""
        kind = "stable" if self.stable else "unstable"
        return (
            f"<{type(self).__name__} on {math.degrees(self.slope):.4g} deg: {kind}, period {self.period:.6g} s, "
            f"step {self.step_length:.6g} m>"
        )

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out: every multiplier lies inside the unit circle."""
        return bool(abs(self.multipliers[0]) < 1)

    @property
    def energy(self) -> float:
        """Kinetic plus potential energy about the stance foot just after a heel strike, J; constant without knees."""
        half = len(self.robot.angles)
        return float(self.robot.energy(self.start[:half], self.start[half:], self.slope))


def find_passive_gait(robot: Compass | RoundCompass, slope: float) -> PassiveGait:
    """The passive gait of period one on a plane (equation 28), stable or not.

    Where several gaits exist, it is the one whose swing leg swings out and comes back (the "long" gait), on the branch
    that leaves level ground. The robot of Table I has such gaits to beyond 20 degrees, stable ones up to 2.728; with
    all mass of the legs near the hip they end much earlier. Results are kept in the user's cache folder, or where the
    environment variable MJBIPED_CACHE_DIR says.

    Args:
        robot: Any compass biped, on point feet or on round ones.
        slope: Slope of the plane, rad, > 0 (downhill).

    Raises:
        InputError: The slope is no number within a right angle of level, or the robot is no compass biped.
        GaitError: The robot has no such gait on that slope.
    """
    check_walker(robot, Compass, RoundCompass)
    found: PassiveGait = store.passive(PassiveGait, robot.flat, checked_slope(slope), _search)
    return found


def check_walker(robot: object, *kinds: type[Robot]) -> None:
    """Check that a function which finds passive gaits is asked about a robot of one of its kinds.

    Raises:
        InputError: The robot is of another kind; the message names the functions for each kind.
    """
    if not isinstance(robot, kinds) or isinstance(robot, InSpace) != issubclass(kinds[0], InSpace):
        raise InputError(
            f"robot: got a {type(robot).__name__}; mjbiped.find_passive_gait takes straight legs in the plane, "
            "find_kneed_gait takes knees in the plane, find_gait_in_space takes a Compass3D or a Kneed3D"
        )


def checked_slope(slope: float) -> float:
    """Check the slope of a passive gait, rad.

    Raises:
        InputError: It is no number within a right angle of level.
        GaitError: It does not lead downhill.
    """
    slope = domains.SLOPE.check("slope", slope)
    if slope < domains.DOWNHILL.low:
        raise no_gait(slope, "without torques the robot walks only downhill; give a slope above 0")
    return slope


def _search(robot: Robot, slope: float) -> dict[str, Any]:
    """The attributes of the gait on the branch that leaves level ground."""
    places = _follow_branch(robot, slope)
    try:
        found = attributes(robot, slope, places, step(robot, slope, places))
    except GaitError:
        raise no_gait(
            slope, "the gait is too unstable to be computed; check the robot's lengths, masses and inertia"
        ) from None
    return {**found, "table": _tabulated(robot, slope, found["start"], found["period"], 2)}


def _follow_branch(robot: Robot, slope: float) -> Array:
    """The start of the gait on a slope, found by following the gaits from level ground.

    The start, divided by the slope's cube root, is smooth in slope^(2/3), by which the search proceeds. A gait counts
    only if it is close to the extrapolated one, so that the search does not slip onto the other family (the "short"
    gaits).
    """
    places, gaits, width = [0.0], [_level_limit(robot, slope)], 1 / 256
    for _ in range(MOST_PLACES):
        if places[-1] >= 1:
            break
        place = places[-1] + min(width, 1 - places[-1])
        guess = np.asarray(scipy.interpolate.KroghInterpolator(places[-3:], gaits[-3:])(place))
        size = math.cbrt(slope * place**1.5)
        found = limit_cycle(robot, slope * place**1.5, size * guess, COARSE)
        if found is not None and (np.abs(found / size - guess) < 0.01 * (1 + np.abs(guess))).all():
            places.append(place)
            gaits.append(found / size)
            width *= 3
        else:
            width /= 2
        limit = math.degrees(slope * places[-1] ** 1.5)
        if gaits[-1][1] + gaits[-1][2] <= 0:
            raise no_gait(slope, f"at {limit:.3g} degrees the trailing foot already stays down; choose a gentler slope")
        if width < 1e-5 and len(gaits) == 1:
            raise no_gait(slope, "none leaves level ground; check the robot's lengths, masses and inertia")
        if width < 1e-5:
            raise no_gait(slope, f"the gaits from level ground end at {limit:.4g} degrees; choose a gentler slope")
    else:
        raise no_gait(slope, "the search finds no end; choose a gentler slope")
    polished = limit_cycle(robot, slope, math.cbrt(slope) * gaits[-1])
    if polished is None:
        raise no_gait(slope, "the search did not converge; choose a gentler slope")
    return polished


def _level_limit(robot: Robot, slope: float) -> Array:
    """The start over the slope's cube root in the limit of level ground."""
    chain, unit, (squares, modes) = robot.chains[2], unit_of(robot), upright_modes(robot)
    if squares[0] >= 0.0:
        raise no_gait(slope, "on feet as large as these the robot stands and does not fall forward; make them smaller")
    fall, swing = unit * math.sqrt(-squares[0]), unit * math.sqrt(squares[1])  # rates of sinh and sin
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
    # on the slope gravity restores the impact's loss, which is of fourth order in the angle: any small angle serves
    q, dq = np.array([1e-2, -1e-2]), np.full(2, 1e-2 * growth)
    loss = chain.kinetic_energy(q, dq) - chain.kinetic_energy(q[::-1], robot.rates_after_touchdown(q, dq))
    ratio = math.cbrt(loss / unit**2 / (robot.weight * 2 * robot.leg_length * q[0]))
    if not ratio > 0.0:  # the loss is no more than rounding of the energy
        raise no_gait(slope, "none leaves level ground; check the robot's lengths, masses and inertia")
    return np.array([-q[0], *dq]) / ratio


def _tabulated(robot: Robot, slope: float, start: Array, period: float, periods: int) -> list[float]:
    """The table of the motion from a start over some periods, or until the stance leg has fallen.

    Its pieces, polynomials of degree 9, match q and dq at their ends and thirds, and ddq at their ends. They are halved
    until the equations of motion hold in their middles to 1e-10 g/l.
    """
    n, unit, powers = len(start) // 2, unit_of(robot), np.arange(10)
    values = np.array([0, 1 / 3, 2 / 3, 1])[:, None] ** powers
    derivatives = np.hstack([np.zeros((4, 1)), powers[1:] * values[:, :-1]])
    seconds = np.hstack([np.zeros((4, 1)), powers[1:] * derivatives[:, :-1]])
    matrix = np.vstack([values, derivatives, seconds[::3]])
    law, scale = free_motion(robot.chains[n], slope, unit), np.repeat([1.0, unit], n)
    motion = glide(law, start * scale, periods * period / unit, precision=FINEST).sol
    for count in (16, 32, 64, 128, 256, 512, 1024):
        width = period / count / unit
        states = motion(width / 3 * np.arange(3 * periods * count + 1)).T
        fallen = np.abs(states[::3, 0]) >= FALLEN
        length = int(np.argmax(fallen)) - 1 if fallen.any() else periods * count
        q, dq = states[:, :n], width * states[:, n:]
        ddq = width**2 * np.array([law(0.0, state)[n:] for state in states[: 3 * length + 1]])
        known = [np.vstack([q[k : k + 4], dq[k : k + 4], ddq[k : k + 4 : 3]]) for k in range(0, 3 * length, 3)]
        table = table_of(
            count / period, np.linalg.solve(matrix, np.hstack(known)).reshape(10, length, n).swapaxes(0, 1)
        )
        middles = np.array([motion_at(table, (k + 0.5) * width * unit) for k in range(length)])
        wanted = np.array([law(0.0, each[: 2 * n] * scale)[n:] for each in middles])
        if np.abs(unit**2 * middles[:, 2 * n :] - wanted).max() < 1e-10:
            return table
    raise no_gait(slope, "its trajectory is too fast to tabulate; check the robot's lengths and masses")


def find_rolling(robot: RimlessWheel, slope: float) -> PassiveGait:
    """Find the steady rolling of a wheel down a slope, rad.

    Raises:
        InputError: The slope is outside its domain.
        GaitError: The wheel comes to a stop: on this slope gravity restores less than the impacts take.
    """
    slope, half, unit = domains.SLOPE.check("slope", slope), robot.between / 2, unit_of(robot)
    start = np.array([-half, robot.rolling_rate(slope)])
    try:
        rolled = part_of(robot, slope, start * [1.0, unit], lambda y: half - y[0], {})
    except GaitError:
        raise no_gait(
            slope, f"a wheel of {robot.spokes} spokes comes to a stop there; choose a steeper slope"
        ) from None
    period = rolled.duration * unit
    return PassiveGait(
        robot=robot,
        slope=slope,
        start=start,
        end=rolled.end / [1.0, unit],
        period=period,
        step_length=2 * robot.length * math.sin(half),
        tables=(_tabulated(robot, slope, start, period, 1),),
        multipliers=np.array([robot.kept**2], dtype=np.complex128),
    )
