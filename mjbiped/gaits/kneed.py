"""Passive gaits of the biped with knees: found, followed over slopes, and how fast disturbances die out.

A step begins just after a heel impact, both feet on the plane and both legs straight. The stance knee stays locked. The
swing knee is free, bends, and strikes its stop; it locks, and the swing foot comes down. Where it touches the ground on
the way, or the knee does not bend, there is no gait: no scuff is passed through, as it has to be with straight legs.

A gait is a fixed point of the map from (q1, dq1, dq2) just after one heel impact to the next. SciPy integrates the
motion and finds the strikes, and finds the fixed point from starts on a grid that covers walkers of all kinds. Lengths
are measured in legs and times in sqrt(l/g), so that robots which are alike are searched alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.errors import GaitError
from mjbiped.gaits.branches import FINE, Branched, Branches, free_motion, passive_branches
from mjbiped.gaits.passive import eigenvalues
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains

FALLEN = math.radians(60)  # a stance leg so far from the normal does not come back
LONGEST = 10.0  # no phase of a step takes longer, sqrt(l/g); steps take 2
COARSE = 1e-6  # tolerance of the integration of the grid's starts; of gaits it is `FINE`
STARTS = tuple(product((0.10, 0.16, 0.22, 0.28, 0.34), (1.25, 1.45, 1.65, 1.9), (0.0, 0.4, 0.8, 1.2)))
"""Half angle between the legs, rad, and the rates of stance and swing leg over it, in sqrt(g/l). Gaits of light and
heavy shanks on 1 to 5 degrees lie between them."""
TRIED = 8  # of these starts, those that repeat themselves best
SAMPLES = 400  # of a gait's motion


@dataclass(frozen=True)
class KneedGait(Branched):
    """A passive gait of period one of the biped with knees, made by `find_kneed_gait`.

    Angles and rates of three segments are those of stance leg, swing thigh and swing shank.

    Attributes:
        robot: whose gait it is.
        slope: of the plane it walks down, rad.
        start: state just after a heel impact, both knees straight: three angles, three rates, shape (6,).
        knee_strike: time at which the swing knee strikes its stop, s.
        knee_rates: rates of the three segments just before that, shape (3,), rad/s.
        end: state just before the next heel impact, as `start`.
        period: time between heel impacts, s.
        step_length: distance between the feet then, along the ground, m.
        clearance: least height of the swing foot over the middle half of its way, m.
        greatest_flexion: of the swing knee, rad.
        multipliers: Floquet multipliers, the eigenvalues of the return map's Jacobian; complex, shape (3,), the largest
            magnitude first; five digits or better.
        times: of the samples, shape (n,), s; both of the knee strike's sides are among them.
        states: as `start`, at these times, shape (n, 6).
    """

    robot: KneedBiped
    slope: float
    start: Array = field(compare=False)
    knee_strike: float
    knee_rates: Array = field(compare=False)
    end: Array = field(compare=False)
    period: float
    step_length: float
    clearance: float
    greatest_flexion: float
    multipliers: NDArray[np.complex128] = field(compare=False)
    times: Array = field(compare=False, repr=False)
    states: Array = field(compare=False, repr=False)

    def __repr__(self) -> str:
        """One line."""
        kind = "stable" if self.stable else "unstable"
        return (
            f"<KneedGait on {math.degrees(self.slope):.4g} deg: {kind}, period {self.period:.6g} s, "
            f"step {self.step_length:.6g} m>"
        )

    @property
    def speed(self) -> float:
        """Mean speed along the ground, m/s."""
        return self.step_length / self.period

    @cached_property
    def branches(self) -> Branches:
        """Both branches of the motion, for controllers that track it."""
        q, dq = self.robot.knee_impact(self._struck[:3], self.knee_rates)
        struck = np.concatenate([q, dq])
        return passive_branches(self.robot, self.slope, self.start, struck, self.knee_strike, self.period)

    @property
    def _struck(self) -> Array:
        """State at the knee strike, shape (6,)."""
        state: Array = self.states[self.bent_samples - 1]
        return state

    @property
    def rate(self) -> float:  # type: ignore[override]  # never written
        """See `mjbiped.gaits.branches.Branches`."""
        return self.branches.rate

    @property
    def bent(self) -> Array:  # type: ignore[override]
        """The same."""
        return self.branches.bent

    @property
    def straight(self) -> Array:  # type: ignore[override]
        """The same."""
        return self.branches.straight

    def describe(self) -> dict[str, Any]:
        """What the gait is found by again, in plain JSON types; `mjbiped.gaits.described.gait_from` reads it."""
        return {"slope": self.slope, "robot": self.robot.to_dict()}

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out: every multiplier lies inside the unit circle."""
        return bool(abs(self.multipliers[0]) < 1)

    @property
    def bent_samples(self) -> int:
        """How many of the samples come before the knee strike; the next one is at the same time, after it."""
        return 1 + int(np.searchsorted(self.times, self.knee_strike))

    @property
    def feet(self) -> Array:
        """The swing foot from the stance foot at `times`, shape (n, 2), m: along the ground, along its normal."""
        return np.array([self.robot.swing_foot(q) for q in self.states[:, :3]])


