"""Gymnasium's environments: its own checker, determinism, pictures, copies, and the numbers of the specification."""

import copy
import pickle
import subprocess
import sys
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import mjbiped
from mjbiped.envs import IDS, TASKS
from mjbiped.envs.single import WalkEnv
from mjbiped.envs.tasks import WalkTask
from mjbiped.errors import InputError
from mjbiped.rendering.gl import gl_available

ZERO = np.zeros(2, dtype=np.float32)

LEFT_OPEN = """
import gymnasium, mjbiped.envs
env = gymnasium.make("mjbiped/CompassWalk-v0", render_mode="rgb_array", width=64, height=64)
env.reset(seed=0)
env.render()
"""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if "Kneed" in name else name for name in IDS]
)
@pytest.mark.parametrize("options", [{}, {"residual": True, "privileged": True}], ids=["torque", "residual"])
def test_gymnasiums_checker_has_nothing_to_say(name: str, options: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(name, **options)
        check_env(env.unwrapped, skip_render_check=True)
        env.close()


@pytest.mark.skipif(gl_available() is None, reason="no OpenGL here")
def test_pictures_show_the_robot() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(
            "mjbiped/CompassWalkStairs-v0", residual=True, render_mode="rgb_array", width=96, height=72
        )
        check_env(env.unwrapped)
    env.reset(seed=0)
    first = env.render()
    for _ in range(20):
        env.step(ZERO)
    second = env.render()
    assert isinstance(first, np.ndarray)
    assert first.shape == (72, 96, 3)
    assert (first != second).any()
    # the robot's legs are orange and blue, the ground is grey and the sky is pale
    orange = (first[..., 0] > 150) & (first[..., 2] < 80)
    assert 10 < orange.sum() < 1000
    env.close()


@pytest.mark.slow
@pytest.mark.skipif(gl_available() is None, reason="no OpenGL here")
def test_a_program_that_leaves_an_environment_open_ends_without_a_word() -> None:
    """The picture's OpenGL must go before MuJoCo shuts down the platform."""
    done = subprocess.run([sys.executable, "-c", LEFT_OPEN], capture_output=True, text=True, check=True)
    assert "Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.skipif(gl_available() is None, reason="no OpenGL here")
@pytest.mark.parametrize("name", ["mjbiped/CompassWalkStairs-v0", "mjbiped/KneedWalk-v0"])
def test_gymnasiums_own_wrapper_observes_pixels(name: str) -> None:
    """Another robot stands on the same ground in the next episode, and is drawn as it is."""
    longer = {"upper_length": {"uniform": [0.4, 0.9]}} if "Compass" in name else {"kind": "kneed"}

    def pixels() -> gymnasium.Env[Any, Any]:
        made = gymnasium.make(
            name, residual=True, robot=longer, terrain="level", render_mode="rgb_array", width=84, height=84
        )
        return gymnasium.wrappers.AddRenderObservation(made, render_only=True)

    env, other = pixels(), pixels()
    assert env.observation_space.shape == (84, 84, 3)
    first, _ = env.reset(seed=0)
    for _ in range(20):
        second, *_ = env.step(np.zeros(env.unwrapped.action_space.shape, dtype=np.float32))
    assert env.observation_space.contains(second)
    assert (first != second).any()
    np.testing.assert_array_equal(env.reset(seed=1)[0], other.reset(seed=1)[0])
    env.close()
    other.close()


def test_all_tasks_have_a_name() -> None:
    assert sorted(IDS.values()) == sorted((task, kind) for task in TASKS for kind in ("compass", "kneed"))
    for name, (task, kind) in IDS.items():
        assert gymnasium.spec(name).kwargs == {"task": task, "kind": kind}
    for robot in (None, {"sole": 0.1}, "kneed", mjbiped.KneedBiped()):
        made = gymnasium.make("mjbiped/KneedWalk-v0", robot=robot).unwrapped
        assert isinstance(made, WalkEnv)
        assert isinstance(made.walkers.task.model, mjbiped.KneedBiped)
    assert isinstance(gymnasium.make("mjbiped.envs:mjbiped/CompassWalk-v0").unwrapped, WalkEnv)


def test_it_is_the_environment_of_dm_control() -> None:
    """The same seed draws the same, and the same actions give the same numbers."""
    env = gymnasium.make("mjbiped/CompassWalkRandom-v0", residual=True)
    observed, _ = env.reset(seed=3)
    pytest.importorskip("dm_control", reason="mjbiped.envs.load needs dm_control, which pip does not install on 3.13")
    other = mjbiped.envs.load("walk_random", {"residual": True})
    other.task._random = np.random.default_rng(np.random.SeedSequence(3))
    step = other.reset()
    action = np.array([0.5, -0.25], dtype=np.float32)
    for _ in range(100):
        np.testing.assert_array_equal(observed, np.concatenate(list(step.observation.values())))
        observed, reward, *_ = env.step(action)
        step = other.step(action * other.task.settings.limits)
        assert reward == step.reward


def test_an_episode_is_truncated_after_20_s_and_terminated_at_a_fall() -> None:
    env = gymnasium.make("mjbiped/CompassWalk-v0", residual=True)
    env.reset(seed=0)
    for count in range(1, 1001):
        *_, terminated, truncated, info = env.step(ZERO)
        assert not terminated
        assert truncated == (count == 1000)
    assert info["outcome"] == "time limit"
    env = gymnasium.make("mjbiped/CompassWalk-v0")
    env.reset(seed=0)
    terminated = False
    while not terminated:
        *_, reward, terminated, truncated, info = env.step(np.ones(2, dtype=np.float32))
        assert not truncated
        assert reward == info["reward_progress"] + info["reward_economy"]
    assert info["outcome"] in ("fell", "stalled", "slipped")
    made = env.unwrapped
    assert isinstance(made, WalkEnv)
    assert made.walk().outcome == info["outcome"]


def test_a_copy_in_the_middle_of_an_episode_goes_on_the_same() -> None:
    env = gymnasium.make("mjbiped/CompassWalkRandom-v0").unwrapped
    env.reset(seed=5)
    actions = np.random.default_rng(0).uniform(-0.3, 0.3, (160, 2)).astype(np.float32)
    for action in actions[:30]:
        env.step(action)
    others = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    for action in actions[30:60]:
        step = env.step(action)
        for other in others:
            assert other.step(action)[0].tobytes() == step[0].tobytes()
    assert len({each.reset()[0].tobytes() for each in (env, *others)}) == 1  # they draw the same next episode
    assert len({each.walk().terrain.x for each in (env, *others)}) == 1


def test_the_specification_has_the_numbers() -> None:
    text = WalkEnv.__doc__
    assert text is not None
    free, residual = WalkTask("walk_level"), WalkTask("walk_level", residual=True)
    for number in (*free.limits, *residual.limits, *free.peak):
        assert f"{number:.4g} N m" in text
    for name in IDS:
        assert f"`{name}`" in text
    env = WalkEnv(privileged=True)
    assert env.observation_space.shape == (23,)
    assert round(env.walkers.task.target_speed, 3) == 0.494
    assert WalkEnv().observation_space.shape == (12,)


def test_mistakes_are_named() -> None:
    with pytest.raises(InputError, match="must be None or 'rgb_array'"):
        WalkEnv(render_mode="human")
    with pytest.raises(InputError, match="width"):
        WalkEnv(width=3)
    with pytest.raises(InputError, match="unknown task"):
        WalkEnv("walk")
    wrong: Any = {"terain": {}}
    with pytest.raises(InputError, match=r"unknown setting 'terain'.*did you mean 'terrain'"):
        WalkEnv(**wrong)


def test_settings_that_are_none_have_their_defaults() -> None:
    none: Any = {"terrain": None, "control_period": None}
    assert WalkEnv(**none).walkers.task == WalkEnv().walkers.task
