"""Plans of walks: arguments that are checked and combined before anything is computed."""

from __future__ import annotations

import dataclasses
import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.compiled import compilable_law
from mjbiped.control.controller import Controller, Law
from mjbiped.control.functions import try_out
from mjbiped.control.loading import source_of
from mjbiped.control.registry import driver_of
from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.disturbances.loop import SampledController
from mjbiped.engines.checks import check_controller, check_disturbed, check_ground, check_robot, check_rule
from mjbiped.engines.compiling import AHEAD
from mjbiped.errors import GaitError, InputError, shown
from mjbiped.gaits.described import passive_gait_of
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule, check_landing
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import check_fields, check_kind, check_states
from mjbiped.version import __version__

if TYPE_CHECKING:
    from mjbiped.engines.base import Engine

INITIAL_STATES = ("gait", "rest")
Initial: TypeAlias = str | Sequence[float] | NDArray[np.float64]
"""First state of a walk: a name out of `INITIAL_STATES`, or angles and rates."""

DEFAULT_STEPS = 60
DEFAULT_SAMPLE_PERIOD = 0.005  # s
SCUFF = (
    0.01  # leg lengths: greatest initial depth of a straight swing leg in the ground; passive gaits on 5° reach half
)
_ON_GROUND = 1e-6  # leg lengths: depth up to which a foot counts as on the ground


@dataclass(frozen=True)
class Terms:
    """Settings that several walks share; see `mjbiped.rollout.walk.walk` for the meanings.

    Attributes:
        engine: The engine that makes the walks.
        steps: Number of touchdowns; `DEFAULT_STEPS` if neither this nor a distance is given.
        distance: Position of the stance foot at which a walk is finished, m.
        robot: The robot that walks; None: that of the controller, or of Table I if it names none.
        sample_period: Time between two samples, s; None: no samples.
        scuffing: The scuffing rule.
        walks: Number of walks with these settings that are to be made; see `mjbiped.engines.compiling`.

    Raises:
        InputError: A value is outside its domain.
    """

    engine: Engine
    steps: Annotated[int | None, domains.STEPS]
    distance: Annotated[float | None, domains.DISTANCE]
    robot: Robot | None
    sample_period: Annotated[float | None, domains.Domain(1e-5, 1e4, "s")]
    scuffing: ScuffingRule
    walks: int = field(default_factory=AHEAD.get)

    def __post_init__(self) -> None:
        """Check what can be checked without a controller and a terrain."""
        if self.steps is None and self.distance is None:
            object.__setattr__(self, "steps", DEFAULT_STEPS)
        check_fields(self)
        if self.robot is not None:
            check_robot("robot", self.robot)


@dataclass(frozen=True)
class Plan:
    """One walk, checked and not yet started.

    Attributes:
        terms: Settings shared with other walks.
        controller: The controller as given by the user.
        driver: The controller that acts on this robot's joints for it; see `Controller.driving`.
        terrain: The ground.
        robot: The robot that walks.
        q: Initial angles from the ground's normal at x = 0, stance leg first, rad, shape (angles,).
        dq: Initial rates of the angles, rad/s, shape (angles,).
        description: The controller's description of itself; see `Controller.describe`.
        disturbances: Noise, delay, motor limits and pushes.
    """

    terms: Terms
    controller: Controller
    driver: Controller
    terrain: Terrain
    robot: Robot
    q: tuple[float, ...]
    dq: tuple[float, ...]
    description: Mapping[str, Any]
    disturbances: Disturbances = UNDISTURBED

    @cached_property
    def law(self) -> Law | None:
        """Compilable laws of the driver, without disturbances; None if its methods must be called."""
        return compilable_law(self.driver)

    def driven(self, period: float, *, ticks: bool = False) -> Controller:
        """Return the controller that an engine calls: the driver, in a loop that ticks if it or disturbances need one.

        Args:
            period: Time between two ticks, s.
            ticks: Whether the engine ticks by itself, so that a digital controller without disturbances needs no loop.

        Raises:
            InputError: The delay does not fit the period.
        """
        own, disturbances = ticks and self.driver.control_period is not None, self.disturbances
        needed = replace(disturbances, control_period=None) if own else disturbances
        return SampledController(self.driver, disturbances, period) if needed.in_loop else self.driver

    def settings(self) -> dict[str, Any]:
        """Settings that are needed to repeat the walk, without the engine's own, in plain JSON types."""
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
            "scuffing": None if self.robot.collides_from_lift_off else dataclasses.asdict(terms.scuffing),
            **({} if self.disturbances == UNDISTURBED else {"disturbances": self.disturbances.to_dict()}),
            "versions": dict(versions()),
        }


