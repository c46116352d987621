"""The tasks' names in Gymnasium."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from types import MappingProxyType

from mjbiped.envs.tasks import WalkTask

IDS: Mapping[str, str] = MappingProxyType(
    {
        "mjbiped/CompassWalk-v0": "walk_level",
        "mjbiped/CompassWalkSlopes-v0": "walk_slopes",
        "mjbiped/CompassWalkStairs-v0": "walk_stairs",
        "mjbiped/CompassWalkRandom-v0": "walk_random",
    }
)
"""Tasks by their names in Gymnasium."""


def register() -> None:
    """Let `gymnasium.make` and `gymnasium.make_vec` know the tasks, where Gymnasium is installed."""
    if importlib.util.find_spec("gymnasium") is None:
        return
    import gymnasium

    for name, task in IDS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="mjbiped.envs.single:CompassWalkEnv",
                vector_entry_point="mjbiped.envs.vector:CompassWalkVectorEnv",
                max_episode_steps=WalkTask(task).max_steps,
                kwargs={"task": task},
            )
