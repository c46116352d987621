"""Environments of Gymnasium and stable-baselines3: their checkers, one robot as many, copies, pictures, mistakes."""

import copy
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from command_line import python
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv

import mjbiped
from mjbiped.envs import IDS, TASKS, observation
from mjbiped.envs.single import WalkEnv
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.vector import WalkVectorEnv
from mjbiped.rendering.gl import gl_available
from mjbiped.utils.files import markdown_table

ZERO = np.zeros(2, dtype=np.float32)
RANDOM = "mjbiped/CompassWalkRandom-v0"
PAGE = (Path(__file__).parents[2] / "docs" / "environments.md").read_text(encoding="utf-8")
drawing = pytest.mark.skipif(gl_available() is None, reason="no OpenGL here")
warnings_are_errors = pytest.mark.filterwarnings("error")


@warnings_are_errors
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if "Kneed" in name else name for name in IDS]
)
def test_gymnasiums_checker_has_nothing_to_say(name: str) -> None:
    for options in ({}, {"residual": True, "privileged": True}):
        env = gymnasium.make(name, **options)
        check_env(env.unwrapped, skip_render_check=True)
        env.close()


@warnings_are_errors
def test_stable_baselines_checker_has_nothing_to_say() -> None:
    pytest.importorskip("stable_baselines3", reason="needs the extra sb3")
    from stable_baselines3.common.env_checker import check_env as check

    check(WalkEnv("walk_random", residual=True))


@drawing
@warnings_are_errors
def test_pictures_show_the_robot() -> None:
    env = gymnasium.make("mjbiped/CompassWalkStairs-v0", residual=True, render_mode="rgb_array", width=96, height=72)
    check_env(env.unwrapped)
    env.reset(seed=0)
    first: Any = env.render()
    for _ in range(20):
        env.step(ZERO)
    assert (first.shape, env.metadata["render_fps"]) == ((72, 96, 3), 50)
    assert (first != env.render()).any()
    # the robot's legs are orange and blue, the ground is grey and the sky is pale
    orange = (first[..., 0] > 150) & (first[..., 2] < 80)
    assert 10 < orange.sum() < 1000
    env.close()


LEFT_OPEN = """
import gymnasium, mjbiped.envs
env = gymnasium.make("mjbiped/CompassWalk-v0", render_mode="rgb_array", width=64, height=64)
env.reset(seed=0)
env.render()
"""


@pytest.mark.slow
@drawing
def test_a_program_that_leaves_an_environment_open_ends_without_a_word(tmp_path: Path) -> None:
    """The picture's OpenGL must go before MuJoCo shuts down the platform."""
    done = python("-c", LEFT_OPEN, cwd=tmp_path)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False)


def test_all_tasks_have_a_name_and_settings_that_are_none_their_defaults() -> None:
    assert sorted(IDS.values()) == sorted((task, kind) for task in TASKS for kind in ("compass", "kneed"))
    for robot in (None, {"sole": 0.1}, "kneed"):
        made: Any = gymnasium.make("mjbiped/KneedWalk-v0", robot=robot, control_period=None).unwrapped
        assert isinstance(made, WalkEnv)
        assert isinstance(made.walkers.task.model, mjbiped.KneedBiped)


def test_an_episode_is_truncated_after_20_s_and_terminated_at_a_fall() -> None:
    env = WalkEnv(residual=True)
    env.reset(seed=0)
    ends = [env.step(ZERO)[2:] for _ in range(1000)]
    assert [each[:2] for each in ends] == [(False, False)] * 999 + [(False, True)]
    assert ends[-1][2]["outcome"] == "time limit"
    env = WalkEnv()
    env.reset(seed=0)
    terminated = False
    while not terminated:
        *_, reward, terminated, truncated, info = env.step(np.ones(2, dtype=np.float32))
        assert not truncated
        assert reward == info["reward_progress"] + info["reward_economy"]
    assert info["outcome"] in ("fell", "stalled", "slipped")
    assert env.walk().outcome == info["outcome"]


def test_specification_and_page_have_the_numbers_of_the_tasks() -> None:
    free, residual = WalkTask("walk_level"), WalkTask("walk_level", residual=True)
    for text in (str(WalkEnv.__doc__), PAGE):
        assert all(f"{number:.4g} N m" in text for number in (*free.limits, *residual.limits, *free.peak))
        assert all(f"`{name}`" in text for name in IDS)
    assert [WalkEnv(privileged=each).observation_space.shape for each in (False, True)] == [(12,), (23,)]
    assert round(free.target_speed, 3) == 0.494


def test_the_pages_table_of_observations_is_the_codes() -> None:
    straight = {field.name: place for field, place in observation.fields_of(2, privileged=True).items()}
    rows = []
    for field, place in observation.fields_of(3, privileged=True).items():
        places = numbers(straight[field.name]) if field.name in straight else "", numbers(place)
        only = "only with `privileged=True`: " if field.of == "privileged" else ""
        ends = f"{field.low:g} to {field.high:g}".replace("-", "−")
        rows.append([f"`{field.name}`", *places, only + field.meaning, ends])
    headings = ["name in dm_control", "numbers in Gymnasium", "with knees", "what it is", "bounds"]
    assert markdown_table(headings, rows) in PAGE


def numbers(place: slice) -> str:
    places = range(place.start, place.stop)
    return ", ".join(map(str, places)) if len(places) < 3 else f"{places[0]} to {places[-1]}"


