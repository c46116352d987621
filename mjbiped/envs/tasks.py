"""The tasks: their grounds, actions and observations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from mjbiped.control.registry import make_controller
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.mujoco.options import LONGEST_TIMESTEP
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan, Terms, check_controller, make_plan
from mjbiped.envs.driven import DrivenController, Pair
from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains

TASKS: Mapping[str, tuple[str, Mapping[str, Any]]] = MappingProxyType(
    {
        "walk_level": ("level", {}),
        "walk_slopes": ("slopes", {}),
        "walk_stairs": ("stairs", {"rise": -0.02}),
        "walk_random": ("random", {"length": 15.0}),
    }
)
"""The terrain's preset and parameters by the task's name; random ground is another one in each episode."""

IDS: Mapping[str, str] = MappingProxyType(
    {
        "mjbiped/CompassWalk-v0": "walk_level",
        "mjbiped/CompassWalkSlopes-v0": "walk_slopes",
        "mjbiped/CompassWalkStairs-v0": "walk_stairs",
        "mjbiped/CompassWalkRandom-v0": "walk_random",
    }
)
"""Tasks by their names in Gymnasium."""

PEAK: Pair = (35.55, 23.7)
"""Greatest torque of the ankle's and of the hip's motor, N m: what the knee's and the hip's motor of Unitree's Go1
give, a walking robot of 12 kg (`forcerange` in unitree_go1/go1.xml of MuJoCo Menagerie)."""

TORQUE: Pair = (PEAK[0] / 3.0, PEAK[1] / 3.0)
"""Greatest ankle and hip torque of an action, N m: somewhat more than the adaptive controller asks for on the tasks'
grounds (10 and 3.2 N m), and little enough that a policy which knows nothing yet does not throw the robot."""

RESIDUAL: Pair = (PEAK[0] / 10.0, PEAK[1] / 10.0)
"""Greatest ankle and hip torque of an action that is added to the adaptive controller's, N m."""

CONTROL_PERIOD = 0.02  # s
TIME_LIMIT = 20.0  # of an episode, s
TIMESTEP = LONGEST_TIMESTEP
"""Longest physics step, s: at 4 ms c_mt errs by 0.03 % (docs/step_size.md)."""
DISTURBANCE = 0.05  # of the rates at an episode's start, as a part of them
IMITATED_DEG = 2.0  # slope of the passive gait on which episodes begin, degrees
AHEAD = tuple(0.1 * step for step in range(1, 11))
"""Places of the ground that a privileged observation shows, ahead of the stance foot, in leg lengths."""
_CONTROL_PERIOD = domains.Domain(TIMESTEP, 1.0, "s")  # what is recorded in a longer one would find no room
_SHORTEST_STEP = ScuffingRule().delay  # no step of a walk is shorter, s


@dataclass(frozen=True)
class WalkTask:
    """A task for a learner.

    Attributes:
        name: One of `TASKS`.
        residual: Whether actions are added to the torques of the adaptive controller; otherwise they act alone.
        privileged: Whether the terrain is observed too.
        terrain: Parameters of the task's preset that replace the default ones, or a terrain.
        control_period: Time between two actions, s, a multiple of the timestep 4 ms, at most 1 s.
        time_limit: Longest episode, s.

    Raises:
        InputError: A value is outside its domain.
    """

    name: str
    residual: bool = False
    privileged: bool = False
    terrain: Terrain | Mapping[str, Any] = field(default_factory=dict)
    control_period: float = CONTROL_PERIOD
    time_limit: float = TIME_LIMIT

    def __post_init__(self) -> None:
        """Check all settings before the first episode."""
        domains.known_name("task", self.name, TASKS)
        for name in ("residual", "privileged"):
            if not isinstance(getattr(self, name), bool):
                raise InputError(f"{name} = {shown(getattr(self, name))}: must be True or False")
        if not isinstance(self.terrain, Terrain | Mapping):
            raise InputError(
                f"terrain = {shown(self.terrain)}: must be a Terrain, or a dictionary of parameters of the preset "
                f"{TASKS[self.name][0]}"
            )
        domains.check_fields(self, time_limit=domains.TIME, control_period=_CONTROL_PERIOD)
        _ = self.engine
        self.ground(np.random.default_rng(0))

    @cached_property
    def engine(self) -> Mujoco:
        """Engine of the task."""
        return Mujoco(timestep=TIMESTEP, control_period=self.control_period)

    @property
    def limits(self) -> Pair:
        """Greatest ankle and hip torque of an action, N m."""
        return RESIDUAL if self.residual else TORQUE

    @property
    def max_steps(self) -> int:
        """Control periods of the longest episode."""
        return max(1, round(self.time_limit / self.control_period))

    @cached_property
    def gait(self) -> Gait:
        """Gait with which episodes begin."""
        return _gait()

    @property
    def target_speed(self) -> float:
        """Speed at which the reward's first term is full, m/s: that of the gait."""
        return float(self.gait.step_length / self.gait.period)

    def ground(self, random: np.random.Generator) -> Terrain:
        """Terrain of an episode.

        Args:
            random: Generator that draws the seed of a ground that differs from episode to episode.

        Raises:
            InputError: A parameter is outside its domain.
        """
        if not self.redrawn:
            return self._only_ground
        return self._preset(seed=int(random.integers(2**31)))

    @cached_property
    def _only_ground(self) -> Terrain:
        """Terrain of all episodes."""
        return self.terrain if isinstance(self.terrain, Terrain) else self._preset()

    def _preset(self, **drawn: int) -> Terrain:
        assert not isinstance(self.terrain, Terrain)
        preset, own = TASKS[self.name]
        return Terrain.preset(preset, **{**own, **self.terrain, **drawn})

    @property
    def redrawn(self) -> bool:
        """Whether each episode has a ground of its own."""
        return not isinstance(self.terrain, Terrain) and self.name == "walk_random" and "seed" not in self.terrain

    def start(self, random: np.random.Generator) -> tuple[float, float, float, float]:
        """Angles (rad) and rates (rad/s) at an episode's start: the gait's, with disturbed rates."""
        q1, q2, dq1, dq2 = self.gait.start.tolist()
        first, second = random.uniform(1.0 - DISTURBANCE, 1.0 + DISTURBANCE, 2).tolist()
        return q1, q2, dq1 * first, dq2 * second

    @cached_property
    def controller(self) -> DrivenController:
        """Controller that the actions drive."""
        robot = self.gait.robot
        settings = {"imitate_slope_deg": IMITATED_DEG} if self.residual else {}
        base = make_controller("adaptive" if self.residual else "passive", robot, settings)
        return DrivenController(base, self.limits, PEAK)

    @cached_property
    def _description(self) -> dict[str, Any]:
        return check_controller(self.controller)

    def plan(self, terrain: Terrain, start: tuple[float, float, float, float], *, recorded: bool) -> Plan:
        """Plan of the walk of an episode, as `mjbiped.walk` would check it.

        Args:
            terrain: The ground.
            start: First angles (rad) and rates (rad/s).
            recorded: Whether samples are kept.
        """
        terms = Terms(
            self.engine,
            math.ceil(self.time_limit / _SHORTEST_STEP) + 1,
            None,
            self.gait.robot,
            DEFAULT_SAMPLE_PERIOD if recorded else None,
            ScuffingRule(),
        )
        return make_plan(terms, self.controller, terrain, start, self._description)


@lru_cache(maxsize=1)
def _gait() -> Gait:
    return find_passive_gait(Compass(), math.radians(IMITATED_DEG))