def find_kneed_gait(robot: KneedBiped, slope: float) -> KneedGait:
    """A passive gait of period one on a plane, with knee strike and heel strike.

    Where the search finds several, it is a stable one, or else the least unstable. Results are cached.

    Args:
        robot: A biped with knees.
        slope: Of the plane, rad, > 0 (downhill).

    Raises:
        InputError: The slope is no number within a right angle of level, or the robot is no `KneedBiped`.
        GaitError: The search finds no gait on that slope.
    """
    domains.check_kind("robot", robot, KneedBiped)
    slope = domains.SLOPE.check("slope", slope)
    if slope < domains.DOWNHILL.low:
        raise _no_gait(slope, f"without torques the robot walks only downhill; give a slope {domains.DOWNHILL}")
    return _find(robot, slope)


def follow_kneed_gaits(gait: KneedGait, to: float, step: float = math.radians(0.25)) -> Iterator[KneedGait]:
    """The gaits next to a gait on gentler or steeper slopes, one after the other, until they end.

    Near the end of a branch the steps become shorter, down to 0.002 degrees; a gait counts only if it lies close to the
    one extrapolated, so that the search does not slip onto another branch.

    Args:
        gait: Where to begin; it is not among the results.
        to: Slope to stop at, rad, > 0.
        step: Between slopes, rad, > 0.
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
    return GaitError(f"no passive gait with knees on a slope of {math.degrees(slope):.6g} degrees: {reason}")


@lru_cache(maxsize=64)
def _find(robot: KneedBiped, slope: float) -> KneedGait:
    starts = []
    for half, stance, swing in STARTS:
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
    return min(gaits, key=lambda gait: abs(gait.multipliers[0]))


class _Phase(NamedTuple):
    """Part of a step: its duration, the state at its end, and the solution in between where it was asked for."""

    duration: float
    end: Array
    motion: Any


class _Step(NamedTuple):
    """One step: both phases, and where it leads, in scaled form."""

    free: _Phase
    locked: _Phase
    after: Array


def _unit(robot: KneedBiped) -> float:
    return math.sqrt(robot.leg_length / robot.gravity)


def _scaled(robot: KneedBiped, start: Array) -> Array:
    """(q1, dq1, dq2) of a start, rates times sqrt(l/g)."""
    return np.array([start[0], _unit(robot) * start[3], _unit(robot) * start[4]])


def _start(robot: KneedBiped, scaled: Array) -> Array:
    q1, dq1, dq2 = (scaled / [1.0, _unit(robot), _unit(robot)]).tolist()
    return np.array([q1, -q1, -q1, dq1, dq2, dq2])


def _phase(
    robot: KneedBiped,
    slope: float,
    start: Array,
    end: Callable[[float, Array], float],
    others: Mapping[str, Callable[[float, Array], float]],
    tolerance: float,
    dense: bool,
) -> _Phase:
    """The motion from a start until `end` falls through zero.

    Raises:
        GaitError: One of the others does so before, or nothing does.
    """
    events: list[Any] = []
    for each in (end, *others.values()):

        def event(t: float, state: Array, each: Callable[[float, Array], float] = each) -> float:
            return each(t, state)

        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]  # SciPy looks for them
        events.append(event)
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


def _step(robot: KneedBiped, slope: float, scaled: Array, tolerance: float = FINE, dense: bool = False) -> _Step:
    """The step from a start, by way of the knee strike.

    Raises:
        GaitError: There is none.
    """
    three, two = robot.chains[3].reach, robot.chains[2].reach

    def fallen(_: float, state: Array) -> float:
        return FALLEN - abs(float(state[0]))

    others = {
        "the swing foot touches the ground before the knee is straight": lambda _, y: float(three @ np.cos(y[:3])),
        "the robot falls": fallen,
    }
    free = _phase(robot, slope, _start(robot, scaled), lambda _, y: float(y[2] - y[1]), others, tolerance, dense)
    if free.duration < 1e-3 * _unit(robot):
        raise _no_gait(slope, "the knee does not bend")
    q, dq = robot.knee_impact(free.end[:3], free.end[3:])
    locked = _phase(
        robot,
        slope,
        np.concatenate([q, dq]),
        lambda _, y: float(two @ np.cos(y[:2])),
        {"the robot falls": fallen},
        tolerance,
        dense,
    )
    if locked.end[0] <= locked.end[1]:
        raise _no_gait(slope, "the swing foot lands behind the stance foot")
    q, dq = robot.heel_impact(locked.end[:2], locked.end[2:])
    return _Step(free, locked, np.array([q[0], *(_unit(robot) * dq)]))


def _solve(robot: KneedBiped, slope: float, guess: Array) -> KneedGait | None:
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


def _jacobian(robot: KneedBiped, slope: float, scaled: Array) -> Array:
    """Jacobian of the return map, shape (3, 3), by differences of fourth order."""

    def after(shift: Array) -> Array:
        return _step(robot, slope, scaled + shift).after

    width = 1e-4  # truncation ~1e-9 for maps as curved as these, noise ~1e-7
    columns = [(8 * (after(d) - after(-d)) - (after(2 * d) - after(-2 * d))) / (12 * width) for d in width * np.eye(3)]
    return np.column_stack(columns)


def _described(robot: KneedBiped, slope: float, scaled: Array) -> KneedGait:
    step = _step(robot, slope, scaled, dense=True)
    period = step.free.duration + step.locked.duration
    share = round(SAMPLES * step.free.duration / period)
    bent, straight = np.linspace(0, step.free.duration, share), np.linspace(0, step.locked.duration, SAMPLES - share)
    legs = step.locked.motion(straight).T
    states = np.concatenate([step.free.motion(bent).T, legs[:, [0, 1, 1, 2, 3, 3]]])
    gait = KneedGait(
        robot=robot,
        slope=slope,
        start=_start(robot, scaled),
        knee_strike=step.free.duration,
        knee_rates=step.free.end[3:].copy(),
        end=step.locked.end[[0, 1, 1, 2, 3, 3]],
        period=period,
        step_length=float(robot.swing_foot(step.locked.end[:2])[0]),
        clearance=0.0,
        greatest_flexion=float((states[:, 2] - states[:, 1]).max()),
        multipliers=eigenvalues(_jacobian(robot, slope, scaled)),
        times=np.concatenate([bent, step.free.duration + straight]),
        states=states,
    )
    along, height = gait.feet.T
    if height[1:-1].min() <= 0:  # so shallowly that the integration stepped over it
        raise _no_gait(slope, "the swing foot dips into the ground")
    for array in (gait.start, gait.knee_rates, gait.end, gait.multipliers, gait.times, gait.states):
        array.flags.writeable = False
    return replace(gait, clearance=float(height[np.abs(along) < gait.step_length / 2].min()))
