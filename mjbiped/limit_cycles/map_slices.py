"""Slices through the return map of the unpowered robot: one component after a step over the same one before it.

The map has three components for a planar robot with two legs: angle and rate of the stance leg, rate of the swing leg;
two more in space, roll and roll rate; and one for a rimless wheel, whose angle after an impact is always the same. In
each slice one component varies about the gait of period one, and the others are the gait's. Beside them stands a walk
that begins near the gait.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from mjbiped.errors import GaitError
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.passive import PassiveGait
from mjbiped.gaits.space import find_gait_in_space, places_of_start, step
from mjbiped.limit_cycles.periodic import OFF, PeriodicGait, check_scuffing, find_periodic_gait, places_of
from mjbiped.limit_cycles.return_map import TOUCHDOWN, ReturnMap, plane_of, walk_all
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.rules.termination import FALLEN_HIP
from mjbiped.utils import domains

PUSH = 0.02
"""The walk begins with this share more of each component than the gait has."""

_COMPONENTS = ("angle of the stance leg (rad)", "rate of the stance leg (rad/s)", "rate of the swing leg (rad/s)")
_IN_SPACE = (_COMPONENTS[0], "roll (rad)", *_COMPONENTS[1:], "rate of the roll (rad/s)")
_WHEEL = ("rate of the stance spoke (rad/s)",)
_REACH = 0.15  # of a slice to either side, as a share of the gait's angle, or of its greatest rate
_POINTS = (400, 40)  # in each slice by default: of planar robots, and of those in space
_SETTLING = 4000  # steps, most of which are needed next to a period doubling only
_SAME = 1e-6  # difference of states a period apart on a settled walk, rad and rad/s


@dataclass(frozen=True)
class MapSlices:
    """Slices through a return map, and a walk.

    Attributes:
        gait: The passive gait of period one, in which the slices meet.
        fixed_point: Its components, shape (slices,).
        components: What varies in each slice, with its unit.
        before: Values of the component before the step, shape (slices, n).
        after: Values after it, shape (slices, n); NaN where the robot makes no step, or lands with a bent
            knee.
        walk: Components of the walk, the first before any step, shape (steps + 1, slices).
        outcome: "walking", or how the walk ended.
        settled: The gait of period 2, 4, 8 or 16 on which the walk settles; None where it is another motion.
    """

    gait: PassiveGait
    fixed_point: Array = field(repr=False)
    components: tuple[str, ...]
    before: Array = field(repr=False)
    after: Array = field(repr=False)
    walk: Array = field(repr=False)
    outcome: str
    settled: PeriodicGait | None


def map_slices(
    robot: Robot, slope: float, *, points: int | None = None, steps: int = 40, scuffing: ScuffingRule | None = None
) -> MapSlices:
    """Compute slices through the return map on a plane, and a walk that begins 2 % off the gait.

    Args:
        robot: Any robot. A step of one in space takes some 0.05 s, of others a few microseconds.
        slope: Slope of the plane, rad, > 0 (downhill).
        points: Number of steps in each slice; 400, or 40 in space, unless given.
        steps: Number of steps of the walk.
        scuffing: When the swing foot of straight legs may touch the ground; the engines' rule unless given.

    Raises:
        InputError: An argument is outside its domain, or the scuffing rule would never let the gait land, or is given
            for a robot with knees.
        GaitError: The robot has no passive gait on that slope.
    """
    points = domains.SLOPES.check("points", _POINTS[isinstance(robot, InSpace)] if points is None else points)
    steps = domains.MAP_STEPS.check("steps", steps)
    if isinstance(robot, InSpace):
        return _slices_in_space(robot, slope, points, steps)
    rule = chosen(scuffing)
    on_plane = ReturnMap(robot, slope, rule)
    gait = passive_gait_of(robot, slope)
    check_scuffing(gait, slope, rule)
    fixed = places_of(gait.start)

    def after_steps(places: Array) -> Array:
        batch = walk_all(plane_of(robot, on_plane.slope, rule), _states(robot, places, gait.start), 1)
        states, landed = batch.states[:, 0], batch.outcomes == TOUCHDOWN
        if len(fixed) > 1:
            landed &= np.abs(states[:, :2].sum(axis=1)) < OFF  # not on a bent knee
        return np.where(landed[:, None], places_of(states), np.nan)

    before, after = _slices(fixed, len(fixed) // 2, points, after_steps)
    start = _states(robot, (1.0 + PUSH) * fixed[None], gait.start)[0]
    walked = on_plane.walk(start, max(steps, _SETTLING))
    walk = places_of(np.vstack([start, walked.states[:steps]]))
    outcome = walked.outcome if len(walked.states) < steps else "walking"
    settled = _settled(robot, slope, walked.states) if walked.outcome == "walking" and len(fixed) > 1 else None
    components = _COMPONENTS if len(fixed) > 1 else _WHEEL
    return MapSlices(gait, fixed, components, before, after, walk, outcome, settled)


def _slices_in_space(robot: InSpace, slope: float, points: int, steps: int) -> MapSlices:
    """Slices and a walk of a biped in space, which walks by `mjbiped.gaits.space.step`."""
    gait = find_gait_in_space(robot, slope)
    fixed = places_of_start(robot, gait.start)

    def after_step(places: Array) -> Array:
        try:
            end = step(robot, gait.slope, places)[0]
        except GaitError:  # it does not end
            return np.full(len(places), np.nan)
        return end if np.cos(end[:2]).prod() > FALLEN_HIP else np.full(len(places), np.nan)

    before, after = _slices(fixed, 2, points, lambda starts: np.array([after_step(places) for places in starts]))
    walk = [(1.0 + PUSH) * fixed]
    while len(walk) <= steps and np.isfinite(walk[-1]).all():
        walk.append(after_step(walk[-1]))
    walked = np.array([places for places in walk if np.isfinite(places).all()])
    return MapSlices(gait, fixed, _IN_SPACE, before, after, walked, "walking" if len(walked) > steps else "fell", None)


def _slices(fixed: Array, angles: int, points: int, after: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Values of each component before and after a step, shape (components, points) each.

    Args:
        fixed: Components of the gait, angles first.
        angles: Number of angles among them.
        points: Number of steps in each slice.
        after: Function that returns the components after a step, shape (points, components), of those before it.
    """
    rates = len(fixed) - angles
    widths = np.repeat([_REACH * abs(fixed[0]), _REACH * np.abs(fixed[angles:]).max()], [angles, rates])
    places = fixed + np.einsum("k,p,kj->kpj", widths, np.linspace(-1.0, 1.0, points), np.eye(len(fixed)))
    found = np.array([after(starts) for starts in places])
    return np.einsum("kpk->kp", places), np.einsum("kpk->kp", found)


def _states(robot: Robot, places: Array, start: Array) -> Array:
    """States with given components; `start` tells the angle that is always the same."""
    if places.shape[-1] > 1:
        return robot.after_touchdown(places)
    return np.column_stack([np.full(len(places), start[0]), places])


def _settled(robot: Robot, slope: float, states: Array) -> PeriodicGait | None:
    """The gait of period 2, 4, 8 or 16 on which a walk ends; None where it ends on that of period one, or on none."""
    for count in (1, 2, 4, 8, 16):
        if np.abs(states[-count:] - states[-2 * count : -count]).max() < _SAME:
            try:
                return find_periodic_gait(robot, slope, states[-count:]) if count > 1 else None
            except GaitError:  # next to a doubling, where two gaits are nearly one
                return None
    return None
