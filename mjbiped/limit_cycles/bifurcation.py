"""The period-doubling cascade of a passive walker on steeper and steeper planes, and its bifurcation diagram."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.errors import GaitError, InputError
from mjbiped.gaits.described import passive_gait_of
from mjbiped.limit_cycles import periodic
from mjbiped.limit_cycles.periodic import PeriodicGait, check_biped, check_scuffing, guard_of, step_lengths
from mjbiped.limit_cycles.return_map import TOUCHDOWN, ReturnMap, kicked, plane_of, walk_all
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.rules.termination import Outcome
from mjbiped.utils import domains
from mjbiped.utils.parallel import progress_bar

FIRST_SLOPE = math.radians(0.1)
"""Slope on which the branch of period one begins; where it has no gait, on the gentlest one that has."""

SEARCHED = tuple(math.radians(degrees) for degrees in (5.0, 3.0, 2.0))
"""Slopes on which a robot whose foot must clear the ground is searched for a gait, which then is followed to either
side. It has none on the gentlest slopes, and a search in vain takes ten seconds."""

FEIGENBAUM = 4.669201609
_FIRST_STEP = math.radians(0.05)
_FIRST_WINDOW = 0.25  # of the first onset: about as far beyond it the doublings gather
_STEEPEST = math.radians(20.0)
_SETTLING = 1000  # periods allowed for reaching a stable gait from its unstable parent; a tenth would do


@dataclass(frozen=True)
class Branch:
    """The gaits of one period, followed with the slope from their onset until just beyond their period doubling.

    Attributes:
        count: Number of steps after which the gait repeats itself.
        gaits: The gaits in the order of their slopes.
        doubling: The gait at which a multiplier passes through -1; None where the branch ends without one.
    """

    count: int
    gaits: tuple[PeriodicGait, ...] = field(repr=False)
    doubling: PeriodicGait | None


@dataclass(frozen=True)
class Cascade:
    """Period doublings of the passive gait with slope.

    Attributes:
        robot: The robot that walks.
        branches: Branches of periods 1, 2, 4, ...
        end: Why the cascade ends there; empty if as many doublings were found as were asked for.
    """

    robot: Robot
    branches: tuple[Branch, ...]
    end: str

    def __repr__(self) -> str:
        """Return a summary in one line."""
        begins = ", ".join(f"{degrees:.6g}" for degrees in np.degrees(self.onsets))
        return f"<Cascade: periods double on {begins} deg>" if begins else "<Cascade: no period doubles>"

    @property
    def onsets(self) -> Array:
        """Slopes at which periods 2, 4, 8, ... begin, rad."""
        return np.array([branch.doubling.slope for branch in self.branches if branch.doubling is not None])

    @property
    def ratios(self) -> Array:
        """Ratios of successive distances between onsets, which tend to Feigenbaum's number, 4.669."""
        distances = np.diff(self.onsets)
        return np.asarray(distances[:-1] / distances[1:], dtype=np.float64)

    @property
    def window(self) -> tuple[float, float] | None:
        """Range of slopes in which the onsets accumulate, rad; None with fewer than two onsets."""
        onsets = self.onsets
        if len(onsets) < 2:
            return None
        width = float(self.accumulation - onsets[1] if len(onsets) > 2 else onsets[1] - onsets[0])
        return float(onsets[1] - 0.3 * width), float(onsets[1] + 2.2 * width)

    @property
    def span(self) -> tuple[float, float]:
        """Range of slopes around all doublings, rad: from where the period is one to where robots fall.

        Without a doubling, the slopes of the gaits of period one.
        """
        onsets, gaits = self.onsets, self.branches[0].gaits
        if not len(onsets):
            return gaits[0].slope, gaits[-1].slope
        width = float(self.accumulation - onsets[0]) if len(onsets) > 1 else _FIRST_WINDOW * float(onsets[0])
        return max(gaits[0].slope, float(onsets[0]) - 0.5 * width), float(onsets[0]) + 1.4 * width

    @property
    def accumulation(self) -> float:
        """Slope at which the onsets accumulate by Feigenbaum's ratio, rad; NaN with fewer than two onsets."""
        onsets = self.onsets
        if len(onsets) < 2:
            return math.nan
        return float(onsets[-1] + (onsets[-1] - onsets[-2]) / (FEIGENBAUM - 1.0))


