"""Settings of an environment (`WalkTask`): task, actions and torque limits; and the tasks' names in Gymnasium."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np

from mjbiped.control.registry import driver_of, make_controller
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.checks import check_controller
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.mujoco.options import LONGEST_TIMESTEP
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan, Terms, make_plan
from mjbiped.engines.space.mujoco import PLAIN
from mjbiped.envs.driven import DrivenController
from mjbiped.envs.recipes import TASKS, Curriculum, Recipe, disturbances_recipe, robot_recipe, terrain_recipe
from mjbiped.errors import InputError, shown
from mjbiped.gaits.described import usual_gait
from mjbiped.gaits.gait import Gait
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.draws import Number

IDS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        f"mjbiped/{kind}Walk{ground}-v0": (f"walk_{ground.lower() or 'level'}", kind.lower())
        for kind in ("Compass", "Kneed")
        for ground in ("", "Slopes", "Stairs", "Random")
    }
)
"""Tasks and robots by their names in Gymnasium."""

IN_SPACE: Mapping[str, str] = MappingProxyType(
    {f"mjbiped/{name}-v0": name.lower() for name in ("Compass3D", "Abducting3D", "Kneed3D")}
)
"""Robots in space by the names of their environments in Gymnasium."""

PEAK: Mapping[str, float] = MappingProxyType(
    {"ankle": 35.55, "hip": 23.7, "knee": 35.55, "abduction": 23.7, "ankle_roll": 35.55}
)
"""Greatest torques of the motors, N m: those of the knees (35.55) and hips of Unitree's Go1, a walking robot of 12 kg
(`forcerange` in unitree_go1/go1.xml of MuJoCo Menagerie). They are for the robot of Table I, and are in proportion to
weight and leg length for others."""

TORQUE = 3.0
"""`PEAK` over what an action can ask for: somewhat more than the adaptive controller asks for on the tasks' grounds
(10 and 3.2 N m), and little enough that a policy which knows nothing yet does not throw the robot."""

RESIDUAL = 10.0
"""`PEAK` over what an action can add to the adaptive controller's torques."""

CONTROL_PERIOD = 0.02  # s
TIME_LIMIT = 20.0  # of an episode, s
TIMESTEP = LONGEST_TIMESTEP
"""Longest physics step, s: at 4 ms c_mt errs by 0.03 % (docs/physics.md)."""
KNEES_TIMESTEP, KNEES_TICK = 2e-3, 4e-3
"""Longest physics step, and time between two ticks of the controller, of robots with knees, s: their shanks are light,
and with torques held for 20 ms the adaptive controller falls on the first steps."""
SPACE_TICK = 2e-3
"""Time between two ticks of the controller of robots in space, s, whose roll is unstable."""
DISTURBANCE = 0.05  # of the rates at an episode's start, as a part of them
IMITATED_DEG = 2.0  # slope of the passive gait on which episodes begin, degrees
_CONTROL_PERIOD = domains.Domain(TIMESTEP, 1.0, "s")  # what is recorded in a longer one would find no room
_SHORTEST_STEP = ScuffingRule().delay  # no step of a walk is shorter, s


class Episode(NamedTuple):
    """What an episode begins with.

    Attributes:
        robot: The robot that walks.
        terrain: The ground.
        disturbances: Of its control loop, pushes and friction.
        start: First angles (rad) and rates (rad/s).
        drawn: Numbers that were drawn for the episode, by names such as "robot.leg_mass".
    """

    robot: Robot
    terrain: Terrain
    disturbances: Disturbances
    start: tuple[float, ...]
    drawn: Mapping[str, Number]


