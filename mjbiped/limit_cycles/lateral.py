"""The lateral basin of a biped in space: how far roll and roll rate may be off the gait, for the walk to go on.

A start is the imitated gait's, just after a touchdown, but for the roll and its rate; the swing leg's pitch follows,
for both feet stand on the plane. What decides is the divergent component of motion across the heading: a sole whose
centre of pressure reaches a distance h to either side holds a deviation up to h, and a greater one grows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.control.controller import Controller
from mjbiped.engines.checks import check_controller
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.errors import InputError
from mjbiped.gaits.space import places_of_start, start_of
from mjbiped.limit_cycles.basin import ascending, blaming, filled
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import chosen
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains

STARTS = 13
"""Default number of rolls, and of roll rates."""

ROLL, ROLL_RATE = math.radians(8.0), 0.6
"""How far they reach to either side of the gait's by default, rad and rad/s."""


@dataclass(frozen=True)
class LateralBasin:
    """Steps of walks that begin with another roll and roll rate than the gait's.

    Attributes:
        slope: Slope of the plane, rad.
        rolls: Roll of the starts, less the gait's, shape (columns,), rad, positive towards the stance leg.
        roll_rates: Rate of the roll, less the gait's, shape (rows,), rad/s.
        deviations: Divergent component of each start, less the gait's, shape (rows, columns), m, positive towards the
            swing leg.
        steps: Steps of each walk, shape (rows, columns); -1: not computed.
        fallen: Whether the walk ended before the limit, shape (rows, columns).
        limit: Number of steps after which a walk is ended.
        walker: Name of the controller.
    """

    slope: float
    rolls: Array = field(repr=False)
    roll_rates: Array = field(repr=False)
    deviations: Array = field(repr=False)
    steps: NDArray[np.int16] = field(repr=False)
    fallen: NDArray[np.bool_] = field(repr=False)
    limit: int
    walker: str

    @property
    def share(self) -> float:
        """Share of the starts from which the walk goes on."""
        return float(np.mean((self.steps >= 0) & ~self.fallen))


def lateral_basin(
    controller: Controller,
    slope: float = 0.0,
    *,
    robot: Robot | None = None,
    rolls: ArrayLike | None = None,
    roll_rates: ArrayLike | None = None,
    limit: int = 10,
    progress: bool = False,
) -> LateralBasin:
    """Walk from many rolls and roll rates on a plane, in the hybrid engine.

    Args:
        controller: A controller of a biped in space, with a gait.
        slope: Slope of the plane, rad.
        robot: The robot that walks; the controller's unless given.
        rolls: Rolls of the starts, less the gait's, rad, ascending; 13 up to 8 degrees to either side unless given.
        roll_rates: Their rates, less the gait's, rad/s, ascending; 13 up to 0.6 to either side unless given.
        limit: Number of steps after which a walk is ended.
        progress: Whether to show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: An argument is outside its domain, the robot does not walk in space, or the controller imitates no
            gait.
        BasinInterrupted: Ctrl-C was pressed; the exception holds the rows computed so far.
        BasinStopped: The controller raised an exception; likewise.
    """
    check_controller(controller)
    gait = controller.gait
    if gait is None:
        raise InputError(f"{type(controller).__name__} imitates no gait off which a walk could begin")
    limit, slope = domains.LIMIT.check("limit", limit), domains.SLOPE.check("slope", slope)
    across = ascending("rolls", rolls, np.linspace(-ROLL, ROLL, STARTS), domains.ROLL)
    up = ascending("roll_rates", roll_rates, np.linspace(-ROLL_RATE, ROLL_RATE, STARTS), domains.RATE)
    engine = Hybrid()
    terms = Terms(engine, limit, None, robot, None, chosen(None), walks=len(across) * len(up))
    plan = make_plan(terms, controller, Terrain.incline(math.degrees(slope)), "gait")
    if not isinstance(plan.robot, InSpace):
        raise InputError(f"a {type(plan.robot).__name__} does not roll: give a robot in space, such as compass3d")
    walker, shape = plan.robot, (len(up), len(across))
    deviations, steps = np.full(shape, np.nan), np.full(shape, -1, dtype=np.int16)
    basin = LateralBasin(
        slope, across, up, deviations, steps, np.zeros(shape, dtype=bool), limit, type(controller).__name__
    )
    component = walker.divergent_component(np.array(plan.q), np.array(plan.dq))

    def row(number: int) -> None:
        for column, roll in enumerate(across.tolist()):
            q, dq = off_gait(walker, gait.start, roll, float(up[number]))
            with blaming(controller, f"the roll {roll:.4g} rad and its rate {up[number]:.4g} rad/s off the gait's"):
                run = engine.start(replace(plan, q=tuple(q.tolist()), dq=tuple(dq.tolist())))
                run.go()
            basin.deviations[number, column] = walker.divergent_component(q, dq) - component
            basin.steps[number, column] = len(run.recorder.touchdowns()["q"])
            basin.fallen[number, column] = run.outcome is not Outcome.FINISHED

    return filled(basin, row, len(up), 1, progress)  # Python walks one at a time


def off_gait(robot: InSpace, start: Array, roll: float, roll_rate: float) -> tuple[Array, Array]:
    """Angles and rates just after a touchdown, with another roll and roll rate than a gait's start.

    Args:
        robot: The robot.
        start: The gait's angles and rates, shape (2 n,).
        roll: How much is added to the roll, rad.
        roll_rate: How much is added to its rate, rad/s.
    """
    places = places_of_start(robot, start) + np.array([0.0, roll, 0.0, 0.0, roll_rate])
    angles, rates = np.split(robot.spread(start_of(robot.in_space[2], places)), 2)
    return angles, rates
