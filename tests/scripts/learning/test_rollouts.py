"""Returns of many policies at once are those of the environment, one episode after the other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mjbiped.envs.tasks import WalkTask
from scripts.learning.policy import WEIGHTS, Array, actions
from scripts.learning.rollouts import Rollouts

import gymnasium  # isort: skip


def episode(env: Any, weights: Array, seed: int) -> tuple[float, int]:
    """Return and length of an episode in Gymnasium's environment."""
    felt, _ = env.reset(seed=seed)
    slope, returned, steps, over = 0.0, 0.0, 0, False
    while not over:
        if felt[4]:
            slope += felt[6] - felt[9]
        row = felt[None]
        told = actions(weights[None], row[:, 0:2], row[:, 2:4], row[:, 5], row[:, 8], np.array([slope]))
        felt, reward, fallen, late, _ = env.step(told[0])
        returned, steps, over = returned + reward, steps + 1, fallen or late
    return returned, steps


@pytest.mark.parametrize("residual", [True, False], ids=["residual", "free"])
def test_returns_are_the_environments_bitwise(residual: bool) -> None:
    """Policies that do little: the free ones fall after different times, and what is after the fall does not count."""
    weights, seeds = np.random.default_rng(1).normal(0.0, 0.02, (2, *WEIGHTS)), (5, 6)
    rollouts = Rollouts(WalkTask("walk_random", residual=residual, time_limit=4.0), 4, threads=2)
    returns = rollouts.returns(weights, [(seed,) for seed in seeds])
    rollouts.close()
    env = gymnasium.make("mjbiped/CompassWalkRandom-v0", residual=residual, max_episode_steps=200)
    found = [[episode(env, policy, seed) for seed in seeds] for policy in weights]
    env.close()
    np.testing.assert_array_equal(returns, [[returned for returned, _ in row] for row in found])
    lengths = [length for row in found for _, length in row]
    assert rollouts.steps == sum(lengths)
    assert residual or len(set(lengths)) > 1, "the case has robots that fall before others"
