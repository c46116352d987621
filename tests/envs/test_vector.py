"""Many robots at once: each as in an environment of its own, whatever the threads; resets as Gymnasium has them."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from mjbiped.envs import IDS
from mjbiped.envs.single import WalkEnv
from mjbiped.envs.vector import WalkVectorEnv
from mjbiped.errors import InputError


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("privileged", [False, True])
def test_it_is_gymnasiums_own_row_of_environments(threads: int, privileged: bool) -> None:
    """Observations, rewards, ends and resets of `SyncVectorEnv`, bitwise, over many episodes."""
    count, actions = 5, np.random.default_rng(0)
    own = gymnasium.make_vec(
        "mjbiped/CompassWalkRandom-v0", num_envs=count, privileged=privileged, threads=threads, time_limit=0.9
    )
    assert isinstance(own.unwrapped, WalkVectorEnv)
    row = SyncVectorEnv(
        [
            lambda: gymnasium.make("mjbiped/CompassWalkRandom-v0", privileged=privileged, time_limit=0.9)
            for _ in range(count)
        ]
    )
    np.testing.assert_array_equal(own.reset(seed=7)[0], row.reset(seed=7)[0])
    ends = 0
    for _ in range(130):
        each = actions.uniform(-1.0, 1.0, (count, 2)).astype(np.float32)
        mine, others = own.step(each), row.step(each)
        for got, expected in zip(mine[:4], others[:4], strict=True):
            np.testing.assert_array_equal(got, expected)
        ends += int((mine[2] | mine[3]).sum())
        for name in ("x_position", "outcome", "terrain.seed"):
            np.testing.assert_array_equal(mine[4][name], others[4][name])
    assert ends >= 2 * count
    own.close()


@pytest.mark.slow
@pytest.mark.parametrize("name", IDS)
def test_spaces_hold_what_comes(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make_vec(name, num_envs=3, residual=True)
    observed, _ = env.reset(seed=0)
    for _ in range(20):
        assert env.observation_space.contains(observed)
        observed, *_ = env.step(env.action_space.sample())
    made = env.unwrapped
    assert isinstance(made, WalkVectorEnv)
    assert made.walk(1).outcome == "interrupted"
    env.close()


def test_only_some_are_reset_by_a_mask() -> None:
    env = WalkVectorEnv(3, residual=True)
    first, _ = env.reset(seed=0)
    for _ in range(10):
        before, *_ = env.step(np.zeros((3, 2), dtype=np.float32))
    after, _ = env.reset(seed=[0, 1, 2], options={"reset_mask": np.array([True, False, True])})
    np.testing.assert_array_equal(after[[0, 2]], first[[0, 2]])
    np.testing.assert_array_equal(after[1], before[1])
    env.close()


def test_mistakes_are_named() -> None:
    with pytest.raises(InputError, match="num_envs"):
        WalkVectorEnv(0)
    with pytest.raises(InputError, match="robots of one vector are not drawn"):
        gymnasium.make_vec("mjbiped/CompassWalkRandom-v0", num_envs=2, render_mode="rgb_array")
    with pytest.raises(InputError, match="threads"):
        WalkVectorEnv(2, threads=0)
    env = WalkVectorEnv(2)
    with pytest.raises(InputError, match="one for each of the 2 robots"):
        env.reset(seed=[1, 2, 3])
    with pytest.raises(InputError, match="reset_mask"):
        env.reset(options={"reset_mask": np.array([False, False])})


def test_one_of_them_is_the_single_environment() -> None:
    many, one = WalkVectorEnv(1, "walk_stairs"), WalkEnv("walk_stairs")
    np.testing.assert_array_equal(many.reset(seed=4)[0][0], one.reset(seed=4)[0])
    for _ in range(30):
        got, expected = many.step(np.full((1, 2), 0.2, np.float32)), one.step(np.full(2, 0.2, np.float32))
        np.testing.assert_array_equal(got[0][0], expected[0])


@pytest.mark.parametrize("count", [1, 3])
def test_what_was_returned_stays_as_it_is(count: int) -> None:
    """Learners keep it; one robot's numbers once were views of what the next step writes."""
    env, actions = WalkVectorEnv(count, residual=True), np.zeros((count, 2), np.float32)
    kept = [env.reset(seed=0)[0], *env.step(actions)[:4]]
    before = [each.copy() for each in kept]
    for _ in range(5):
        env.step(actions)
    for mine, theirs in zip(kept, before, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    env.close()


def test_seeds_are_numbers_of_any_kind_and_episodes_have_a_length() -> None:
    env = WalkVectorEnv(2)
    plain = env.reset(seed=3)[0]
    given: tuple[Any, ...] = (np.int64(3), np.uint8(3), [np.int32(3), 4], np.array([3, 4]), (3, np.int64(4)))
    for seed in given:
        np.testing.assert_array_equal(env.reset(seed=seed)[0], plain)
    refused: tuple[Any, ...] = (-1, 1.0, "3", [3], [3, "4"], True)
    for seed in refused:
        with pytest.raises(InputError, match="seed"):
            env.reset(seed=seed)
    single = WalkEnv()
    np.testing.assert_array_equal(single.reset(seed=np.int64(3))[0], plain[0])  # type: ignore[arg-type]
    for steps in (0, -5, "a", 1.5):
        with pytest.raises(InputError, match="max_episode_steps"):
            WalkVectorEnv(2, max_episode_steps=steps)  # type: ignore[arg-type]
    short = WalkVectorEnv(1, residual=True, max_episode_steps=2)
    short.reset(seed=3)
    truncated = [short.step(np.zeros((1, 2), dtype=np.float32))[3].tolist() for _ in range(2)]
    assert truncated == [[False], [True]]
    assert short.walk(0).outcome == "time limit"
