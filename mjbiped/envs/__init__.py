"""Environments for learners: the biped on level and rough ground, for dm_control and for Gymnasium.

`load` gives an environment of dm_control. Importing this package registers the same tasks with Gymnasium, where that is
installed. docs/environments.md describes observations, actions and rewards.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

# before dm_control, which imports MuJoCo as MUJOCO_GL has it
from mjbiped.utils.mujoco import mujoco as mujoco  # isort: split

from mjbiped.envs.policy import PolicyController, export_policy
from mjbiped.envs.recipes import TASKS, Curriculum
from mjbiped.envs.tasks import IDS, IN_SPACE, WalkTask, planar_task
from mjbiped.envs.walkers import Walkers
from mjbiped.robots.compass import Compass
from mjbiped.utils.domains import SEED, known_name

if TYPE_CHECKING:
    import dm_env

__all__ = ["IDS", "IN_SPACE", "TASKS", "Curriculum", "PolicyController", "WalkTask", "export_policy", "load"]

if importlib.util.find_spec("gymnasium") is not None:
    import gymnasium

    for name, (task, kind) in IDS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="mjbiped.envs.single:WalkEnv",
                vector_entry_point="mjbiped.envs.vector:WalkVectorEnv",
                kwargs={"task": task, "kind": kind},
            )
    for name, kind in IN_SPACE.items():
        if name not in gymnasium.registry:
            gymnasium.register(id=name, entry_point="mjbiped.envs.space:SpaceEnv", kwargs={"kind": kind})


def load(
    task: str,
    task_kwargs: Mapping[str, object] | None = None,
    environment_kwargs: Mapping[str, object] | None = None,
) -> dm_env.Environment:
    """Make an environment of dm_control, as `dm_control.suite.load` does.

    ```python
    env = mjbiped.envs.load("walk_random", task_kwargs={"residual": True, "random": 7})
    time_step = env.reset()
    while not time_step.last():
        time_step = env.step([0.0, 0.0])  # ankle and hip torque to be added, N m
    print(env.physics.walk().cost_of_transport)
    ```

    Args:
        task: "walk_level", "walk_slopes", "walk_stairs" or "walk_random".
        task_kwargs: Fields of `mjbiped.envs.WalkTask` but its name, and `random`: a seed, or a
            `numpy.random.RandomState`; the same seed gives the same episodes. Without it they differ from time to time.
            `{"robot": "kneed"}` walks with knees.
        environment_kwargs: `flat_observation`: whether observations are one array.

    Returns:
        A `dm_control.rl.control.Environment`; its `physics` is a `mjbiped.envs.dm.Physics`.

    Raises:
        InputError: A name is unknown, or a value is outside its domain.
        MjbipedError: dm_control is not installed.
    """
    given, options = dict(task_kwargs or {}), dict(environment_kwargs or {})
    random = given.pop("random", None)
    if not isinstance(random, np.random.RandomState | None):
        random = SEED.check("random", random)
    for key in options:
        known_name("entry of environment_kwargs", key, ("flat_observation",))
    settings = planar_task(task, Compass.kind, given)
    from mjbiped.envs import dm  # for this function alone: it says what to install where dm_control is missing

    from dm_control.rl import control  # isort: skip

    walkers = Walkers(settings, scenery=True)
    walkers.begin(0, np.random.default_rng(0))  # so that there is a model; `reset` begins anew
    physics = dm.Physics(walkers)
    return control.Environment(physics, dm.Task(settings, random), time_limit=settings.time_limit, **options)
