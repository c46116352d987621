"""Basins of attraction: initial rates from which a walk settles on its gait, and those from which it falls.

A basin is a slice through the section of states just after an impact: both feet stand on the plane, the angle between
the legs is the gait's, and the rates of the two legs form a grid. The gait lies in the slice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.control.compiled import LawError
from mjbiped.control.controller import Controller
from mjbiped.engines.base import Run
from mjbiped.engines.checks import check_controller
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.errors import InputError, MjbipedError, explained, place_of
from mjbiped.gaits.described import passive_gait_of
from mjbiped.limit_cycles import return_map
from mjbiped.limit_cycles.periodic import check_biped, check_scuffing
from mjbiped.limit_cycles.return_map import ReturnMap, kicked, plane_of, walk_all
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.parallel import cores, progress_bar

SETTLED = 1e-3
"""A walk has settled when a state after an impact is as near to the gait's as this, in rad and sqrt(g/l)."""

_TRANSIENT, _ATTRACTOR = 2000, 64  # steps until the passive robot has reached its attractor, and steps on it
_RATES = 300  # default number of rates of either leg
_FIRST_LOOK = 2  # steps; most controlled walks have settled after one


Map = TypeVar("Map")  # a basin's map


class Fate(IntEnum):
    """The end of a walk."""

    SETTLED = 0
    UNDECIDED = 1  # still walking, but not settled; or not computed
    FELL = 2
    STALLED = 3
    DIVERGED = 4


_FATES = {
    return_map.SETTLED: Fate.SETTLED,
    return_map.TOUCHDOWN: Fate.UNDECIDED,
    **{int(Outcome[fate.name]): fate for fate in (Fate.FELL, Fate.STALLED, Fate.DIVERGED)},
}


@dataclass(frozen=True)
class Basin:
    """Fates of walks that begin with different rates of the legs.

    Attributes:
        slope: Slope of the plane, rad.
        start: The state in whose slice the starts lie, shape (4,), or (6,) with knees: the gait's after an impact.
        stance_rates: dq1 of the starts, shape (columns,), rad/s.
        swing_rates: dq2 of the starts, shape (rows,), rad/s; with knees the swing leg is straight, and dq3 the same.
        fates: `Fate` of each start, shape (rows, columns).
        steps: Steps walked until the walk had settled or ended, shape (rows, columns).
        peak_torque: Greatest torque of any joint in each walk, shape (rows, columns), N m; 0 without a controller.
            Most walks were followed for two steps, those undecided by then up to the limit.
        limit: Number of steps after which a walk is undecided.
        walker: Name of the controller, or "passive".
    """

    slope: float
    start: Array = field(repr=False)
    stance_rates: Array = field(repr=False)
    swing_rates: Array = field(repr=False)
    fates: NDArray[np.int8] = field(repr=False)
    steps: NDArray[np.int16] = field(repr=False)
    peak_torque: Array = field(repr=False)
    limit: int
    walker: str

    def __repr__(self) -> str:
        """Return a summary in one line; the maps are long."""
        shares = ", ".join(f"{100 * self.share(fate):.3g} % {fate.name.lower()}" for fate in Fate if self.share(fate))
        rows, columns = self.fates.shape
        return f"<Basin of {self.walker} on {math.degrees(self.slope):.4g} deg, {rows} x {columns} starts: {shares}>"

    def share(self, fate: Fate) -> float:
        """Share of the starts that have this fate."""
        return float(np.mean(self.fates == fate))


class BasinInterrupted(KeyboardInterrupt):
    """A map interrupted by Ctrl-C, with the rows computed so far.

    Attributes:
        basin: The map so far, a `Basin` undecided where nothing was computed, or a
            `mjbiped.limit_cycles.lateral.LateralBasin`.
    """

    basin: Any


class BasinStopped(MjbipedError):  # noqa: N818 (as its sister)
    """A map stopped by an error in the controller, with the rows computed so far.

    Attributes:
        basin: As of `BasinInterrupted`.
    """

    basin: Any