@dataclass(frozen=True)
class WalkTask:
    """A task for a learner.

    Robot, terrain and disturbances may have distributions in the place of numbers, {"uniform": [4, 5]} for instance,
    from which each episode draws; `mjbiped.envs.recipes` reads them.

    Attributes:
        name: One of `TASKS`.
        residual: Whether actions are added to the torques of the adaptive controller; otherwise they act alone.
        privileged: Whether the terrain is observed too.
        robot: The robot that walks: an object, a name such as "kneed", or a table of parameters. The adaptive
            controller knows the robot with the medians of what is drawn.
        terrain: Parameters of the task's preset that replace the default ones, a preset's name, a terrain, or a
            `Curriculum`. Random ground whose seed is not given is another one in each episode.
        disturbances: Disturbances, or a table of them; noise and pushes whose seed is not given are others in each
            episode.
        control_period: Time between two actions, s, a multiple of the timestep 4 ms, at most 1 s.
        time_limit: Longest episode, s.

    Raises:
        InputError: A value is outside its domain.
    """

    name: str
    residual: bool = False
    privileged: bool = False
    robot: Robot | str | Mapping[str, object] = Compass.kind
    terrain: Terrain | str | Mapping[str, object] | Curriculum = field(default_factory=dict)
    disturbances: Disturbances | Mapping[str, object] | None = None
    control_period: Annotated[float, _CONTROL_PERIOD] = CONTROL_PERIOD
    time_limit: Annotated[float, domains.TIME] = TIME_LIMIT

    def __post_init__(self) -> None:
        """Check all settings before the first episode."""
        domains.known_name("task", self.name, TASKS)
        for name in ("residual", "privileged"):
            if not isinstance(getattr(self, name), bool):
                raise InputError(f"{name} = {shown(getattr(self, name))}: must be True or False")
        domains.check_fields(self)
        for recipe in (*self._recipes, terrain_recipe(self.terrain, self.name, 1.0)):
            recipe.check()
        if "hip" not in self.model.joints:
            raise InputError(f"robot: a {type(self.model).__name__} has no legs to walk with; give compass or kneed")
        _ = self.ticks

    @cached_property
    def _recipes(self) -> tuple[Recipe[Robot], Recipe[Terrain], Recipe[Disturbances]]:
        """How robot, terrain and disturbances are made."""
        return robot_recipe(self.robot), terrain_recipe(self.terrain, self.name), disturbances_recipe(self.disturbances)

    @cached_property
    def model(self) -> Robot:
        """Robot that the controller knows: parameters that are drawn have their medians."""
        return self._recipes[0].middle

    @cached_property
    def engine(self) -> Mujoco:
        """Engine of the task; its control period is the time between two ticks of the controller."""
        usual, timestep = self.control_period, TIMESTEP
        if "knee" in self.model.joints:
            usual, timestep = KNEES_TICK, KNEES_TIMESTEP
        if "ankle_roll" in self.model.joints:
            usual, timestep = SPACE_TICK, PLAIN
        return Mujoco(timestep=timestep, control_period=self._recipes[2].middle.control_period or usual)

    @cached_property
    def ticks(self) -> int:
        """Ticks of the controller while an action is held.

        Raises:
            InputError: They do not fit the time between two actions.
        """
        tick = self.engine.control_period or self.control_period
        ticks = round(self.control_period / tick)
        if ticks < 1 or abs(ticks * tick - self.control_period) > 1e-6 * tick:
            raise InputError(
                f"control_period = {self.control_period:g}: must be a multiple of the time between two ticks of the "
                f"controller, {tick:g} s"
            )
        return ticks

    @cached_property
    def peak(self) -> tuple[float, ...]:
        """Greatest torques of the motors, N m."""
        usual = Compass()
        size = self.model.weight * self.model.leg_length / (usual.weight * usual.leg_length)
        return tuple(PEAK[joint] * size for joint in self.model.joints)

    @cached_property
    def limits(self) -> tuple[float, ...]:
        """Greatest torques of an action, N m."""
        return tuple(peak / (RESIDUAL if self.residual else TORQUE) for peak in self.peak)

    @property
    def max_steps(self) -> int:
        """Control periods of the longest episode."""
        return max(1, round(self.time_limit / self.control_period))

    @cached_property
    def gait(self) -> Gait:
        """Gait with which episodes begin."""
        return _gait(self.model)

    @property
    def target_speed(self) -> float:
        """Speed at which the reward's first term is full, m/s: that of the gait."""
        return float(self.gait.step_length / self.gait.period)

    def episode(self, random: np.random.Generator, difficulty: float = 0.0) -> Episode:
        """Draw an episode.

        Args:
            random: Generator; the same state of it gives the same episode.
            difficulty: Difficulty of the ground, from 0 to 1, where `terrain` is a `Curriculum`.

        Raises:
            InputError: A number is outside its domain; of a normal distribution it can be.
        """
        robot, terrain, disturbances = self._recipes
        told: dict[str, Number] = {}
        if isinstance(self.terrain, Curriculum):
            terrain, told = terrain_recipe(self.terrain, self.name, difficulty), {"terrain.difficulty": difficulty}
        draws = sorted({**robot.draws, **terrain.draws, **disturbances.draws}.items())
        drawn = {name: draw.value(random) for name, draw in draws}
        stance, swing = random.uniform(1.0 - DISTURBANCE, 1.0 + DISTURBANCE, 2).tolist()
        factors = [*[1.0] * len(self.limits), stance, *[swing] * (len(self.limits) - 1)]
        start = tuple((self.gait.start * factors).tolist())
        return Episode(robot.made(drawn), terrain.made(drawn), disturbances.made(drawn), start, {**drawn, **told})

    @cached_property
    def controller(self) -> DrivenController:
        """Controller that the actions drive."""
        name, gait = ("adaptive", self.gait) if self.residual else ("passive", None)
        base = driver_of(make_controller(name, self.model, {}, gait), self.model)
        return DrivenController(base, self.limits, self.peak)

    @cached_property
    def _description(self) -> dict[str, object]:
        return check_controller(self.controller)

    def plan(self, episode: Episode, *, recorded: bool) -> Plan:
        """Plan of the walk of an episode, as `mjbiped.walk` would check it.

        Args:
            episode: What was drawn for it.
            recorded: Whether samples are kept.
        """
        robot, terrain, disturbances, start, _ = episode
        period, most = DEFAULT_SAMPLE_PERIOD if recorded else None, math.ceil(self.time_limit / _SHORTEST_STEP) + 1
        terms = Terms(self.engine, most, None, robot, period, ScuffingRule())
        return make_plan(terms, self.controller, terrain, start, self._description, disturbances)


