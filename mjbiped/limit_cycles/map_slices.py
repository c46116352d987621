"""Slices through the return map of the unpowered robot: one component after a step over the same one before it.

The map has three components for a robot with two legs: angle and rate of the stance leg, rate of the swing leg; and one
for a rimless wheel, whose angle after an impact is always the same. In each slice one component varies about the gait
of period one, and the others are the gait's. Beside them stands a walk that begins near the gait.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mjbiped.errors import GaitError
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.passive import PassiveGait
from mjbiped.limit_cycles.periodic import OFF, PeriodicGait, check_scuffing, find_periodic_gait, places_of
from mjbiped.limit_cycles.return_map import TOUCHDOWN, ReturnMap, plane_of, walk_all
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.utils import domains

PUSH = 0.02
"""The walk begins with this share more of each component than the gait has."""

_COMPONENTS = ("angle of the stance leg (rad)", "rate of the stance leg (rad/s)", "rate of the swing leg (rad/s)")
_WHEEL = ("rate of the stance spoke (rad/s)",)
_REACH = 0.15  # of a slice to either side, as a share of the gait's angle, or of its greatest rate
_SETTLING = 4000  # steps, most of which are needed next to a period doubling only
_SAME = 1e-6  # difference of states a period apart on a settled walk, rad and rad/s


@dataclass(frozen=True)
class MapSlices:
    """Slices through a return map, and a walk.

    Attributes:
        gait: The passive gait of period one, in which the slices meet.
        components: What varies in each slice, with its unit.
        before: Values of the component before the step, shape (slices, n).
        after: Values after it, shape (slices, n); NaN where the robot makes no step, or lands with a bent
            knee.
        walk: Components of the walk, the first before any step, shape (steps + 1, slices).
        outcome: "walking", or how the walk ended.
        settled: The gait of period 2, 4, 8 or 16 on which the walk settles; None where it is another motion.
    """

    gait: PassiveGait
    components: tuple[str, ...]
    before: Array = field(repr=False)
    after: Array = field(repr=False)
    walk: Array = field(repr=False)
    outcome: str
    settled: PeriodicGait | None

    @property
    def fixed_point(self) -> Array:
        """Components of the gait of period one, shape (slices,)."""
        return places_of(self.gait.start)


def map_slices(
    robot: Robot, slope: float, *, points: int = 400, steps: int = 40, scuffing: ScuffingRule | None = None
) -> MapSlices:
    """Compute slices through the return map on a plane, and a walk that begins 2 % off the gait.

    Args:
        robot: Any robot.
        slope: Slope of the plane, rad, > 0 (downhill).
        points: Number of steps in each slice.
        steps: Number of steps of the walk.
        scuffing: When the swing foot of straight legs may touch the ground; the engines' rule unless given.

    Raises:
        InputError: An argument is outside its domain, or the scuffing rule would never let the gait land, or is given
            for a robot with knees.
        GaitError: The robot has no passive gait on that slope.
    """
    points, steps = domains.SLOPES.check("points", points), domains.MAP_STEPS.check("steps", steps)
    rule = chosen(scuffing)
    step = ReturnMap(robot, slope, rule)
    gait = passive_gait_of(robot, slope)
    check_scuffing(gait, slope, rule)
    fixed = places_of(gait.start)
    widths = np.full(len(fixed), _REACH * np.abs(fixed[-2:]).max())
    if len(fixed) > 1:
        widths[0] = _REACH * abs(fixed[0])
    shares = np.linspace(-1.0, 1.0, points)
    before, after = np.empty((2, len(fixed), points))
    for k, width in enumerate(widths):
        places = np.tile(fixed, (points, 1))
        places[:, k] += width * shares
        batch = walk_all(plane_of(robot, step.slope, rule), _states(robot, places, gait.start), 1)
        states, landed = batch.states[:, 0], batch.outcomes == TOUCHDOWN
        if len(fixed) > 1:
            landed &= np.abs(states[:, :2].sum(axis=1)) < OFF  # not on a bent knee
        before[k], after[k] = places[:, k], np.where(landed, places_of(states)[:, k], np.nan)
    start = _states(robot, (1.0 + PUSH) * fixed[None], gait.start)[0]
    walked = step.walk(start, max(steps, _SETTLING))
    walk = places_of(np.vstack([start, walked.states[:steps]]))
    outcome = walked.outcome if len(walked.states) < steps else "walking"
    settled = _settled(robot, slope, walked.states) if walked.outcome == "walking" and len(fixed) > 1 else None
    components = _COMPONENTS if len(fixed) > 1 else _WHEEL
    return MapSlices(gait, components, before, after, walk, outcome, settled)


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
