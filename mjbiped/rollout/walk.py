"""`walk()`: simulate a controller on a terrain in an engine; and its machine code made in advance, `precompile()`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from typing import Any, TypeVar

from mjbiped.control.compiled import compilable_law
from mjbiped.control.controller import Controller
from mjbiped.control.loading import is_reference
from mjbiped.control.registry import controller_class, controller_names, make_controller, settings_of
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import ENGINES, Engine, Run, engine_of
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Initial, Terms, make_plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name
from mjbiped.utils.parallel import cores, processes, progress_bar

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
        controller: Controller of the joints; see `controllers.Controller`.
        terrain: The ground; the robot starts with its (left) stance foot at x = 0.
        engine: "mujoco" (rigid bodies and contacts) or "hybrid" (the paper's equations and impact map), or an object
            with settings of its own: `mjbiped.Mujoco(timestep=...)`, `mjbiped.Hybrid(tolerance=...)`.
        steps: Touchdowns after which the walk is finished; 60 unless a distance is given.
        distance: Position x of the stance foot at which the walk is finished, m. With steps and distance, the walk
            is finished by what is reached first.
        initial: First state: "gait" (on the imitated limit cycle, just after an impact), "rest" (both legs together on
            the ground, at rest), or (q1, q2, dq1, dq2) from the ground's normal under x = 0, rad and rad/s; with knees
            six numbers of stance leg, swing thigh and swing shank. Hip and swing foot must not be under the ground; a
            straight swing leg may reach a hundredth of a leg length below it.
        robot: The robot that walks; by default the controller's own model, or Table I.
        sample_period: Time between two samples of the record, s; in MuJoCo each is taken at the next physics step.
            None: no samples, for long or many walks; nothing can then be drawn of them.
        scuffing: Rule for when the swing foot may touch the ground. A gait whose steps are shorter than the rule's
            reach, so that its swing foot could never land, is refused.
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
        if not isinstance(error, Exception | SystemExit):  # sys.exit() in a law ends only the walk
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


Unit = tuple[str, str, Robot]
"""Names of an engine and of a controller, and a robot of the kind that is walked."""

_ROBOTS: tuple[Robot, ...] = (KneedBiped(), Compass())  # the longest compilation first


def precompile(
    controllers: Sequence[str] | None = None,
    *,
    engines: Sequence[str] | None = None,
    workers: int | None = None,
    progress: bool = True,
) -> dict[str, list[str]]:
    """Compile the laws and engines that walks of controllers need, in parallel processes.

    Machine code depends on the kind of robot and on the types of a controller's settings, not on their values, nor on
    the terrain. Code that is already cached on disk costs a second or two.

    Args:
        controllers: Names of controllers, registered or a user's own; unless given, all that are registered.
        engines: Names of engines; unless given, both.
        workers: Number of processes; one for each core unless given.
        progress: Whether to show a progress bar.

    Returns:
        The names of the controllers by engine.

    Raises:
        InputError: A name is unknown, or a controller's laws cannot be compiled; the other controllers' laws then are.
    """
    names = list(controllers or controller_names())
    for name in names:
        if is_reference(name) and controller_class(name).law is Controller.law:
            raise InputError(
                f"{name} is plain Python, of which no machine code is made: it has no law(); the page "
                '"controller" of the documentation shows one'
            )
    chosen = [known_name("engine", name, ENGINES) for name in engines or sorted(ENGINES)]
    units = [
        (engine, name, robot)
        for robot in _ROBOTS
        for engine in chosen
        for name in names
        if controller_class(name, robot).drives(robot)
    ]
    for name in {*names} - {name for _, name, _ in units}:
        joints = ", or ".join(" and ".join(robot.joints) for robot in _ROBOTS)
        raise InputError(f"{name} drives {' and '.join(controller_class(name).joints)}: robots have {joints}")
    # an engine's machine code serves many controllers: compile one of each engine first, then the others
    first = [*{unit[0]: unit for unit in reversed(units)}.values()]
    failures: list[InputError] = []
    with (
        processes(min(workers or cores(), len(units))) as pool,
        progress_bar(total=len(units), desc="compiling", unit="law", progress=progress) as bar,
    ):
        for group in (first, [unit for unit in units if unit not in first]):
            for done in as_completed([pool.submit(_walk_a_step, unit) for unit in group]):
                bar.update()
                try:
                    done.result()
                except InputError as error:
                    failures.append(error)
    if failures:
        raise failures[0]
    return dict.fromkeys(chosen, names)


def _walk_a_step(unit: Unit) -> None:
    """Walk one step in a process of its own, which compiles and tests all code that the walk needs."""
    engine, name, robot = unit
    given = {"imitate_slope_deg": 2.5} if "imitate_slope_deg" in settings_of(name, robot) else {}
    controller = make_controller(name, robot, given)
    if is_reference(name) and compilable_law(controller) is None:
        raise InputError(
            f"{name} is interpreted alone: machine code takes parameters that are floats in one flat list (a table as "
            "*table, behind the others), and functions that raise nothing"
        )
    walk(controller, Terrain.incline(2.5), engine=engine, robot=robot, steps=1, progress=False)