def task_of(name: str, kind: str, settings: Mapping[str, Any]) -> WalkTask:
    """Make the task of a name; settings that are None have their defaults.

    Args:
        name: One of `TASKS`.
        kind: Name of the robot where the setting `robot` does not give it.
        settings: Other fields of `WalkTask` by their names.

    Raises:
        InputError: There is no such setting, or its value is outside its domain.
    """
    for key in settings:
        domains.known_name("setting", key, [field.name for field in fields(WalkTask)][1:])
    given = {key: value for key, value in settings.items() if value is not None}
    robot = given.setdefault("robot", kind)
    if isinstance(robot, Mapping):
        given["robot"] = {"kind": kind, **robot}
    return WalkTask(name, **given)


def planar_task(name: str, kind: str, settings: Mapping[str, Any]) -> WalkTask:
    """Make a task as `task_of` does, of a planar robot.

    Raises:
        InputError: The robot moves in space, or as `task_of`.
    """
    task = task_of(name, kind, settings)
    if task.model.runs:
        raise InputError(
            f"robot: a {type(task.model).__name__} moves in space, and this environment is of planar robots; walk in "
            f"{', '.join(IN_SPACE)}"
        )
    return task


@lru_cache(maxsize=16)
def _gait(robot: Robot) -> Gait:
    return usual_gait(robot, math.radians(IMITATED_DEG))
