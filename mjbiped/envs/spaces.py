"""What Gymnasium's environments have in common: spaces, and robots' numbers as observations and infos."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.envs import feeling
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import HIGHEST, SEEN, Walkers
from mjbiped.errors import MjbipedError

try:
    from gymnasium import spaces
except ModuleNotFoundError as error:
    raise MjbipedError("Gymnasium is not installed: pip install 'mjbiped[gym]'") from error

TERMS = {"reward_progress": feeling.PROGRESS, "reward_economy": feeling.ECONOMY, "x_position": feeling.HIP_X}
"""Entries of `info`, by their indices in `feeling`."""


def action_space() -> Any:
    """Ankle and hip torque, as parts of the greatest."""
    return spaces.Box(-1.0, 1.0, (2,), np.float32)


def observation_space(task: WalkTask) -> Any:
    """What is felt, and where the task is privileged, the ground."""
    seen = SEEN if task.privileged else 0
    low, high = ([*felt, *[end] * seen] for felt, end in ((feeling.LOWEST, -HIGHEST), (feeling.HIGHEST, HIGHEST)))
    return spaces.Box(np.array(low), np.array(high), dtype=np.float64)


def observations(walkers: Walkers) -> NDArray[np.float64]:
    """Of all robots, shape (robots, size of the space)."""
    felt = walkers.felt
    if not walkers.task.privileged:
        return felt.copy()
    return np.column_stack([felt, [walkers.ground_seen(index) for index in range(len(felt))]])


def info_of(walkers: Walkers, index: int) -> dict[str, Any]:
    """`info` of one robot."""
    told: dict[str, Any] = {name: float(walkers.value(at)[index]) for name, at in TERMS.items()}
    told["outcome"] = walkers.outcome(index).words
    return told