def basin_of_attraction(
    robot: Robot,
    slope: float,
    *,
    stance_rates: ArrayLike | None = None,
    swing_rates: ArrayLike | None = None,
    limit: int = 100,
    scuffing: ScuffingRule | None = None,
    threads: int | None = None,
    progress: bool = False,
) -> Basin:
    """The basin of the passive robot on a plane, by its return map.

    A walk settles on the attractor on which the robot walks after being pushed off its gait of period one by 1e-4 rad:
    that gait, one of twice, four times ... its period, or an aperiodic motion. Where it falls from there, nothing
    settles.

    Args:
        robot: Any robot.
        slope: Of the plane, rad.
        stance_rates: dq1 of the starts, rad/s, ascending; 300 from 0.5 to 1.6 times the gait's unless given.
        swing_rates: dq2 of the starts, rad/s, ascending; 300 within 2.2 times the gait's greater rate unless given.
        limit: Number of steps after which a walk counts as undecided.
        scuffing: When the swing foot may touch the ground; the engines' rule unless given.
        threads: Worker threads; as many as there are cores unless given. The map does not depend on it.
        progress: Whether to show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: An argument is outside its domain, or the scuffing rule would never let the gait land, or is given
            for a robot with knees.
        GaitError: The robot has no gait on that slope.
        BasinInterrupted: Ctrl-C was pressed; the exception holds the rows computed so far.
    """
    check_biped(robot)
    gait = passive_gait_of(robot, slope)
    rule = chosen(scuffing)
    check_scuffing(gait, gait.slope, rule)
    threads = domains.WORKERS.check("threads", cores() if threads is None else threads)
    basin = _empty(gait.slope, gait.start, stance_rates, swing_rates, limit, "passive")
    plane = plane_of(robot, gait.slope, rule)
    walked = ReturnMap(robot, gait.slope, rule).walk(kicked(gait.start), _TRANSIENT)
    goals = np.unique(np.round(walked.states[-_ATTRACTOR:], 6), axis=0)
    if walked.outcome != "walking":
        goals = np.empty((0, len(gait.start)))
    near = _nearness(robot)

    def row(number: int) -> None:
        swing = basin.swing_rates[number]
        places = np.array([(gait.start[0], stance, swing) for stance in basin.stance_rates.tolist()])
        batch = walk_all(plane, robot.after_touchdown(places), basin.limit, goals=goals, near=near)
        basin.steps[number] = batch.counts
        basin.fates[number] = [_FATES[outcome] for outcome in batch.outcomes.tolist()]

    return filled(basin, row, len(basin.swing_rates), threads, progress)


def basin_of_control(
    controller: Controller,
    slope: float = 0.0,
    *,
    robot: Robot | None = None,
    stance_rates: ArrayLike | None = None,
    swing_rates: ArrayLike | None = None,
    limit: int = 10,
    scuffing: ScuffingRule | None = None,
    threads: int | None = None,
    progress: bool = False,
) -> Basin:
    """The basin of controlled walking on a plane, in the hybrid engine.

    A walk settles on the gait that the controller imitates. Its torques are not bounded.

    Args:
        controller: Any controller with a gait; one whose laws can be compiled (see `controllers.Law`) is fast.
        slope: Of the plane, rad.
        robot: The robot that walks; the controller's unless given.
        stance_rates: As in `basin_of_attraction`.
        swing_rates: As in `basin_of_attraction`.
        limit: Number of steps after which a walk counts as undecided.
        scuffing: When the swing foot may touch the ground; the engines' rule unless given.
        threads: Worker threads; as many as there are cores unless given. The map does not depend on it.
        progress: Whether to show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: An argument is outside its domain, or the controller imitates no gait, or one that the scuffing
            rule would never let land.
        BasinInterrupted: Ctrl-C was pressed; the exception holds the rows computed so far.
        BasinStopped: The controller raised an exception; the error holds the rows computed so far.
    """
    check_controller(controller)
    gait = controller.gait
    if gait is None:
        raise InputError(
            f"{type(controller).__name__} imitates no gait to return to: give the dataclass the fields "
            "robot: mjbiped.Compass and gait: mjbiped.Gait"
        )
    slope = domains.SLOPE.check("slope", slope)
    threads = domains.WORKERS.check("threads", cores() if threads is None else threads)
    basin = _empty(slope, gait.start, stance_rates, swing_rates, limit, type(controller).__name__)
    engine = Hybrid()
    terms = Terms(engine, basin.limit, None, robot, None, chosen(scuffing), walks=basin.fates.size)
    plan = make_plan(terms, controller, Terrain.incline(math.degrees(slope)), "gait")
    near = _nearness(plan.robot)

    def row(number: int) -> None:
        rate2 = float(basin.swing_rates[number])
        for column, rate1 in enumerate(basin.stance_rates.tolist()):
            dq = (rate1, *(rate2,) * (len(plan.q) - 1))
            with blaming(controller, f"the rates {rate1:.4g} and {rate2:.4g} rad/s"):
                for steps in sorted({min(_FIRST_LOOK, limit), limit}):
                    run = engine.start(replace(plan, dq=dq, terms=replace(terms, steps=steps)))
                    walked, fate = _walk_controlled(run, gait.start, near)
                    if fate is not Fate.UNDECIDED:
                        break
            basin.steps[number, column], basin.fates[number, column] = walked, fate
            basin.peak_torque[number, column] = run.peak_torque().max()

    return filled(basin, row, len(basin.swing_rates), threads, progress)


