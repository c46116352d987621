"""Passive gaits of bipeds in space: one step and its mirror image are one gait.

A step begins just after a heel strike, with both feet on the plane. Its start is (q_1, roll, dq_1, dq_2, droll): the
swing leg's angle follows, for both feet are on the ground. The search begins at the planar gait of the same legs, with
the roll that an upright body falls into between two steps, and sets the legs apart by and by.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from mjbiped.errors import GaitError
from mjbiped.gaits import store
from mjbiped.gaits.cycle import FINEST, differences, eigenvalues, glide, no_gait
from mjbiped.gaits.kneed import EARLY, ON, KneedGait, find_kneed_gait
from mjbiped.gaits.passive import PassiveGait, check_walker, checked_slope, find_passive_gait
from mjbiped.gaits.reference import closing_on, count_of_pieces, hold, in_pieces, table_of
from mjbiped.robots.in_space import InSpace, pull_of
from mjbiped.robots.space import Array, SpatialLinkage, joined

_LONGEST = 3.0  # s: steps take one
_SHARES = ((1.0,), (0.25, 0.5, 0.75, 1.0))  # of the hip's width, for which gaits are found one after the other
_WIDTH = 1e-5  # of the differences of multipliers: their error is some 1e-8

Motion = Callable[[float, Array], Sequence[float]]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class KneedGaitInSpace(KneedGait):
    """A passive gait with knees in space, made by `find_gait_in_space`."""

    @property
    def feet(self) -> Array:
        """Place of the swing foot from the stance foot, along the ground and its normal, shape (SAMPLES, 2), m."""
        return np.array([self.robot.swing_foot(q)[[0, 2]] for q in self.angles])


def find_gait_in_space(robot: InSpace, slope: float) -> PassiveGait:
    """The passive gait of period one of a biped in space, on a plane that falls along the heading.

    Its multipliers are five, of angles and rates just after a heel strike. One of the lateral ones is far outside the
    unit circle: nothing holds the roll (Kuo 1999).

    Args:
        robot: A biped in space.
        slope: Slope of the plane, rad, > 0 (downhill).

    Raises:
        InputError: The slope is no number within a right angle of level, or the robot does not walk in space.
        GaitError: There is no such gait near the planar one.
    """
    check_walker(robot, InSpace)  # type: ignore[type-abstract]  # no object of it is made
    kind = KneedGaitInSpace if "knee" in robot.joints else PassiveGait
    found: PassiveGait = store.passive(kind, robot, checked_slope(slope), _search)
    return found


def _search(robot: InSpace, slope: float) -> dict[str, Any]:
    """The attributes of the gait near the planar one."""
    flat: Any = robot.planar
    planar = find_kneed_gait(flat, slope) if "knee" in flat.joints else find_passive_gait(flat, slope)
    q1, rates, half = planar.start[0], planar.start[[len(planar.start) // 2, len(planar.start) // 2 + 1]], 0.5
    roll_rate = half * robot.hip_width * robot.falling * math.tanh(half * robot.falling * planar.period)
    roll_rate /= robot.leg_length
    for shares in _SHARES:
        places = np.array([q1, 0.0, *rates, shares[0] * roll_rate])
        for number, share in enumerate(shares):
            narrow = robot if share == 1.0 else robot.set_apart(share * robot.hip_width)
            places[[1, 4]] *= share / shares[max(number - 1, 0)]
            repeated = _limit_cycle(narrow, slope, places)
            if repeated is None:
                break
            places = repeated
        else:
            return _attributes(robot, slope, places)
    raise no_gait(slope, "none is near that of the planar robot; choose another slope, or a narrower hip")


def _limit_cycle(robot: InSpace, slope: float, guess: Array) -> Array | None:
    """The start near a guess that repeats itself; None where there is none."""

    def mismatch(places: Array) -> Array:
        try:
            return np.asarray(step(robot, slope, places)[0] - places)
        except GaitError:
            return np.full(5, 10.0)  # far from any walking: turn back

    solution = scipy.optimize.root(mismatch, guess, tol=1e-12, options={"eps": 1e-10})
    return solution.x if np.abs(solution.fun).max() < 1e-9 else None


def _attributes(robot: InSpace, slope: float, places: Array) -> dict[str, Any]:
    """What a store keeps of the gait of a start that repeats itself."""
    _, times, end = step(robot, slope, places)
    straight = robot.in_space[2]
    jacobian = differences(lambda shift: step(robot, slope, places + shift)[0], 5, _WIDTH)
    start = start_of(straight, places)
    found = {
        "start": robot.spread(start),
        "end": robot.spread(end),
        "period": sum(times),
        "step_length": float(straight.swing_foot(end[:3])[0]),
        "multipliers": eigenvalues(jacobian),
    }
    if len(times) == 1:
        return {**found, "table": _table(robot, slope, start, times[0])}
    bent, locked = _tables(robot, slope, start, times)
    return {**found, "knee_strike": times[0], "bent": bent, "straight": locked}


def _table(robot: InSpace, slope: float, start: Array, period: float) -> list[float]:
    """The trajectory of straight legs, continued as those with knees."""
    count = count_of_pieces(period, robot.leg_length, robot.gravity)
    width, law = period / count, free_motion(robot.in_space[2], pull_of(slope))
    moved = glide(law, start, period, precision=FINEST).sol
    end = moved(period)
    walking = in_pieces(lambda place: moved(width * place)[:3].T, range(count))
    late = _going_on(end, np.array(law(0.0, end)[3:]), width, count)
    return table_of(1.0 / width, np.concatenate([walking, late]) @ robot.knee_lock.T)


def _tables(robot: InSpace, slope: float, start: Array, times: Sequence[float]) -> tuple[list[float], list[float]]:
    """The trajectories of the bent and of the straight knee, continued as those of `mjbiped.gaits.kneed.KneedGait`."""
    pull, strike, period = pull_of(slope), times[0], sum(times)
    count = count_of_pieces(period, robot.leg_length, robot.gravity)
    width = period / count
    free, locked = (free_motion(robot.in_space[n], pull) for n in (3, 2))
    bent_until = min(math.ceil((strike + ON * period) / width), count)
    bent = glide(free, robot.spread(start), bent_until * width, precision=FINEST).sol
    state = bent(strike)
    struck = np.append(robot.straightened(state[:4]), joined(robot.in_space[3], robot.knee_lock, state[:4], state[4:]))
    ahead = glide(locked, struck, period - strike, precision=FINEST).sol
    back_until = math.floor(EARLY * strike / width)
    back = glide(locked, struck, back_until * width - strike, precision=FINEST).sol

    def straight(place: Array) -> Array:
        return np.array([(ahead if t >= strike else back)(t - strike)[:3] for t in width * place])

    first, end, last = back(back_until * width - strike), ahead(period - strike), bent(bent_until * width)
    early = in_pieces(lambda place: first[:3] + first[3:] * (width * (place - back_until))[:, None], range(back_until))
    late = _going_on(end, np.array(locked(0.0, end)[3:]), width, count)
    straight_pieces = np.concatenate([early, in_pieces(straight, range(back_until, count)), late])
    moved = in_pieces(lambda place: bent(width * place)[:4].T, range(bent_until))
    later = _going_on(last, np.array(free(0.0, last)[4:]), width, len(straight_pieces) - bent_until)
    return table_of(1.0 / width, np.concatenate([moved, later])), table_of(1.0 / width, straight_pieces)


def _going_on(state: Array, ddq: Array, width: float, most: int) -> Array:
    """How a reference goes on: pieces of all angles, shape (pieces, 10, n); see `mjbiped.gaits.reference.hold`."""
    n = len(ddq)
    legs = hold(state[:2], state[n : n + 2], ddq[:2], width, most)
    roll = closing_on(state[n - 1], state[-1], ddq[-1], width, len(legs))[..., None]
    if n == 3:
        return np.concatenate([legs, roll], axis=-1)
    flexion, rate, acceleration = (float(part[2] - part[1]) for part in (state, state[n:], ddq))
    shank = legs[..., 1:] + closing_on(flexion, rate, acceleration, width, len(legs))[..., None]
    return np.concatenate([legs, shank, roll], axis=-1)


def start_of(linkage: SpatialLinkage, places: Array) -> Array:
    """Angles and rates of straight legs with both feet on the plane, shape (6,), of (q_1, roll, dq_1, dq_2, droll)."""
    q1, roll, *rates = places.tolist()
    cosine = math.cos(q1) + linkage.width * math.tan(roll) / linkage.foot[0]
    return np.array([q1, math.acos(max(-1.0, min(1.0, cosine))), roll, *rates])


def places_of_start(robot: InSpace, start: Array) -> Array:
    """The places (q_1, roll, dq_1, dq_2, droll) of a state of all angles and rates just after a touchdown."""
    q, dq = (robot.straightened(part) for part in np.split(start, 2))
    return np.array([q[0], q[2], *dq])


def free_motion(linkage: SpatialLinkage, pull: Array) -> Motion:
    """The unpowered motion: a function from the state to its rates, for gravity's components `pull`."""
    n = len(linkage.foot) + 1
    idle = np.zeros(n)

    def rates(_: float, state: Array) -> Sequence[float]:
        return [*state[n:], *linkage.accelerations(idle, state[:n], state[n:], pull)]

    return rates


