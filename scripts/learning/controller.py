"""A learned policy as a controller, which walks by name wherever a command takes one.

On the command line: `--controller scripts/learning/controller.py:LearnedController --gain checkpoint=FILE`, and the
timestep it was trained with, `--timestep 0.004`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.control.controller import Memory
from mjbiped.controllers.slope_estimator import slope_change
from mjbiped.envs.policy import HELD, ActingController
from mjbiped.envs.tasks import WalkTask
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.rollouts import actions


@dataclass(frozen=True)
class LearnedController(ActingController):
    """Walks as the policy did in training: bitwise so with its engine, `WalkTask(...).engine`.

    The last number of the memory is the slope since the start, rad.

    Attributes:
        checkpoint: File that `scripts.learning.train` wrote.
    """

    checkpoint: str

    def __post_init__(self) -> None:
        """Read the policy.

        Raises:
            InputError: The file is none that the training wrote.
        """
        self._take(WalkTask("walk_level", residual=self._read.residual))
        object.__setattr__(self, "memory_size", self.memory_size + 1)

    @cached_property
    def _read(self) -> Checkpoint:
        return Checkpoint.load(Path(self.checkpoint))

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Reckon the slope, too."""
        super().on_touchdown(memory, q_before, q, dq)
        memory[-1] += slope_change(q_before[0], q[1])

    def action(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> list[float]:
        """Torques of the policy's action, N m."""
        after = memory[self.task.controller.memory_size + HELD + 2 * len(q)]  # stance angle after the last touchdown
        told = (np.array([each]) for each in (q, dq, t, after, memory[-1]))
        torques: list[float] = (actions(self._read.weights[None], *told)[0] * self.task.limits).tolist()
        return torques

    def slope_estimate(self, memory: Memory) -> float:
        """The adaptive controller's where the policy is a residual; else the slope since the start, rad."""
        estimate = super().slope_estimate(memory)
        return memory[-1] if np.isnan(estimate) else estimate

    def describe(self) -> dict[str, Any]:
        """Name, the policy's file and its digest, and the task's controller."""
        digest = hashlib.sha256(self._read.weights.tobytes()).hexdigest()[:16]
        return {
            "name": type(self).__name__,
            "checkpoint": self.checkpoint,
            "digest": digest,
            "driven": self.task.controller.describe(),
        }