@contextmanager
def blaming(controller: Controller, start: str) -> Iterator[None]:
    """Say of an exception of a controller's own from which start it came.

    Raises:
        BasinStopped: The controller raised one.
    """
    try:
        yield
    except LawError:
        raise
    except Exception as error:
        raise BasinStopped(
            f"{type(controller).__name__} failed in the walk from {start}: "
            f"{explained(error)}{place_of(error, type(controller))}"
        ) from error


def _walk_controlled(run: Run, goal: Array, near: Array) -> tuple[int, Fate]:
    """Walk to the end; the number of steps until a state after an impact is near the goal, or all, and the fate."""
    run.go()
    touchdowns = run.recorder.touchdowns()
    states = np.hstack([touchdowns["q"], touchdowns["dq"]])
    inside = (np.abs(states - goal) < near).all(axis=1)
    if inside.any():
        return int(inside.argmax()) + 1, Fate.SETTLED
    return len(states), _FATES.get(int(run.outcome), Fate.UNDECIDED)


def _empty(
    slope: float, start: Array, stance_rates: ArrayLike | None, swing_rates: ArrayLike | None, limit: int, walker: str
) -> Basin:
    """Make a map of undecided starts.

    Raises:
        InputError: The rates do not ascend, or the limit is no number of steps.
    """
    limit = domains.LIMIT.check("limit", limit)
    stance, swing = rates_around(start, _RATES)
    columns = ascending("stance_rates", stance_rates, stance, domains.RATE)
    rows = ascending("swing_rates", swing_rates, swing, domains.RATE)
    shape = (len(rows), len(columns))
    fates, steps = np.full(shape, Fate.UNDECIDED, dtype=np.int8), np.zeros(shape, dtype=np.int16)
    return Basin(slope, start.copy(), columns, rows, fates, steps, np.zeros(shape), limit, walker)


def rates_around(start: Array, count: int, width: float = 1.0) -> tuple[Array, Array]:
    """Return the default initial rates of a map.

    Args:
        start: The gait's state after an impact, shape (4,), or (6,) with knees.
        count: Number of rates of either leg.
        width: Factor on the usual range to both sides of its middle.

    Returns:
        Rates of the stance leg, usually 0.5 to 1.6 times the gait's, and of the swing leg, usually within 2.2 times the
        gait's greater rate, rad/s, shape (count,) each, in equal steps.
    """
    rates = start[len(start) // 2 :]
    greatest = 2.2 * width * float(np.abs(rates).max())
    return (
        np.linspace((1.05 - 0.55 * width) * rates[0], (1.05 + 0.55 * width) * rates[0], count),
        np.linspace(-greatest, greatest, count),
    )


def ascending(name: str, given: ArrayLike | None, usual: Array, domain: domains.Domain) -> Array:
    """Check the numbers along a side of a map, each within a domain; the usual ones unless given."""
    numbers = usual if given is None else domain.array(name, given, (None,))
    if not 1 <= len(numbers) <= domains.GRID.high or (np.diff(numbers) <= 0.0).any():
        raise InputError(f"{name}: expected 1 to {domains.GRID.high} numbers that ascend, got {len(numbers)}")
    return numbers


def _nearness(robot: Robot) -> Array:
    """The distance `SETTLED` in each component of a state."""
    frequency, angles = math.sqrt(robot.gravity / robot.leg_length), len(robot.angles)
    return SETTLED * np.repeat([1.0, frequency], angles)


def filled(basin: Map, row: Callable[[int], None], count: int, threads: int, progress: bool) -> Map:
    """Compute all rows of a map in threads.

    Args:
        basin: The map.
        row: Function that fills in a row of it.
        count: Number of rows.
        threads: Number of threads.
        progress: Whether to show a progress bar.

    Raises:
        BasinInterrupted: Ctrl-C.
        BasinStopped: The controller raised an exception.
    """
    with ThreadPoolExecutor(threads) as pool:
        try:
            futures = [pool.submit(row, number) for number in range(count)]
            for future in progress_bar(as_completed(futures), total=count, desc="rows", progress=progress):
                future.result()
        except BaseException as error:
            pool.shutdown(cancel_futures=True)
            stop = BasinInterrupted("basin map interrupted") if isinstance(error, KeyboardInterrupt) else error
            if isinstance(stop, BasinInterrupted | BasinStopped):
                stop.basin = basin
            raise stop from error.__cause__
    return basin