def find_cascade(robot: Robot, doublings: int = 4, *, progress: bool = False) -> Cascade:
    """Find the passive gaits of periods 1, 2, 4 and so on, and the slopes at which each gives way to the next.

    The gait of period one is followed from 0.1 degrees, or from the gentlest slope that has one; beyond each doubling
    the robot is left to find the gait of twice the period by itself, which Newton's method then makes exact and follows
    further. Touchdown of straight legs is that of eq. 4: whenever the swing foot comes down ahead of the stance foot.

    Args:
        robot: Any robot with two legs.
        doublings: How many to look for, at least 1.
        progress: Whether to show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: The robot has no two legs, or `doublings` is not a whole number from 1 to 6; beyond, rounding
            decides.
        GaitError: The robot has no gait on 0.1 degrees, or with knees on none of 5, 3 and 2 degrees.
    """
    check_biped(robot)
    doublings = domains.DOUBLINGS.check("doublings", doublings)
    branches: list[Branch] = []
    gait, step, end = _gentlest(robot), _FIRST_STEP, ""
    with progress_bar(total=doublings, desc="doublings", progress=progress) as bar:
        while True:
            branch = _followed(gait, step)
            branches.append(branch)
            if branch.doubling is None:
                end = f"the gait of period {branch.count} ends at {math.degrees(branch.gaits[-1].slope):.4g} degrees"
                end += " without doubling"
                break
            bar.update()
            if len(branches) == doublings:
                break
            # the next window is narrower by Feigenbaum's ratio or so; begin at some tenth of it
            onset = branch.doubling.slope
            window = onset - branches[-1].gaits[0].slope if len(branches) > 1 else _FIRST_WINDOW * onset
            step = 0.1 * window / FEIGENBAUM
            try:
                gait = _doubled(robot, branch.doubling, onset + step)
            except GaitError as error:
                end = f"beyond {math.degrees(onset):.4g} degrees the robot finds no gait of twice the period: {error}"
                break
    return Cascade(robot, tuple(branches), end)


def _gentlest(robot: Robot) -> PeriodicGait:
    """The gait of period one with which its branch begins.

    Raises:
        GaitError: No gait is found.
    """
    errors = []
    for slope in SEARCHED if robot.collides_from_lift_off else (FIRST_SLOPE,):
        try:
            gait = periodic.first_gait(robot, slope)
        except GaitError as error:
            errors.append(error)
        else:
            gentler = np.arange(slope, FIRST_SLOPE, -_FIRST_STEP)[1:].tolist()
            return [gait, *periodic.follow(gait, gentler)][-1]
    raise errors[-1]


def _followed(gait: PeriodicGait, step: float) -> Branch:
    """Follow a branch from its first gait until shortly beyond its doubling, in equal steps of the slope."""
    gaits, doubling = [gait], None
    slopes = np.arange(gait.slope, _STEEPEST, step)[1:]
    beyond = math.inf
    for found in periodic.follow(gait, slopes.tolist()):
        gaits.append(found)
        if doubling is None and gaits[-2].doubling > 0.0 >= found.doubling:
            doubling = periodic.zero_on_branch(gaits[-2], found, lambda gait: gait.doubling)
            beyond = found.slope + 0.5 * (found.slope - gait.slope)
        if found.slope > beyond:
            break
    return Branch(len(gait.states), tuple(gaits), doubling)


def _doubled(robot: Robot, parent: PeriodicGait, slope: float) -> PeriodicGait:
    """The stable gait of twice the period on a slope a little beyond the doubling of its parent.

    Raises:
        GaitError: There is none.
    """
    count = 2 * len(parent.states)
    steps = ReturnMap(robot, slope, guard_of(robot)).walk(kicked(parent.states[0]), _SETTLING * count)
    if steps.outcome != "walking":
        raise GaitError(f"it {steps.outcome} after {len(steps.states)} steps")
    return periodic.find_periodic_gait(robot, slope, steps.states[-count:])


