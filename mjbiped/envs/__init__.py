"""Environments for learners: the biped on level and rough ground, for dm_control and for Gymnasium.

`load` gives an environment of dm_control. Importing this package registers the same tasks with Gymnasium, where that is
installed. docs/environments.md says what is observed, done and rewarded.
"""

from mjbiped.envs.load import load
from mjbiped.envs.registration import IDS, register
from mjbiped.envs.tasks import TASKS, WalkTask

__all__ = ["IDS", "TASKS", "WalkTask", "load"]

register()
