"""What `walk()` and `walk_many()` are asked for, checked before anything is computed."""

from __future__ import annotations

import dataclasses
import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import scipy

from mjbiped.control.error_location import place_of
from mjbiped.control.loading import source_of
from mjbiped.control.validation import try_out
from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.disturbances.sampled import SampledController
from mjbiped.errors import GaitError, InputError, MjbipedError, explained, shown
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.gait import Branched, Gait, Periodic
from mjbiped.records.settings import described
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule, check_landing
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import MEMORY_SIZE, check_given_fields, check_kind, check_states
from mjbiped.version import __version__

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller
    from mjbiped.engines.base import Engine

INITIAL_STATES = ("gait", "rest")
DEFAULT_STEPS = 60
DEFAULT_SAMPLE_PERIOD = 0.005  # s
SCUFF = 0.01  # of leg lengths: as deep a straight swing leg may be in the ground, twice what passive gaits on 5° are
_ON_GROUND = 1e-6  # of leg lengths: a foot so deep stands on the ground


@dataclass(frozen=True)
class Terms:
    """What walks have in common; see `mjbiped.rollout.walk.walk` for the meanings.

    Attributes:
        engine: Makes the walks.
        steps: With neither a number of steps nor a distance given, `DEFAULT_STEPS`.
        distance: m.
        robot: None: the controller's own, or Table I.
        sample_period: s; None: no samples.
        scuffing: The default rule unless given.

    Raises:
        InputError: A value is outside its domain.
    """

    engine: Engine
    steps: int | None
    distance: float | None
    robot: Robot | None
    sample_period: float | None
    scuffing: ScuffingRule

    def __post_init__(self) -> None:
        """Check what can be checked without a controller and a terrain."""
        if self.steps is None and self.distance is None:
            object.__setattr__(self, "steps", DEFAULT_STEPS)
        check_given_fields(self, steps=domains.STEPS, distance=domains.DISTANCE, sample_period=domains.SAMPLE_PERIOD)
        if self.robot is not None:
            check_robot("robot", self.robot)


@dataclass(frozen=True)
class Plan:
    """One walk, checked and not yet started.

    Attributes:
        terms: What it has in common with others.
        controller: Drives the robot's joints.
        terrain: The ground.
        robot: The robot that walks.
        q: Its angles at the start, from the ground's normal under x = 0, rad, the stance leg's first.
        dq: Their rates, rad/s.
        description: What `controller.describe()` gave.
        disturbances: What the walk is disturbed by.
    """

    terms: Terms
    controller: Controller
    terrain: Terrain
    robot: Robot
    q: tuple[float, ...]
    dq: tuple[float, ...]
    description: Mapping[str, Any]
    disturbances: Disturbances = UNDISTURBED

    def driven(self, period: float) -> Controller:
        """What drives the robot: the controller, in a loop that ticks where that is disturbed.

        Args:
            period: Time between two ticks, s.

        Raises:
            InputError: The delay does not fit the period.
        """
        controller = self.controller.driving(self.robot)
        if not self.disturbances.in_loop:
            return controller
        return SampledController(controller, self.disturbances, period)

    def arguments(self) -> dict[str, Any]:
        """What a simulation of either engine is made with, beside controller and terrain."""
        terms = self.terms
        return {
            "robot": self.robot,
            "q": self.q,
            "dq": self.dq,
            "steps": terms.steps,
            "distance": terms.distance,
            "scuffing": terms.scuffing,
            "pushes": self.disturbances.schedule,
        }

    def settings(self) -> dict[str, Any]:
        """All that is needed to repeat the walk, in plain JSON types, but for what its engine adds."""
        terms, source = self.terms, source_of(type(self.controller))
        return {
            "engine": terms.engine.name,
            "robot": self.robot.to_dict(),
            "controller": dict(self.description),
            **({} if source is None else {"controller_source": source}),
            "terrain": self.terrain.to_dict(),
            "initial": [*self.q, *self.dq],
            "steps": terms.steps,
            "distance": terms.distance,
            "sample_period": terms.sample_period,
            "scuffing": None if self.robot.knees else dict(_fields(terms.scuffing)),
            **({} if self.disturbances == UNDISTURBED else {"disturbances": self.disturbances.to_dict()}),
            "versions": dict(versions()),
        }