@dataclass(frozen=True)
class BifurcationDiagram:
    """The steps on which the robot settles on planes of different slope.

    Attributes:
        robot: The robot that walks.
        slopes: Slopes of the planes, rad, shape (n,).
        states: The last states (q1, q2, dq1, dq2) after impacts on each, shape (n, kept, 4), with knees (n, kept, 6);
            NaN where it fell.
        periods: Durations of these steps, shape (n, kept), s.
        outcomes: "walking" or the end of the walk on each slope.
    """

    robot: Robot
    slopes: Array
    states: Array = field(repr=False)
    periods: Array = field(repr=False)
    outcomes: tuple[str, ...] = field(repr=False)

    def __repr__(self) -> str:
        """Return a summary in one line; the tables are long."""
        first, last = np.degrees(self.slopes[[0, -1]])
        fallen = sum(outcome != "walking" for outcome in self.outcomes)
        return (
            f"<BifurcationDiagram of {len(self.slopes)} slopes from {first:.6g} to {last:.6g} deg, "
            f"{self.periods.shape[1]} steps each; lost on {fallen}>"
        )

    @property
    def step_lengths(self) -> Array:
        """Distances between the feet at the impacts, shape (n, kept), m."""
        return step_lengths(self.robot, self.states)

    @property
    def lost(self) -> float:
        """The first slope on which the walk ended early, rad; NaN if there is none."""
        fallen = self.slopes[[outcome != "walking" for outcome in self.outcomes]]
        return float(fallen[0]) if len(fallen) else math.nan

    def counts(self, tolerance: float = 1e-5) -> NDArray[np.int64]:
        """Steps after which the motion repeats itself within `tolerance` m of step length; 0 if not within 32.

        Shape (n,); 0 also where the robot fell.
        """
        tolerance = domains.Domain(0.0, 1e3, "m").check("tolerance", tolerance)
        lengths = self.step_lengths
        result = np.zeros(len(lengths), dtype=np.int64)
        for count in range(min(32, lengths.shape[1] - 1), 0, -1):  # the least that fits is the last
            result[np.abs(lengths[:, count:] - lengths[:, :-count]).max(axis=1) < tolerance] = count
        return result


def bifurcation_diagram(
    robot: Robot,
    slopes: ArrayLike,
    *,
    steps: int = 600,
    keep: int = 100,
    scuffing: ScuffingRule | None = None,
    progress: bool = False,
) -> BifurcationDiagram:
    """Compute the bifurcation diagram of the passive robot; each plane is entered in the last state on the one before.

    Args:
        robot: Any robot with two legs.
        slopes: Slopes of the planes, rad, ascending, at least one.
        steps: Number of steps walked on each plane.
        keep: Number of last steps that are kept.
        scuffing: When the swing foot may touch the ground; the engines' rule unless given.
        progress: Whether to show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: The robot has no two legs, the slopes do not ascend from above zero, `keep` does not lie between 1
            and `steps`, or the scuffing rule would never let the gait on the first plane land.
        GaitError: There is no gait of period one on the first plane.
    """
    check_biped(robot)
    planes = domains.DOWNHILL.array("slopes", slopes, (None,))
    if not len(planes) or (np.diff(planes) <= 0.0).any():
        raise InputError("slopes: expected at least one, ascending: each walk begins where the one before ended")
    steps, keep = domains.MAP_STEPS.check("steps", steps), domains.MAP_STEPS.check("keep", keep)
    if keep > steps:
        raise InputError(f"keep = {keep}: must not be more than the {steps} steps that are walked")
    domains.KEPT.check("keep times the number of slopes", keep * len(planes))
    rule = chosen(scuffing)
    check_scuffing(passive_gait_of(robot, float(planes[0])), float(planes[0]), rule)
    start = kicked(periodic.first_gait(robot, float(planes[0])).states[0])
    kept = np.full((len(planes), keep, 2 * len(robot.angles)), np.nan)
    times = np.full((len(planes), keep), np.nan)
    outcomes = []
    for row, slope in enumerate(progress_bar(planes.tolist(), desc="slopes", progress=progress)):
        batch = walk_all(plane_of(robot, slope, rule), start[None], steps, room=steps)
        outcomes.append(Outcome(batch.outcomes[0]).name.lower())
        if batch.outcomes[0] == TOUCHDOWN:
            kept[row], times[row] = batch.states[0, -keep:], batch.periods[0, -keep:]
            start = batch.states[0, -1].copy()
    return BifurcationDiagram(robot, planes, kept, times, tuple(outcomes))
