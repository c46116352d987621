"""Returns of many policies at once: a robot for each policy and ground, in compiled threads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mjbiped.controllers.policy import FEATURES, LATEST, action
from mjbiped.controllers.slope_estimator import slope_change
from mjbiped.envs import observation
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.records.record import Walk
from mjbiped.utils.parallel import cores

Array = NDArray[np.float64]

WEIGHTS = (2, 2, len(FEATURES))
"""Shape of a policy: action (ankle, hip); constant part and part that goes with time; feature."""


def actions(
    weights: Array, angles: Array, rates: Array, time: Array, stance_after_touchdown: Array, slope: Array
) -> Array:
    """Torque of ankle and hip as parts of the greatest, shape (robots, 2); the task cuts off what is beyond 1.

    Args:
        weights: A policy for each robot, shape (robots, *`WEIGHTS`).
        angles: Stance and swing leg from the ground's normal under the stance foot, rad, shape (robots, 2).
        rates: Theirs, rad/s, shape (robots, 2).
        time: Since the touchdown, s, shape (robots,).
        stance_after_touchdown: Angle of the new stance leg just after it, rad; zero before the first; shape (robots,).
        slope: Of the ground since the start, rad, shape (robots,).
    """
    each = weights.reshape(len(weights), -1).T
    (q1, q2), (dq1, dq2) = angles.T, rates.T
    told = action(each, np.minimum(time, LATEST), q1, q2, dq1, dq2, stance_after_touchdown, slope)
    return np.stack(told, axis=1)


class Rollouts:
    """Robots that walk an episode each, by a policy each.

    Each walks bitwise as in the task's Gymnasium environment. That resets a robot as soon as it has fallen, which
    costs 6 ms for its new ground; here it lies until the last one is done.

    Attributes:
        steps: Control periods that robots have walked so far.
    """

    def __init__(self, task: WalkTask, robots: int, *, threads: int | None = None, recorded: bool = False) -> None:
        """Make room.

        Args:
            task: What they are to do.
            robots: Policies times grounds of each call of `returns`.
            threads: That step at a time; by default as many as there are cores.
            recorded: Whether the samples of walks are kept, for `walks`.
        """
        self._task, self._robots = task, robots
        self._walkers = Walkers(task, robots, threads=cores() if threads is None else threads, recorded=recorded)
        self._most = np.array(task.limits)
        self.steps = 0

    def returns(self, weights: Array, seeds: Sequence[Sequence[int]]) -> Array:
        """Sum of the rewards of an episode of each policy on each ground, shape (policies, grounds).

        Args:
            weights: Shape (policies, *`scripts.learning.rollouts.WEIGHTS`).
            seeds: Of ground and start, the same for all policies.
        """
        walkers, shape = self._walkers, (len(weights), len(seeds))
        assert shape[0] * shape[1] == self._robots
        for index in range(self._robots):
            walkers.begin(index, np.random.default_rng(seeds[index % len(seeds)]))
        each = np.repeat(weights, len(seeds), axis=0)
        slope, returned, walking = np.zeros(self._robots), np.zeros(self._robots), np.ones(self._robots, dtype=bool)
        parts = observation.observed(walkers.actions.shape[1])
        for _ in range(self._task.max_steps):
            part = {name: walkers.felt[:, where] for name, where in parts.items()}
            touched = part["touchdown"][:, 0] > 0.0
            last = part["last_touchdown"]
            slope[touched] += slope_change(last[touched, 0], last[touched, 3])
            told = actions(
                each, part["joint_angles"], part["joint_rates"], part["time_since_touchdown"][:, 0], last[:, 2], slope
            )
            np.multiply(told, self._most, out=walkers.actions)
            walkers.step()
            self.steps += int(walking.sum())
            returned[walking] += walkers.columns["reward"][walking]
            walking &= walkers.columns["outcome"] == 0.0
            if not walking.any():
                break
        return returned.reshape(shape)

    def walks(self) -> list[Walk]:
        """Records of the last episodes, all grounds of the first policy first; "time limit" where time has ended it."""
        return [self._walkers.walk(index) for index in range(self._robots)]

    def close(self) -> None:
        """End the threads."""
        self._walkers.close()
