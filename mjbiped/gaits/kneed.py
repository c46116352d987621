"""Passive gaits of the biped with knees: a finder, and the branches of gaits over the slope.

A step begins just after a heel impact, both feet on the plane and both legs straight. The stance knee stays locked. The
swing knee is free, bends, and strikes its stop; it locks, and the swing foot comes down. If the foot touches the ground
earlier, or the knee does not bend, there is no gait: unlike straight legs, legs with knees may not scuff.

A gait is a fixed point of the map from (q1, dq1, dq2) just after one heel impact to the next. SciPy integrates the
motion and finds the strikes, and finds the fixed point from starts on a grid that covers walkers of all kinds. Lengths
are measured in legs and times in sqrt(l/g), so that robots which are alike are searched alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.errors import GaitError
from mjbiped.gaits import store
from mjbiped.gaits.gait import Branched, Passive
from mjbiped.gaits.passive import checked_slope, differences, eigenvalues, no_gait
from mjbiped.gaits.pieces import FALLEN, FINE, free_motion, passive_branches
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.kneed_legs import KneedLegs
from mjbiped.robots.robot import Array
from mjbiped.robots.round_kneed import RoundKneed
from mjbiped.utils import domains

LONGEST = 10.0  # longest phase of a step, sqrt(l/g); steps take 2
COARSE = 1e-6  # tolerance of the integration of the grid's starts
STARTS = tuple(product((0.10, 0.16, 0.22, 0.28, 0.34), (1.25, 1.45, 1.65, 1.9), (0.0, 0.4, 0.8, 1.2)))
"""Half angle between the legs, rad, and the rates of stance and swing leg over it, in sqrt(g/l). Gaits of light and
heavy shanks on 1 to 5 degrees lie between them."""
ROLLING = tuple(product((0.20, 0.25, 0.30, 0.35, 0.40), (0.9, 1.05, 1.25), (-0.5, -0.2, 0.1, 0.4, 0.8)))
"""More of them for round feet, on which legs roll more slowly through greater angles."""
TRIED = 8  # number of starts that are refined: those that repeat themselves best
SAMPLES = 400  # samples of a gait's motion


@dataclass(frozen=True, repr=False)
class KneedGait(Passive, Branched):
    """A passive gait of period one of the biped with knees, made by `find_kneed_gait`.

    Angles and rates of three segments are those of stance leg, swing thigh and swing shank. Both branches are the
    gait's own motion, continued beyond the knee strike on either side by the same laws, so that no torque is asked for
    where the robot's knee strikes early or late. The bent knee's free motion goes on past the stop for a while; then it
    is driven on at its last closing rate, and the legs come to rest as after the period. The straight knee's motion is
    followed back.

    Attributes:
        knee_rates: Rates of the three segments just before the knee strike, shape (3,), rad/s.
        clearance: Least height of the swing foot over the middle half of its way, m.
        greatest_flexion: Greatest flexion of the swing knee, rad.
        multipliers: Floquet multipliers, the eigenvalues of the return map's Jacobian; complex, shape (3,), the largest
            magnitude first; five digits or better.
        times: Times of the samples, shape (n,), s; both sides of the knee strike are among them.
        states: States at these times, as `start`, shape (n, 6).
    """

    knee_rates: Array = field(compare=False)
    clearance: float
    greatest_flexion: float
    multipliers: NDArray[np.complex128] = field(compare=False)
    times: Array = field(compare=False)
    states: Array = field(compare=False)

    @property
    def bent_samples(self) -> int:
        """Number of samples before the knee strike; the next one is at the same time, after it."""
        return 1 + int(np.searchsorted(self.times, self.knee_strike))

    @property
    def feet(self) -> Array:
        """Place of the swing foot from the stance foot at `times`, along the ground and its normal, shape (n, 2), m."""
        return np.array([self.robot.swing_foot(q) for q in self.states[:, :3]])


def find_kneed_gait(robot: KneedLegs, slope: float) -> KneedGait:
    """A passive gait of period one on a plane, with knee strike and heel strike.

    Where the search finds several, it is a stable one, or else the least unstable. Results are kept in the user's
    cache folder, or where the environment variable MJBIPED_CACHE_DIR says.

    Args:
        robot: A biped with knees.
        slope: Slope of the plane, rad, > 0 (downhill).

    Raises:
        InputError: The slope is no number within a right angle of level, or the robot is no `KneedBiped`.
        GaitError: The search finds no gait on that slope.
    """
    if not isinstance(robot, RoundKneed):
        domains.check_kind("robot", robot, KneedBiped)
    return _find(robot, checked_slope(slope))


def follow_kneed_gaits(gait: KneedGait, to: float, step: float = math.radians(0.25)) -> Iterator[KneedGait]:
    """Follow a gait to gentler or steeper slopes, one after the other, until its branch ends.

    Near the end of a branch the steps become shorter, down to 0.002 degrees; a gait counts only if it lies close to the
    one extrapolated, so that the search does not slip onto another branch.

    Args:
        gait: The gait to begin with; it is not among the results.
        to: Last slope, rad, > 0.
        step: Difference of slopes, rad, > 0.
    """
    known = [(gait.slope, _scaled(gait.robot, gait.start))]
    goal, width = domains.DOWNHILL.check("to", to), domains.DOWNHILL.check("step", step)
    while abs(goal - known[-1][0]) > 1e-12 and width >= math.radians(0.002):
        slope = known[-1][0] + math.copysign(min(width, abs(goal - known[-1][0])), goal - known[-1][0])
        places, points = zip(*known[-2:], strict=True)
        guess = np.asarray(scipy.interpolate.KroghInterpolator(places, points)(slope))
        found = _solve(gait.robot, slope, guess)
        if found is not None and np.abs(_scaled(gait.robot, found.start) - guess).max() < 0.05:
            known.append((slope, _scaled(gait.robot, found.start)))
            yield found
        else:
            width /= 2


def _no_gait(slope: float, reason: str) -> GaitError:
    return no_gait(slope, reason, "passive gait with knees")


@lru_cache(maxsize=64)
def _find(robot: KneedLegs, slope: float) -> KneedGait:
    return KneedGait(robot, slope, **store.passive(robot, slope, _search))


def _search(robot: KneedLegs, slope: float) -> dict[str, Any]:
    """The attributes of the most stable gait found from the starts that repeat themselves best."""
    starts = []
    for half, stance, swing in STARTS + ROLLING if robot.radius else STARTS:
        scaled = np.array([-half, half * stance, half * swing])
        try:
            miss = np.abs(_step(robot, slope, scaled, COARSE).after - scaled).max() / half
        except GaitError:
            continue
        starts.append((float(miss), scaled))
    gaits: list[KneedGait] = []
    for _, scaled in sorted(starts, key=lambda each: each[0])[:TRIED]:
        found = _solve(robot, slope, scaled)
        if found is None or any(np.abs(_scaled(robot, found.start - gait.start)).max() < 1e-6 for gait in gaits):
            continue
        gaits.append(found)
        if found.stable:
            break
    if not gaits:
        raise _no_gait(
            slope, "the search found none; try another slope, lighter shanks, or a higher centre of mass of the shank"
        )
    best = min(gaits, key=lambda gait: abs(gait.multipliers[0]))
    return {name: value for name, value in vars(best).items() if name not in ("robot", "slope")}


_Event = Callable[[float, Array], float]


class _Phase(NamedTuple):
    """Part of a step: its duration, the state at its end, and the solution in between if it was asked for."""

    duration: float
    end: Array
    motion: Any


class _Step(NamedTuple):
    """One step: both phases, and the scaled start of the next step."""

    free: _Phase
    locked: _Phase
    after: Array


def _unit(robot: KneedLegs) -> float:
    return math.sqrt(robot.leg_length / robot.gravity)


def _scaled(robot: KneedLegs, start: Array) -> Array:
    """(q1, dq1, dq2) of a start, rates times sqrt(l/g)."""
    return np.array([start[0], _unit(robot) * start[3], _unit(robot) * start[4]])


def _start(robot: KneedLegs, scaled: Array) -> Array:
    return robot.after_touchdown(scaled / [1.0, _unit(robot), _unit(robot)])


def _phase(
    robot: KneedLegs, slope: float, start: Array, end: _Event, others: dict[str, _Event], tolerance: float, dense: bool
) -> _Phase:
    """Integrate the motion from a start until `end` falls through zero.

    Raises:
        GaitError: One of the others does so before, or nothing does.
    """
    events: list[Any] = [end, *others.values()]
    for event in events:
        event.terminal, event.direction = True, -1
    chain, unit = robot.chains[len(start) // 2], _unit(robot)
    with np.errstate(all="ignore"):  # a start that leads nowhere
        solution: Any = scipy.integrate.solve_ivp(
            free_motion(chain, slope),
            (0.0, LONGEST * unit),
            start,
            method="DOP853",
            rtol=tolerance,
            atol=tolerance,
            events=events,
            max_step=0.1 * unit,  # so that no strike is stepped over
            dense_output=dense,
        )
    if not solution.t_events[0].size:
        happened = [name for name, times in zip(others, solution.t_events[1:], strict=True) if times.size]
        raise _no_gait(slope, happened[0] if happened else "the step does not end")
    return _Phase(float(solution.t_events[0][0]), solution.y_events[0][0], solution.sol)


def _step(robot: KneedLegs, slope: float, scaled: Array, tolerance: float = FINE, dense: bool = False) -> _Step:
    """The step from a start, by way of the knee strike.

    Raises:
        GaitError: There is none.
    """
    three, two = robot.chains[3], robot.chains[2]
    falls: dict[str, _Event] = {"the robot falls": lambda _, y: FALLEN - abs(float(y[0]))}
    scuffs: dict[str, _Event] = {
        "the swing foot touches the ground before the knee is straight": lambda _, y: float(three.end(y[:3])[1])
    }
    start = _start(robot, scaled)
    free = _phase(robot, slope, start, lambda _, y: float(y[2] - y[1]), scuffs | falls, tolerance, dense)
    if free.duration < 1e-3 * _unit(robot):
        raise _no_gait(slope, "the knee does not bend")
    struck = np.concatenate(robot.knee_impact(free.end[:3], free.end[3:]))
    locked = _phase(robot, slope, struck, lambda _, y: float(two.end(y[:2])[1]), falls, tolerance, dense)
    if locked.end[0] <= locked.end[1]:
        raise _no_gait(slope, "the swing foot lands behind the stance foot")
    q, dq = robot.heel_impact(locked.end[:2], locked.end[2:])
    return _Step(free, locked, np.array([q[0], *(_unit(robot) * dq[:2])]))


def _solve(robot: KneedLegs, slope: float, guess: Array) -> KneedGait | None:
    """The gait whose scaled start is near `guess`, by SciPy's root finder; None where there is none."""

    def mismatch(scaled: Array) -> Array:
        try:
            difference: Array = _step(robot, slope, scaled).after - scaled
        except GaitError:
            return np.full(3, 10.0)  # far from any walking: turn back
        return difference

    # eps: relative differences of 1e-5, for the integration's noise is 1e-11
    solution = scipy.optimize.root(mismatch, guess, method="hybr", tol=1e-11, options={"eps": 1e-10})
    if np.abs(solution.fun).max() > 1e-9:
        return None
    try:
        return _described(robot, slope, solution.x)
    except GaitError:
        return None


