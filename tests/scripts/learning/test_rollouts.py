"""Returns of many policies at once are those of the environment, one episode after the other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mjbiped.envs.tasks import WalkTask
from mjbiped.records.record import Walk
from scripts.learning.policy import WEIGHTS, Array, actions
from scripts.learning.rollouts import Rollouts

import gymnasium  # isort: skip


def episode(env: Any, weights: Array, seed: int) -> tuple[float, int, Walk]:
    """Return, length and walk of an episode in Gymnasium's environment."""
    felt, _ = env.reset(seed=seed)
    slope, returned, steps, over = 0.0, 0.0, 0, False
    while not over:
        if felt[4]:
            slope += felt[6] - felt[9]
        row = felt[None]
        told = actions(weights[None], row[:, 0:2], row[:, 2:4], row[:, 5], row[:, 8], np.array([slope]))
        felt, reward, fallen, late, _ = env.step(told[0])
        returned, steps, over = returned + reward, steps + 1, fallen or late
    return returned, steps, env.unwrapped.walk()


@pytest.mark.parametrize("residual", [True, False], ids=["residual", "free"])
def test_returns_are_the_environments_bitwise(residual: bool) -> None:
    """Policies that do little: the free ones fall after different times, and what is after the fall does not count."""
    weights, seeds = np.random.default_rng(1).normal(0.0, 0.02, (2, *WEIGHTS)), (5, 6)
    rollouts = Rollouts(WalkTask("walk_random", residual=residual, time_limit=4.0), 4, threads=2, recorded=True)
    returns = rollouts.returns(weights, [(seed,) for seed in seeds])
    walks = rollouts.walks()
    rollouts.close()
    env = gymnasium.make("mjbiped/CompassWalkRandom-v0", residual=residual, time_limit=4.0)
    found = [[episode(env, policy, seed) for seed in seeds] for policy in weights]
    env.close()
    np.testing.assert_array_equal(returns, [[returned for returned, *_ in row] for row in found])
    lengths = [length for row in found for _, length, _ in row]
    assert rollouts.steps == sum(lengths)
    for here, (*_, there) in zip(walks, (one for row in found for one in row), strict=True):
        assert (here.outcome, here.steps) == (there.outcome, there.steps)
        np.testing.assert_array_equal(here.samples["torque"], there.samples["torque"])
    assert residual or len(set(lengths)) > 1, "the case has robots that fall before others"