def make_plan(
    terms: Terms,
    controller: Controller,
    terrain: Terrain,
    initial: str | Sequence[float],
    description: Mapping[str, Any] | None = None,
    disturbances: Disturbances | None = None,
) -> Plan:
    """Check a controller, a terrain and an initial state, and put them together.

    Args:
        terms: The rest.
        controller: See `controllers.Controller`.
        terrain: The ground.
        initial: A name of `INITIAL_STATES`, or the robot's angles and rates.
        description: What this controller has said of itself in an earlier plan; it is not tried again then.
        disturbances: What the walk is disturbed by; None: by nothing.

    Raises:
        InputError: One of them is not what is expected, the scuffing rule would never let the gait land, the robot
            would start in the ground, the engine cannot make this walk, or the controller breaks its contract.
        GaitError: No passive gait exists on the slope under x = 0.
    """
    known = description is not None
    description = check_controller(controller) if description is None else description
    check_kind("terrain", terrain, Terrain)
    robot = next(robot for robot in (terms.robot, controller.robot, Compass()) if robot is not None)
    slope = terrain.slope_at(0.0)
    gait = controller.gait
    if gait is None and isinstance(initial, str) and initial == "gait":
        gait = _gait_of_slope(controller, robot, slope)
    q, dq = _initial_state(initial, robot, gait)
    if isinstance(gait, Gait):
        check_landing(gait, slope, terms.scuffing)
    _check_start(robot, terrain, q, terms.scuffing)
    disturbed = UNDISTURBED if disturbances is None else check_kind("disturbances", disturbances, Disturbances)
    plan = Plan(terms, controller, terrain, robot, q, dq, description, disturbed)
    driver = controller.driving(robot)
    if robot.knees and terms.scuffing != ScuffingRule():
        raise InputError(
            f"scuffing rule: a {type(robot).__name__} has knees, and its swing foot's contact is on from lift-off; "
            "leave the rule out"
        )
    if not isinstance(robot, terms.engine.robots):
        raise InputError(
            f"the engine {terms.engine.name} does not walk a {type(robot).__name__}; it walks "
            f"{', '.join(kind.__name__ for kind in terms.engine.robots)}"
        )
    terms.engine.check(plan)
    terms.engine.check_disturbances(disturbed)
    if not known:
        try_out(driver, q, dq)
    return plan


def check_robot(name: str, robot: object) -> None:
    """Refuse what is no robot.

    Raises:
        InputError: It is none.
    """
    if not isinstance(robot, Robot):
        raise InputError(
            f"{name} must be a mjbiped.Compass or a mjbiped.KneedBiped, got "
            f"{shown(robot) if isinstance(robot, str) else type(robot).__name__}"
        )


def _gait_of_slope(controller: Controller, robot: Robot, slope: float) -> Periodic:
    """The passive gait of a slope, for a controller that imitates none.

    Raises:
        GaitError: There is none.
    """
    try:
        return passive_gait_of(robot, slope)
    except GaitError as error:
        raise GaitError(
            f"{error}. {type(controller).__name__} imitates no gait that the walk could begin on: give "
            f'initial="rest" (--initial rest), or {_numbers_of(robot)}'
        ) from error


def check_controller(controller: object) -> dict[str, Any]:
    """Refuse what lacks a controller's parts; returns its description.

    Raises:
        InputError: A part is missing, fails, or is of another kind.
    """
    try:
        return _checked_parts(controller)
    except MjbipedError:
        raise
    except (Exception, SystemExit) as error:  # whatever its properties and `describe` do
        kind = type(controller)
        raise InputError(
            f"{kind.__name__} does not tell what it is: {explained(error)}{place_of(error, kind)}"
        ) from error


