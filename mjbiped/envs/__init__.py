"""Environments for learners: the biped on level and rough ground, for dm_control and for Gymnasium.

`load` gives an environment of dm_control. Importing this package registers the same tasks with Gymnasium, where that is
installed. docs/environments.md describes observations, actions and rewards.
"""

import importlib.util

# before dm_control, which imports MuJoCo as MUJOCO_GL has it
from mjbiped.utils.mujoco import mujoco as mujoco  # isort: split

from mjbiped.envs.load import load
from mjbiped.envs.tasks import IDS, TASKS, WalkTask

__all__ = ["IDS", "TASKS", "WalkTask", "load"]

if importlib.util.find_spec("gymnasium") is not None:
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