def step(robot: InSpace, slope: float, places: Array) -> tuple[Array, list[float], Array]:
    """One unpowered step.

    Args:
        robot: The robot.
        slope: Slope of the plane, rad.
        places: Its start, see the module.

    Returns:
        The next start, the durations of the parts of the step (s), and the state of straight legs at its end.

    Raises:
        GaitError: There is no such step.
    """
    straight, pull, times = robot.in_space[2], pull_of(slope), list[float]()
    state = start_of(straight, places)
    if "knee" in robot.joints:
        free = robot.in_space[3]
        duration, bent = _until(free, pull, robot.spread(state), lambda y: y[2] - y[1])
        state = np.append(robot.straightened(bent[:4]), joined(free, robot.knee_lock, bent[:4], bent[4:]))
        times.append(duration)
    else:
        passed, state = _until(straight, pull, state, lambda y: y[1] - y[0])
    duration, end = _until(straight, pull, state, lambda y: float(straight.swing_foot(y[:3])[2]))
    times.append(duration if "knee" in robot.joints else passed + duration)
    q, dq = straight.touchdown(end[:3], end[3:])
    return np.array([q[0], q[2], *dq]), times, end


def _until(linkage: SpatialLinkage, pull: Array, start: Array, ends: Callable[[Array], float]) -> tuple[float, Array]:
    """Duration of the motion until a function falls through zero, s, and the state there.

    Raises:
        GaitError: The function does not.
    """
    solution = glide(free_motion(linkage, pull), start, _LONGEST, (lambda _, y: ends(y),), FINEST, between=False)
    if not solution.t_events[0].size:
        raise GaitError("the step does not end")
    return float(solution.t_events[0][0]), solution.y_events[0][0]
