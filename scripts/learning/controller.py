"""A learned policy as a controller, which walks by name wherever a command takes one.

On the command line: `--controller scripts/learning/controller.py:LearnedController --gain checkpoint=FILE`, and the
timing it was trained with, `--control-period 0.02 --timestep 0.004`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.control.controller import Controller, Memory
from mjbiped.controllers.slope_estimator import slope_change
from mjbiped.envs.driven import DrivenController
from mjbiped.envs.tasks import WalkTask
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.policy import Array, actions


@dataclass(frozen=True)
class LearnedController(Controller):
    """Walks as the policy did in training: bitwise so with its engine, `WalkTask(...).engine`.

    The memory holds that of the task's controller, then the new stance leg's angle after the last touchdown and the
    slope since the start.

    Attributes:
        checkpoint: File that `scripts.learning.train` wrote.
    """

    checkpoint: str
    _driven: DrivenController = field(init=False, repr=False)
    _weights: Array = field(init=False, repr=False, compare=False)
    _most: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Read the policy.

        Raises:
            InputError: The file is none that the training wrote.
        """
        read = Checkpoint.load(Path(self.checkpoint))
        task = WalkTask("walk_level", residual=read.residual)
        driven = task.controller
        for name, value in {
            "states": driven.states,
            "memory_size": driven.memory_size + 2,
            "robot": task.model,
            "gait": task.gait,
            "_driven": driven,
            "_weights": read.weights,
            "_most": np.array(task.limits),
        }.items():
            object.__setattr__(self, name, value)

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin as the task's controller does."""
        self._driven.start(memory, q, dq)

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Let the task's controller take notice, and reckon the slope."""
        self._driven.on_touchdown(memory, q_before, q, dq)
        memory[-2] = q[0]
        memory[-1] += slope_change(q_before[0], q[1])

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """What the task's controller does with the policy's action."""
        told = actions(
            self._weights[None],
            np.array([q]),
            np.array([dq]),
            np.array([t]),
            np.array([memory[-2]]),
            np.array([memory[-1]]),
        )
        given = [*memory[: self._driven.place], *(told[0] * self._most).tolist()]
        return self._driven.torque(given, t, q, dq)

    def slope_estimate(self, memory: Memory) -> float:
        """The adaptive controller's where the policy is a residual; else the slope since the start, rad."""
        estimate: float = self._driven.slope_estimate(memory)
        return memory[-1] if np.isnan(estimate) else estimate

    def describe(self) -> dict[str, Any]:
        """Name, the policy's file and its digest, and the task's controller."""
        digest = hashlib.sha256(self._weights.tobytes()).hexdigest()[:16]
        return {
            "name": type(self).__name__,
            "checkpoint": self.checkpoint,
            "digest": digest,
            "driven": self._driven.describe(),
        }