def make_plan(
    terms: Terms,
    controller: Controller,
    terrain: Terrain,
    initial: Initial,
    description: Mapping[str, object] | None = None,
    disturbances: Disturbances | None = None,
) -> Plan:
    """Check the arguments of a walk, and make a plan of them.

    Args:
        terms: Engine, robot and limits of the walk.
        controller: See `controllers.Controller`.
        terrain: The ground.
        initial: A name of `INITIAL_STATES`, or the robot's angles and rates.
        description: The controller's description from an earlier plan, which saves a second trial of its laws.
        disturbances: Noise, delay, motor limits and pushes; None: none.

    Raises:
        InputError: An argument is of the wrong kind, the scuffing rule would never let the gait land, the robot
            would start in the ground, the engine cannot make this walk, or the controller breaks its contract.
        GaitError: No passive gait exists on the slope under x = 0.
    """
    described = check_controller(controller) if description is None else description
    check_kind("terrain", terrain, Terrain)
    disturbed = UNDISTURBED if disturbances is None else check_kind("disturbances", disturbances, Disturbances)
    robot = next(robot for robot in (terms.robot, controller.robot, Compass()) if robot is not None)
    check_ground(robot, terrain)
    check_disturbed(robot, disturbed)
    driver = driver_of(controller, robot)
    if driver.control_period is not None:
        period = disturbed.period(driver.control_period, 0.0)
        disturbed = replace(disturbed, control_period=period)
    q, dq = _first_state(controller, robot, terrain, initial, terms.scuffing)
    check_rule(robot, terms.scuffing)
    if not isinstance(robot, terms.engine.robots):
        raise InputError(
            f"the engine {terms.engine.name} does not walk a {type(robot).__name__}; it walks "
            f"{', '.join(kind.__name__ for kind in terms.engine.robots)}"
        )
    plan = Plan(terms, controller, driver, terrain, robot, q, dq, described, disturbed)
    terms.engine.check(plan)
    terms.engine.check_disturbances(plan.disturbances)
    plan.disturbances.torque_limits(driver.joints)
    if description is None:
        try_out(driver, q, dq)
    return plan


def _numbers_of(robot: Robot) -> str:
    """Describe the numbers of an initial state in words, for messages."""
    names = [f"{kind}{k + 1}" for kind in ("q", "dq") for k in range(len(robot.angles))]
    return f"{ {2: 'two', 4: 'four', 6: 'six', 8: 'eight'}[len(names)] } numbers {', '.join(names)}"


def _first_state(
    controller: Controller, robot: Robot, terrain: Terrain, initial: Initial, rule: ScuffingRule
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the initial angles from the ground's normal, rad, and their rates, rad/s.

    Raises:
        InputError: The name is unknown, the numbers are not finite or too few or too many, the rule would never let
            the gait land, or the robot would start in the ground.
        GaitError: The controller imitates no gait, and the slope has no passive one.
    """
    slope, count = terrain.slope_at(0.0), len(robot.angles)
    gait = controller.gait
    if isinstance(initial, str):
        if initial not in INITIAL_STATES:
            valid = f"{', '.join(INITIAL_STATES)}, or {_numbers_of(robot)}"
            raise InputError(f"unknown initial state {shown(initial)}; valid are {valid}")
        if initial == "gait" and gait is None:
            try:
                gait = passive_gait_of(robot, slope)
            except GaitError as error:
                raise GaitError(
                    f"{error}. {type(controller).__name__} imitates no gait that the walk could begin on: give "
                    f'initial="rest" (--initial rest), or {_numbers_of(robot)}'
                ) from error
        start = [0.0] * 2 * count if initial == "rest" or gait is None else gait.start.tolist()
    else:
        try:
            start = check_states("initial", initial, (2 * count,)).tolist()
        except InputError as error:
            wanted = _numbers_of(robot).replace("numbers", "finite numbers")
            raise InputError(f"an initial state is {wanted}: {error}") from error
    if gait is not None and not gait.robot.collides_from_lift_off:
        check_landing(gait, slope, rule)
    q, dq = tuple(start[:count]), tuple(start[count:])
    _check_start(robot, terrain, q, rule)
    return q, dq


def _check_start(robot: Robot, terrain: Terrain, q: tuple[float, ...], rule: ScuffingRule) -> None:
    """Refuse an initial state with the hip or the swing foot in the ground, or a knee bent forwards.

    In early swing the foot of a straight leg may be up to `SCUFF` deep in the ground, as the scuffing rule allows.

    Raises:
        InputError: The hip or the swing foot is under the ground, or the knee beyond its stop.
    """
    length, slope, z0 = robot.leg_length, terrain.slope_at(0.0), terrain.height_at(0.0)
    hip_x, hip_z = length * math.sin(q[0] + slope), z0 + length * math.cos(q[0] + slope)
    along, *_, above = robot.swing_foot(q).tolist()
    foot_x = along * math.cos(slope) + above * math.sin(slope)
    foot_z = z0 + above * math.cos(slope) - along * math.sin(slope)
    scuffs = not robot.collides_from_lift_off and foot_x < rule.reach * length
    posture = ", ".join(f"q{k + 1} = {angle:.4g}" for k, angle in enumerate(q))
    if robot.flexion(robot.posture((0.0, 0.0), 0, q), 1) < 0.0:
        raise InputError(f"initial state {posture}: the swing knee is bent forwards, beyond its stop; q3 >= q2")
    deepest = SCUFF if scuffs else _ON_GROUND
    for part, x, z, deep in (("hip", hip_x, hip_z, 0.0), ("swing foot", foot_x, foot_z, deepest)):
        depth = terrain.height_at(x) - z
        if depth > deep * length:
            raise InputError(
                f"initial state {posture}: the {part} would start {depth:.3g} m under the "
                f"ground, at x = {x:.4g} m; with both feet on a plane q2 = -q1, and a swing foot behind the stance "
                "foot has q2 > q1"
            )


@lru_cache(maxsize=1)
def versions() -> Mapping[str, str]:
    """Versions of all software that a walk's numbers depend on."""
    software = ("mujoco", "numba", "numpy", "scipy")
    return {
        "mjbiped": __version__,
        **{name: version(name) for name in software},
        "python": platform.python_version(),
        "machine": platform.machine(),
    }