NOISY: dict[str, Any] = {
    "robot": {"thigh_mass": {"uniform": [4.3, 4.7]}, "sole": 0.2},
    "disturbances": {"rate_noise": 0.02, "friction": {"uniform": [0.5, 1.0]}},
    "time_limit": 0.3,
}


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    ("name", "options"),
    [
        (RANDOM, {"privileged": True, "time_limit": 0.9}),
        pytest.param("mjbiped/KneedWalkRandom-v0", NOISY, marks=pytest.mark.slow),
    ],
)
def test_it_is_gymnasiums_own_row_of_environments(name: str, options: dict[str, Any], threads: int) -> None:
    """Observations, rewards, ends and resets of `SyncVectorEnv`, bitwise, over many episodes."""
    count, random = 5, np.random.default_rng(0)
    own = gymnasium.make_vec(name, num_envs=count, threads=threads, **options)
    assert isinstance(own.unwrapped, WalkVectorEnv)
    row = SyncVectorEnv([lambda: gymnasium.make(name, **options) for _ in range(count)])
    np.testing.assert_array_equal(own.reset(seed=7)[0], row.reset(seed=7)[0])
    ends = 0
    for _ in range(100):
        actions = random.uniform(-1.0, 1.0, own.action_space.shape or ()).astype(np.float32)
        mine, others = own.step(actions), row.step(actions)
        for got, expected in zip(mine[:4], others[:4], strict=True):
            np.testing.assert_array_equal(got, expected)
        assert own.observation_space.contains(mine[0])
        ends += int((mine[2] | mine[3]).sum())
        for key in mine[4]:
            np.testing.assert_array_equal(mine[4][key], others[4][key])
    assert ends >= 2 * count
    assert isinstance(own.unwrapped.walk(1), mjbiped.Walk)
    own.close()


@pytest.mark.parametrize("count", [1, 3])
def test_what_was_returned_stays_as_it_is_and_a_mask_resets_only_some(count: int) -> None:
    """Learners keep it; one robot's numbers once were views of what the next step writes."""
    env, actions = WalkVectorEnv(count, residual=True), np.zeros((count, 2), np.float32)
    kept = [env.reset(seed=0)[0], *env.step(actions)[:4]]
    before = copy.deepcopy(kept)
    for _ in range(5):
        last = env.step(actions)[0]
    for mine, theirs in zip(kept, before, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    after, _ = env.reset(seed=[*range(count)], options={"reset_mask": np.arange(count) < 1})
    np.testing.assert_array_equal(after, [*kept[0][:1], *last[1:]])


def test_seeds_are_numbers_of_any_kind_and_episodes_have_a_length() -> None:
    env = WalkVectorEnv(2)
    plain = env.reset(seed=3)[0]
    given: tuple[Any, ...] = (np.uint8(3), [np.int32(3), 4], np.array([3, 4]))
    for seed in given:
        np.testing.assert_array_equal(env.reset(seed=seed)[0], plain)
    short = WalkVectorEnv(1, residual=True, max_episode_steps=2)
    short.reset(seed=3)
    assert [short.step(np.zeros((1, 2), dtype=np.float32))[3].tolist() for _ in range(2)] == [[False], [True]]
    assert short.walk(0).outcome == "time limit"


def test_stable_baselines_robots_are_gymnasiums_without_the_steps_that_reset() -> None:
    pytest.importorskip("stable_baselines3", reason="needs the extra sb3")
    from mjbiped.envs.stable_baselines import WalkVecEnv

    env, plain = WalkVecEnv(3, "walk_random", time_limit=1.0), WalkVectorEnv(3, "walk_random", time_limit=1.0)
    env.seed(5)
    np.testing.assert_array_equal(env.reset(), plain.reset(seed=5)[0])
    assert env.reset_infos[0]["terrain.seed"] != env.reset_infos[1]["terrain.seed"]
    random, ends = np.random.default_rng(0), 0
    for _ in range(120):
        actions = random.uniform(-1.0, 1.0, (3, 2)).astype(np.float32)
        observed, rewards, done, infos = env.step(actions)
        expected, theirs, terminated, truncated, told = plain.step(actions)
        np.testing.assert_array_equal(rewards, theirs)
        np.testing.assert_array_equal(done, terminated | truncated)
        for index in np.flatnonzero(done):
            np.testing.assert_array_equal(infos[index]["terminal_observation"], expected[index])
            assert infos[index]["TimeLimit.truncated"] == truncated[index]
            for name in ("outcome", "terrain.seed"):
                assert infos[index][name] == told[name][index]
        ends += int(done.sum())
        if done.any():
            expected, _ = plain.reset(options={"reset_mask": done})
        np.testing.assert_array_equal(observed, expected)
    assert ends >= 6
    assert [isinstance(walk, mjbiped.Walk) for walk in env.env_method("walk")] == [True] * 3
    with pytest.raises(mjbiped.InputError, match="give settings when"):
        env.set_attr("task", 1)
    env.close()


def test_the_time_since_the_last_touchdown_is_observed() -> None:
    env = WalkEnv(residual=True)
    env.reset(seed=0)
    shown = [env.step(ZERO)[0][5] for _ in range(60)]
    times, touched = 0.02 * np.arange(1, 61), np.append(0.0, env.walk().touchdowns["time"])
    since = times - touched[np.searchsorted(touched, times, side="right") - 1]
    np.testing.assert_allclose(shown, since, rtol=0, atol=1e-9)
    assert len(touched) > 1
