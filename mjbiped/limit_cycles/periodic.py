"""Gaits of any period on a plane, stable or not, found by Newton's method on the return map and followed with slope.

A gait of period n repeats itself after n steps. Its n states after the impacts are solved for together (multiple
shooting), so that the equations stay as well conditioned for n = 16 as for n = 1.

All robots with two legs are followed alike, in the section of states just after an impact on a plane: both feet stand
on the plane and both legs are straight, so that q2 = -q1, and (q1, dq1, dq2) tell the whole state. Thigh and shank of
the swing leg move as one, or, where the heel strike can bend the knee, at rates that it links
(`Robot.after_touchdown`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from mjbiped.engines.checks import check_robot, check_rule
from mjbiped.errors import GaitError, InputError
from mjbiped.gaits.cycle import eigenvalues
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.gait import Gait
from mjbiped.limit_cycles.return_map import TOUCHDOWN, Plane, check_planar, plane_of, walk_all
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule, check_landing
from mjbiped.utils import domains

GUARD = ScuffingRule(reach=0.0, delay=0.0, name="eq. 4")
"""Touchdown of straight legs as `find_passive_gait` has it: whenever the swing foot comes down ahead."""

OFF = 1e-9
"""Sum of the legs' angles, rad, beyond which a state is off the section: it touched down with a bent knee."""

DIFFERENCE = 1e-4
"""Width of the fourth-order differences, in rad and sqrt(g/l): truncation is below 1e-8, rounding 1e-11."""

CONVERGED = 1e-11  # last change of Newton's method, in rad and sqrt(g/l)
LARGEST_CHANGE = 0.05  # rad and sqrt(g/l): a gait further from the one extrapolated may lie on another branch
SHORTEST_STEP = 1e-9  # shortest step of the slope, rad


def check_biped(robot: object) -> None:
    """Refuse what is no robot with two legs.

    Raises:
        InputError: It is no robot, it has no swing leg, or it moves in space.
    """
    check_robot("robot", robot)
    if isinstance(robot, Robot) and "swing" not in robot.angles:
        raise InputError(f"a {type(robot).__name__} has no swing leg; give a robot with two legs")
    if isinstance(robot, Robot):
        check_planar(robot)


def check_scuffing(gait: Gait, slope: float, rule: ScuffingRule) -> None:
    """Refuse a scuffing rule that would never let a gait land on a slope, rad, or for a robot that needs none.

    Raises:
        InputError: It is such a rule.
    """
    check_rule(gait.robot, rule)
    if not gait.robot.collides_from_lift_off:
        check_landing(gait, slope, rule)


def guard_of(robot: Robot) -> ScuffingRule:
    """The rule under which gaits are followed: that of eq. 4, or none where the foot collides from lift-off."""
    return ScuffingRule() if robot.collides_from_lift_off else GUARD


def places_of(states: Array) -> Array:
    """Components that tell states of shape (..., 2 n) with n angles: (q1, dq1, dq2), and the rate alone of a wheel."""
    angles = states.shape[-1] // 2
    return states[..., [0, angles, angles + 1] if angles > 1 else [1]]


def step_lengths(robot: Robot, states: Array) -> Array:
    """Distance between the feet just after impacts on a plane, m; states of shape (..., 2 n), NaN where these are."""
    q = states[..., : len(robot.angles)]
    lengths = np.full(q.shape[:-1], np.nan)
    known = np.isfinite(q).all(axis=-1)
    lengths[known] = -robot.swing_foot(q[known])[..., 0]
    return lengths