def _described(robot: KneedLegs, slope: float, scaled: Array) -> KneedGait:
    """The gait with a scaled start that repeats itself."""
    step = _step(robot, slope, scaled, dense=True)
    (strike, struck, free), (locked_time, end, locked) = step.free, step.locked
    period, start = strike + locked_time, _start(robot, scaled)
    share = round(SAMPLES * strike / period)
    bent, straight = np.linspace(0, strike, share), np.linspace(0, locked_time, SAMPLES - share)
    legs = locked(straight).T
    states = np.concatenate([free(bent).T, legs[:, [0, 1, 1, 2, 3, 3]]])
    knee = np.concatenate(robot.knee_impact(states[share - 1, :3], struck[3:]))
    rate, bent_pieces, straight_pieces = passive_branches(robot, slope, start, knee, strike, period)
    feet = np.array([robot.swing_foot(q) for q in states[:, :3]])
    if feet[1:-1, 1].min() <= 0:  # so shallowly that the integration stepped over it
        raise _no_gait(slope, "the swing foot dips into the ground")
    # a round stance foot has rolled
    step_length = float(robot.swing_foot(end[:2])[0] + robot.radius * (end[0] - start[0]))
    # truncation ~1e-9 for maps as curved as these, noise ~1e-7
    jacobian = differences(lambda shift: _step(robot, slope, scaled + shift).after, 3, 1e-4)
    return KneedGait(
        robot=robot,
        slope=slope,
        start=start,
        end=end[[0, 1, 1, 2, 3, 3]],
        period=period,
        step_length=step_length,
        knee_strike=strike,
        rate=rate,
        bent=bent_pieces,
        straight=straight_pieces,
        knee_rates=struck[3:].copy(),
        clearance=float(feet[np.abs(feet[:, 0]) < step_length / 2, 1].min()),
        greatest_flexion=float((states[:, 2] - states[:, 1]).max()),
        multipliers=eigenvalues(jacobian),
        times=np.concatenate([bent, strike + straight]),
        states=states,
    )
