"""Environments for learners: the biped on level and rough ground, for dm_control and for Gymnasium.

`load` gives an environment of dm_control. Importing this package registers the same tasks with Gymnasium, where that is
installed. docs/environments.md describes observations, actions and rewards.
"""

import importlib.util

# before dm_control, which imports MuJoCo as MUJOCO_GL has it
from mjbiped.utils.mujoco import mujoco as mujoco  # isort: split

from mjbiped.envs.load import load
from mjbiped.envs.recipes import TASKS
from mjbiped.envs.tasks import IDS, WalkTask

__all__ = ["IDS", "TASKS", "WalkTask", "load"]

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
