"""Passive gaits of the biped with knees.

The stance knee stays locked. The swing knee is free, bends, and strikes its stop; it locks, and the swing foot comes
down. If the foot touches the ground earlier, or the knee does not bend, there is no gait: unlike straight legs, legs
with knees may not scuff. Limit cycles are searched for from starts on a grid that covers walkers of all kinds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from mjbiped.errors import GaitError
from mjbiped.gaits import store
from mjbiped.gaits.cycle import COARSE, Step, attributes, free_motion, glide, limit_cycle, no_gait, step, unit_of
from mjbiped.gaits.passive import PassiveGait, check_walker, checked_slope
from mjbiped.gaits.reference import Table, closing_on, count_of_pieces, hold, in_pieces, table_of
from mjbiped.robots.kneed import KneedBiped, KneedLegs
from mjbiped.robots.robot import Array
from mjbiped.robots.round import RoundKneed

STARTS = tuple(product((0.10, 0.16, 0.22, 0.28, 0.34), (1.25, 1.45, 1.65, 1.9), (0.0, 0.4, 0.8, 1.2)))
"""Half angle between the legs, rad, and the rates of stance and swing leg over it, in sqrt(g/l). Gaits of light and
heavy shanks on 1 to 5 degrees lie between them."""
ROLLING = tuple(product((0.20, 0.25, 0.30, 0.35, 0.40), (0.9, 1.05, 1.25), (-0.5, -0.2, 0.1, 0.4, 0.8)))
"""More of them for round feet, on which legs roll more slowly through greater angles."""
TRIED = 8  # number of starts that are refined: those that repeat themselves best
SAMPLES = 401  # of a gait's angles
EARLY = 0.5  # of the time until the knee strike: further back no robot's knee strikes that is to walk on
ON = 0.15  # of the period after the knee strike, in which the motion of the bent knee goes on of itself


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class KneedGait(PassiveGait):
    """A passive gait of period one of the biped with knees, made by `find_kneed_gait`.

    Angles and rates of three segments are those of stance leg, swing thigh and swing shank. Both trajectories are the
    gait's own motion, continued beyond the knee strike on either side by the same laws, so that no torque is asked for
    where the robot's knee strikes early or late. The bent knee's free motion goes on past the stop for a while; then it
    is driven on at its last closing rate, and the legs come to rest as after the period. The straight knee's motion is
    followed back.
    """

    knee_strike: float

    @property
    def knee_rates(self) -> Array:
        """Rates of the three segments just before the knee strike, shape (3,), rad/s."""
        return self.branch(self.knee_strike, bent=True)[1]

    @cached_property
    def angles(self) -> Array:
        """Angles of the three segments at even times of the step, shape (SAMPLES, 3), rad."""
        return self.reference(np.linspace(0.0, self.period, SAMPLES))[0]

    @property
    def feet(self) -> Array:
        """Place of the swing foot from the stance foot then, along the ground and its normal, shape (SAMPLES, 2), m."""
        return np.asarray(self.robot.swing_foot(self.angles))

    @property
    def clearance(self) -> float:
        """Least height of the swing foot over the middle half of its way, m."""
        feet = self.feet
        return float(feet[np.abs(feet[:, 0]) < self.step_length / 2, 1].min())

    @property
    def greatest_flexion(self) -> float:
        """Greatest flexion of the swing knee, rad."""
        return float((self.angles[:, 2] - self.angles[:, 1]).max())


def find_kneed_gait(robot: KneedLegs, slope: float) -> KneedGait:
    """A passive gait of period one on a plane, with knee strike and heel strike.

    Where the search finds several, it is a stable one, or else the least unstable. Results are kept in the user's
    cache folder, or where the environment variable MJBIPED_CACHE_DIR says.

    Args:
        robot: A biped with knees.
        slope: Slope of the plane, rad, > 0 (downhill).

    Raises:
        InputError: The slope is no number within a right angle of level, or the robot is no `KneedBiped` in the plane.
        GaitError: The search finds no gait on that slope.
    """
    check_walker(robot, KneedBiped, RoundKneed)
    found: KneedGait = store.passive(KneedGait, robot, checked_slope(slope), _search)
    return found


def _search(robot: KneedLegs, slope: float) -> dict[str, Any]:
    """The attributes of the most stable gait found from the starts that repeat themselves best."""
    starts = []
    for half, stance, swing in STARTS + ROLLING if robot.radius else STARTS:
        places = np.array([-half, half * stance, half * swing])
        try:
            miss = np.abs(step(robot, slope, places, COARSE).after - places).max() / half
        except GaitError:
            continue
        starts.append((float(miss), places))
    found: list[tuple[Array, KneedGait]] = []
    for _, start in sorted(starts, key=lambda each: each[0])[:TRIED]:
        repeated = limit_cycle(robot, slope, start)
        if repeated is None or any(np.abs(repeated - known).max() < 1e-6 for known, _ in found):
            continue
        gait = _gait(robot, slope, repeated)
        if gait is not None:
            found.append((repeated, gait))
            if gait.stable:
                break
    if not found:
        raise no_gait(
            slope, "the search found none; try another slope, lighter shanks, or shanks whose centre of mass is higher"
        )
    _, best = min(found, key=lambda each: abs(each[1].multipliers[0]))
    kept = ("start", "end", "period", "step_length", "knee_strike", "multipliers")
    return {**{name: getattr(best, name) for name in kept}, "bent": best.tables[0], "straight": best.tables[1]}


def _gait(robot: KneedLegs, slope: float, places: Array) -> KneedGait | None:
    """The gait of a start that repeats itself; None if its swing foot dips into the ground."""
    walked = step(robot, slope, places)
    known, strike = attributes(robot, slope, places, walked), walked.first.duration * unit_of(robot)
    tables = _tables(robot, slope, walked, places, known["period"])
    gait = KneedGait(robot=robot, slope=slope, knee_strike=strike, tables=tables, **known)
    # so shallowly that the integration stepped over it
    return gait if gait.feet[1:-1, 1].min() > 0 else None


def _tables(robot: KneedLegs, slope: float, walked: Step, places: Array, period: float) -> tuple[Table, Table]:
    """The trajectories of the bent and of the straight knee."""
    unit, count = unit_of(robot), count_of_pieces(period, robot.leg_length, robot.gravity)
    width, strike = period / count / unit, walked.first.duration
    free, locked = (free_motion(robot.chains[n], slope, unit) for n in (3, 2))
    bent_until = min(math.ceil((strike + ON * period / unit) / width), count)
    bent = glide(free, robot.after_touchdown(places), bent_until * width).sol
    back_until = math.floor(EARLY * strike / width)
    ahead = walked.second.motion()
    struck = ahead(0.0)
    back = glide(locked, struck, back_until * width - strike).sol

    def straight(place: Array) -> Array:
        times = width * place - strike
        return np.array([(ahead if t >= 0.0 else back)(t)[:2] for t in times])

    first, end, last = back(back_until * width - strike), walked.second.end, bent(bent_until * width)
    ddq, slowing = np.array(locked(0.0, end)[2:]), np.array(free(0.0, last)[3:])
    early = in_pieces(lambda place: first[:2] + first[2:] * (width * (place - back_until))[:, None], range(back_until))
    walking = in_pieces(straight, range(back_until, count))
    straight_pieces = np.concatenate([early, walking, hold(end[:2], end[2:], ddq, width, count)])
    legs = hold(last[:2], last[3:5], slowing[:2], width, len(straight_pieces) - bent_until)
    flexion, closing, braking = np.diff([last[1:3], last[4:6], slowing[1:3]]).ravel().tolist()
    shank = legs[..., 1] + closing_on(flexion, closing, braking, width, len(legs))
    moved = in_pieces(lambda place: bent(width * place)[:3].T, range(bent_until))
    bent_pieces = np.concatenate([moved, np.concatenate([legs, shank[..., None]], axis=-1)])
    return table_of(1.0 / (width * unit), bent_pieces), table_of(1.0 / (width * unit), straight_pieces)
