"""`walk()`: simulate a controller on a terrain in an engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from mjbiped.control.controller import Controller
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine, Run, engine_of
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Initial, Terms, make_plan
from mjbiped.errors import MjbipedError
from mjbiped.records.record import Walk
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.terrain.terrain import Terrain

Kept = TypeVar("Kept")


class _Broken(BaseException):
    """A walk that was broken off; what was recorded is not lost.

    Attributes:
        walk: The walk so far, with the outcome "interrupted".
        before: Walks of the same call that had ended before it.
    """

    before: tuple[Walk, ...] = ()

    def __init__(self, message: str, walk: Walk) -> None:
        """Make the exception from its message and the walk so far."""
        super().__init__(message)
        self.walk = walk


class WalkStopped(_Broken, MjbipedError):  # noqa: N818 (its sister is a KeyboardInterrupt, no Error either)
    """A walk was broken off by an error in the controller.

    `walk` is the record so far, with the outcome "interrupted"; `before` has the walks of the same call that had ended.
    """


class WalkInterrupted(_Broken, KeyboardInterrupt):
    """A walk was broken off by Ctrl-C.

    `walk` is the record so far, with the outcome "interrupted"; `before` has the walks of the same call that had ended.
    """


def walk(
    controller: Controller,
    terrain: Terrain,
    *,
    engine: str | Engine = "mujoco",
    steps: int | None = None,
    distance: float | None = None,
    initial: Initial = "gait",
    robot: Robot | None = None,
    sample_period: float | None = DEFAULT_SAMPLE_PERIOD,
    scuffing: ScuffingRule | None = None,
    disturbances: Disturbances | None = None,
    progress: bool = False,
) -> Walk:
    """Simulate a robot on a terrain until it has made its steps, or cannot go on.

    A fall is a result, not an exception: see `Walk.outcome` and `Walk.warnings`. The same arguments give bitwise the
    same record.

    Args:
        controller: Drives stance ankle and hip; see `controllers.Controller`.
        terrain: The ground; the robot starts with its (left) stance foot at x = 0.
        engine: "mujoco" (rigid bodies and contacts) or "hybrid" (the paper's equations and impact map), or an object
            with settings of its own: `mjbiped.Mujoco(timestep=...)`, `mjbiped.Hybrid(tolerance=...)`.
        steps: Touchdowns after which the walk is finished; 60 unless a distance is given.
        distance: Position x of the stance foot at which it is finished, m. With both, the first to be reached counts.
        initial: "gait" (on the imitated limit cycle, just after an impact), "rest" (both legs together on the ground,
            at rest), or (q1, q2, dq1, dq2) from the ground's normal under x = 0, rad and rad/s; with knees six numbers
            of stance leg, swing thigh and swing shank. Hip and swing foot are
            not under the ground, but for the hundredth of a leg length by which a straight swing leg scuffs.
        robot: The robot that walks; by default the controller's own model, or Table I.
        sample_period: Time between two samples of the record, s; in MuJoCo each is taken at the next physics step.
            None: no samples, for long or many walks; nothing can then be drawn of them.
        scuffing: When the swing foot may touch the ground. A gait whose swing foot it would never let land, because
            the steps are shorter than the rule's reach, is refused.
        disturbances: Noise, delay, limits of the motors and pushes; none unless given.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The record.

    Raises:
        InputError: An argument is outside its domain, or the controller's laws cannot be compiled; nothing has been
            computed then.
        GaitError: `initial="gait"` with a controller that imitates none, on a slope that has no passive gait.
        WalkStopped: The controller raised an exception; the error carries the walk so far.
        WalkInterrupted: Ctrl-C; a `KeyboardInterrupt` that carries the walk so far.
    """
    terms = Terms(engine_of(engine), steps, distance, robot, sample_period, chosen(scuffing))
    plan = make_plan(terms, controller, terrain, initial, disturbances=disturbances)
    run = terms.engine.start(plan)
    run.compile()
    return walked_out(run, run.record, progress=progress)


def walked_out(run: Run, keep: Callable[[], Kept], *, progress: bool = False) -> Kept:
    """Walk to the end, and return what is kept of the walk.

    Args:
        run: The walk, started.
        keep: Function that returns the walk's record or summary so far.
        progress: Show a progress bar.

    Raises:
        WalkStopped: The controller raised an exception; the error carries what is kept.
        WalkInterrupted: Ctrl-C; likewise.
    """
    try:
        run.go(progress=progress)
    except BaseException as error:
        kept: Any = keep()
        if is_interrupt(error):
            raise WalkInterrupted("walk interrupted", kept) from error
        if not isinstance(error, Exception | SystemExit):  # sys.exit() in a law ends no more than its walk
            raise
        raise WalkStopped(run.message(error), kept) from error
    return keep()


def is_interrupt(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind an error: one that comes while MuJoCo's C code runs can surface as a SystemError."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False
