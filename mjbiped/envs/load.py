"""Loading of a task as an environment of dm_control."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from mjbiped.envs.tasks import task_of
from mjbiped.envs.walkers import Walkers
from mjbiped.errors import MjbipedError
from mjbiped.robots.compass import Compass
from mjbiped.utils.domains import SEED, known_name

if TYPE_CHECKING:
    import dm_env


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
    settings, dm = task_of(task, Compass.kind, given), _dm()
    walkers = Walkers(settings, scenery=True)
    walkers.begin(0, np.random.default_rng(0))  # so that there is a model; `reset` begins anew
    physics = dm.Physics(walkers)
    return dm.control.Environment(physics, dm.Task(settings, random), time_limit=settings.time_limit, **options)


def _dm() -> ModuleType:
    """Import `mjbiped.envs.dm`, which needs dm_control.

    Raises:
        MjbipedError: dm_control is not installed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # GLFW's, where there is no display
            from mjbiped.envs import dm
    except ModuleNotFoundError as error:
        raise MjbipedError(
            f"mjbiped.envs.load needs dm_control, and {error.name} is not installed: pip install dm-control. Where its "
            "labmaze cannot be installed (Python 3.13), pip install --no-deps dm-control dm-env, and dm-tree absl-py "
            "glfw lxml pyopengl pyparsing, are enough. The environments of Gymnasium need none of it: "
            "pip install 'mjbiped[gym]'"
        ) from error
    return dm