@dataclass(frozen=True)
class PeriodicGait:
    """A gait that repeats itself after n steps.

    Attributes:
        robot: The robot that walks.
        slope: Slope of the plane, rad.
        states: (q1, q2, dq1, dq2) after the impacts, with knees (q1, q2, q3, dq1, dq2, dq3), shape (n, 4) or (n, 6),
            rad and rad/s.
        periods: Time from each impact to the next, shape (n,), s.
        multipliers: Eigenvalues of the n-fold return map's Jacobian, complex, shape (3,), the largest magnitude first.
        doubling: det(I + Jacobian) of the n-fold map; it passes through zero where a multiplier passes through -1.
    """

    robot: Robot
    slope: float
    states: Array = field(compare=False)
    periods: Array = field(compare=False)
    multipliers: NDArray[np.complex128] = field(compare=False)
    doubling: float = field(compare=False)

    def __repr__(self) -> str:
        """Return a summary in one line."""
        kind = "stable" if self.stable else "unstable"
        return f"<PeriodicGait of period {len(self.states)} on {math.degrees(self.slope):.6g} deg: {kind}>"

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out."""
        return bool(abs(self.multipliers[0]) < 1.0)

    @property
    def step_lengths(self) -> Array:
        """Distances between the feet at the impacts, shape (n,), m."""
        return step_lengths(self.robot, self.states)


def differentiate(plane: Plane, places: Array, widths: Array) -> tuple[Array, Array, Array] | None:
    """Evaluate the return map in (q1, dq1, dq2) and its derivatives at points of shape (n, 3).

    Args:
        plane: Robot and plane.
        places: Points (q1, dq1, dq2), shape (n, 3).
        widths: Widths of the central differences of fourth order, shape (3,).

    Returns:
        The places mapped, shape (n, 3); the periods, shape (n,); the Jacobians, shape (n, 3, 3). None where the robot
        does not make its next step from one of the places or beside one, or lands with a bent knee.
    """
    shifts = np.concatenate([np.zeros((1, 3)), *(k * np.diag(widths) for k in (-2.0, -1.0, 1.0, 2.0))])
    around = (places[:, None, :] + shifts).reshape(-1, 3)
    batch = walk_all(plane, plane.robot.after_touchdown(around), 1)
    if (batch.outcomes != TOUCHDOWN).any() or np.abs(batch.states[:, 0, :2].sum(axis=1)).max() > OFF:
        return None
    mapped = places_of(batch.states[:, 0]).reshape(-1, 13, 3)
    far_behind, behind, ahead, far_ahead = (mapped[:, first : first + 3] for first in (1, 4, 7, 10))
    slopes = (far_behind - 8.0 * behind + 8.0 * ahead - far_ahead) / (12.0 * widths[:, None])
    return mapped[:, 0], batch.periods[::13, 0].copy(), np.swapaxes(slopes, 1, 2)


def find_periodic_gait(robot: Robot, slope: float, states: ArrayLike) -> PeriodicGait:
    """Find the gait of period n near n states, stable or not, by Newton's method.

    Args:
        robot: Any robot with two legs.
        slope: Slope of the plane, rad.
        states: (q1, q2, dq1, dq2) after n successive impacts, shape (n, 4), with knees (n, 6); q2 = -q1.

    Raises:
        InputError: The robot has no two legs, or the slope or the states have another shape or are not finite.
        GaitError: Newton's method does not converge, the gait found repeats itself sooner, or its trailing foot stays
            down after the impact.
    """
    check_biped(robot)
    angles = len(robot.angles)
    slope = domains.SLOPE.check("slope", slope)
    guess = domains.check_states("states", states, (None, 2 * angles))
    if not len(guess):
        raise InputError(f"states: expected shape (n, {2 * angles}) with at least one state, got none")
    places = places_of(guess)
    n = len(places)
    frequency = math.sqrt(robot.gravity / robot.leg_length)
    scales = np.array([1.0, frequency, frequency])
    plane = plane_of(robot, slope, guard_of(robot))
    for _ in range(20):
        known = differentiate(plane, places, DIFFERENCE * scales)
        if known is None:
            raise _lost(slope, n, "the robot falls or stalls on the way")
        results, periods, jacobians = known
        following = np.roll(np.eye(n), 1, axis=1)  # the state after each, and the first after the last
        matrix = scipy.linalg.block_diag(*jacobians) - np.kron(following, np.eye(3))
        mismatch = np.roll(places, -1, axis=0) - results
        change = np.linalg.solve(matrix, mismatch.ravel()).reshape(n, 3)
        places = places + change
        size = float(np.abs(change / scales).max())
        if size < CONVERGED:
            break
        if not size < 1.0:
            raise _lost(slope, n, "Newton's method leads away")
    else:
        raise _lost(slope, n, "Newton's method does not converge")
    if (places[:, 1] + places[:, 2] <= 0.0).any():
        raise _lost(slope, n, "the trailing foot stays down after the impact")
    if n > 1 and np.abs((places - np.roll(places, n // 2, axis=0)) / scales).max() < 1e-7:
        raise _lost(slope, n, "the gait found repeats itself sooner")
    whole = np.eye(3)
    for jacobian in jacobians:
        whole = jacobian @ whole
    found = robot.after_touchdown(places)
    return PeriodicGait(robot, slope, found, periods, eigenvalues(whole), float(np.linalg.det(np.eye(3) + whole)))


def first_gait(robot: Robot, slope: float) -> PeriodicGait:
    """The gait of period one that the finder of passive gaits finds for a robot, by the return map.

    Raises:
        InputError: The robot has no two legs, or the slope is not a finite number.
        GaitError: The robot has no such gait on that slope.
    """
    return find_periodic_gait(robot, slope, passive_gait_of(robot, slope).start[None])


def follow(gait: PeriodicGait, slopes: Sequence[float]) -> Iterator[PeriodicGait]:
    """Follow a gait to other slopes without a jump, stable or not, until its branch ends.

    Args:
        gait: The first gait of the branch.
        slopes: Slopes in the order in which they are reached, rad.

    Yields:
        One gait for each slope; fewer if the branch ends earlier.
    """
    known = [gait]
    for slope in slopes:
        step = slope - known[-1].slope
        while known[-1].slope != slope:
            there = slope if abs(slope - known[-1].slope) <= abs(step) else known[-1].slope + step
            found = _neighbour(known, there)
            if found is None:
                step /= 2
                if abs(step) < SHORTEST_STEP:
                    return
            else:
                known = [*known[-2:], found]
        yield known[-1]


def _neighbour(known: Sequence[PeriodicGait], slope: float) -> PeriodicGait | None:
    """The gait on a slope that continues known gaits; None where there is none near the one extrapolated."""
    states = extrapolated(known, slope)
    try:
        found = find_periodic_gait(known[-1].robot, slope, states)
    except (GaitError, np.linalg.LinAlgError):
        return None
    return found if np.abs(found.states - states).max() < LARGEST_CHANGE else None


def extrapolated(known: Sequence[PeriodicGait], slope: float) -> Array:
    """States on a slope, extrapolated by the polynomial through up to three gaits of one branch."""
    found = scipy.interpolate.KroghInterpolator([gait.slope for gait in known], [gait.states for gait in known])(slope)
    return np.asarray(found)


def zero_on_branch(
    below: PeriodicGait, above: PeriodicGait, value: Callable[[PeriodicGait], float], tolerance: float = 1e-12
) -> PeriodicGait:
    """Find the gait of a branch at which a value passes through zero, between two neighbouring gaits.

    Args:
        below: A gait for which the value has one sign.
        above: A gait for which it has the other sign.
        value: Function of a gait.
        tolerance: Tolerance of the slope, rad.

    Raises:
        GaitError: The branch cannot be followed from one to the other.
    """
    ends = (below, above)
    gaits = {gait.slope: gait for gait in ends}

    def at(slope: float) -> float:
        if slope not in gaits:
            nearest = sorted(gaits.values(), key=lambda gait: abs(gait.slope - slope))[:3]
            gaits[slope] = find_periodic_gait(below.robot, slope, extrapolated(nearest, slope))
        return value(gaits[slope])

    slope = float(scipy.optimize.brentq(at, below.slope, above.slope, xtol=tolerance, rtol=1e-14))
    at(slope)
    return gaits[slope]


def _lost(slope: float, n: int, reason: str) -> GaitError:
    return GaitError(f"no gait of period {n} found near these states at {math.degrees(slope):.6g} degrees: {reason}")