def _checked_parts(controller: object) -> dict[str, Any]:
    parts = ("states", "memory_size", "robot", "gait", "start", "on_touchdown", "torque", "slope_estimate", "describe")
    missing = [part for part in parts if not hasattr(controller, part)]
    if isinstance(controller, type) or missing:
        what = "is a class, not an object of it" if isinstance(controller, type) else f"lacks {', '.join(missing)}"
        raise InputError(f"the controller {shown(controller)} {what}; derive your class from controllers.Controller")
    named = type(controller).__name__
    states: Any = controller.states  # type: ignore[attr-defined]
    size: Any = controller.memory_size  # type: ignore[attr-defined]
    if not isinstance(states, tuple | list) or not all(isinstance(state, str) for state in states):
        raise InputError(f"{named}.states = {shown(states)}: must be a tuple of names")
    if MEMORY_SIZE.check(f"{named}.memory_size", size) < len(states):
        raise InputError(f"{named}.memory_size = {size}: must be at least its {len(states)} states")
    if controller.robot is not None:  # type: ignore[attr-defined]
        check_robot(f"{named}.robot", controller.robot)  # type: ignore[attr-defined]
    gait = controller.gait  # type: ignore[attr-defined]
    if gait is not None and not isinstance(gait, Gait | Branched):
        raise InputError(
            f"{named}.gait is of type {type(gait).__name__}; must be a gait that find_passive_gait, "
            "find_kneed_gait or find_reference gives"
        )
    told = controller.describe()  # type: ignore[attr-defined]
    try:
        return described(told)
    except ValueError as error:
        raise InputError(
            f"{named}.describe() must give what a record can hold and tell again, a table of plain JSON types with a "
            f"name: {error}"
        ) from error


def _numbers_of(robot: Robot) -> str:
    """The numbers of a first state, in words."""
    count = len(robot.angles)
    names = [f"{kind}{k + 1}" for kind in ("q", "dq") for k in range(count)]
    return f"{_WORDS[2 * count]} numbers {', '.join(names)}"


_WORDS = {4: "four", 6: "six"}


def _initial_state(
    initial: str | Sequence[float], robot: Robot, gait: Periodic | None
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Angles from the ground's normal (rad) and rates (rad/s) at the start, stance leg first.

    Raises:
        InputError: The name is unknown, or the numbers are not as many finite ones as the robot has.
    """
    count = len(robot.angles)
    if isinstance(initial, str):
        if initial == "rest":
            return (0.0,) * count, (0.0,) * count
        if initial == "gait" and gait is not None:
            start = tuple(float(value) for value in gait.start)
            return start[:count], start[count:]
        raise InputError(
            f"unknown initial state {shown(initial)}; valid are {', '.join(INITIAL_STATES)}, or {_numbers_of(robot)}"
        )
    try:
        numbers = tuple(check_states("initial", initial, (2 * count,)).tolist())
    except InputError as error:
        wanted = _numbers_of(robot).replace("numbers", "finite numbers")
        raise InputError(f"an initial state is {wanted}: {error}") from error
    return numbers[:count], numbers[count:]


def _check_start(robot: Robot, terrain: Terrain, q: tuple[float, ...], rule: ScuffingRule) -> None:
    """Refuse a start in the ground, from which there is no walk.

    A start in the early swing may be as deep in the ground as straight legs scuff, for the rule lets them. A robot with
    knees starts above it, and its swing knee is not bent forwards.

    Raises:
        InputError: The hip or the swing foot is under the ground, or the knee beyond its stop.
    """
    length, slope, z0 = robot.leg_length, terrain.slope_at(0.0), terrain.height_at(0.0)
    hip_x, hip_z = length * math.sin(q[0] + slope), z0 + length * math.cos(q[0] + slope)
    along, above = robot.swing_foot(q).tolist()
    foot_x = along * math.cos(slope) + above * math.sin(slope)
    foot_z = z0 + above * math.cos(slope) - along * math.sin(slope)
    scuffs = not robot.knees and foot_x < rule.reach * length
    posture = ", ".join(f"q{k + 1} = {angle:.4g}" for k, angle in enumerate(q))
    if robot.knees and q[2] < q[1]:
        raise InputError(f"initial state {posture}: the swing knee is bent forwards, beyond its stop; q3 >= q2")
    for part, x, z, deep in (
        ("hip", hip_x, hip_z, 0.0),
        ("swing foot", foot_x, foot_z, SCUFF if scuffs else _ON_GROUND),
    ):
        depth = terrain.height_at(x) - z
        if depth > deep * length:
            raise InputError(
                f"initial state {posture}: the {part} would start {depth:.3g} m under the "
                f"ground, at x = {x:.4g} m; with both feet on a plane q2 = -q1, and a swing foot behind the stance "
                "foot has q2 > q1"
            )


@lru_cache(maxsize=64)
def _fields(values: ScuffingRule) -> Mapping[str, Any]:
    return dataclasses.asdict(values)


@lru_cache(maxsize=1)
def versions() -> Mapping[str, str]:
    """Versions of everything that a walk's numbers depend on."""
    return {
        "mjbiped": __version__,
        "mujoco": mujoco.__version__,
        "numba": version("numba"),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
    }
