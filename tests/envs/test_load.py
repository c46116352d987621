"""dm_control's environments: its own tests, determinism, ends, copies, wrappers, the viewer's runtime, mistakes."""

import copy
import pickle
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from command_line import python

import mjbiped
from mjbiped.envs import load
from mjbiped.envs.single import WalkEnv
from mjbiped.rendering.gl import ensure_gl, gl_available

pytest.importorskip("dm_control", reason="mjbiped.envs.load needs dm_control, which pip does not install on 3.13")

from absl.testing import absltest  # both come with dm_control
from dm_env import test_utils


class TestContract(test_utils.EnvironmentTestMixin, absltest.TestCase):  # type: ignore[misc]  # without types
    """dm_env's own tests of an environment, over the end of an episode."""

    def make_object_under_test(self) -> Any:
        return load("walk_random", {"random": 0, "residual": True, "privileged": True, "time_limit": 0.2})


@pytest.mark.parametrize("residual", [False, True])
def test_it_is_the_environment_of_gymnasium(residual: bool) -> None:
    """The same seed draws the same, and the same actions give the same numbers; accessors say what is observed."""
    env = WalkEnv("walk_random", residual=residual, privileged=True)
    observed, _ = env.reset(seed=3)
    other = load("walk_random", {"residual": residual, "privileged": True})
    other.task._random = np.random.default_rng(np.random.SeedSequence(3))
    step, physics = other.reset(), other.physics
    assert other.action_spec().name == "ankle\thip"
    assert other.control_timestep() == 0.02
    action = np.array([0.5, -0.25], dtype=np.float32) if residual else ZERO
    for _ in range(100 if residual else 20):
        seen = step.observation
        np.testing.assert_array_equal(observed, np.concatenate(list(seen.values())))
        for name in ("joint_angles", "joint_rates", "last_touchdown", "torque", "ground_heights"):
            np.testing.assert_array_equal(getattr(physics, name)(), seen[name])
        felt = physics.touchdown(), physics.time_since_touchdown(), physics.slope()
        assert felt == tuple(seen[name][0] for name in ("touchdown", "time_since_touchdown", "ground_slope"))
        observed, reward, *_ = env.step(action)
        step = other.step(action * other.task.settings.limits)
        terms = physics.reward_terms()
        assert reward == step.reward == physics.reward() == terms["progress"] + terms["economy"]
    assert not physics.knee_locked()
    assert physics.named.data.qpos["hip_x"] == pytest.approx(physics.hip_position(), abs=1e-3)
    assert physics.time() == pytest.approx(2.0 if residual else 0.4, abs=1e-5)  # a tick may come a contact step late
    assert physics.walk().steps == env.walk().steps


ZERO = np.zeros(2, dtype=np.float32)


def test_an_episode_ends_at_a_fall_and_at_the_time_limit() -> None:
    env = load("walk_level", {"random": 0})
    step = env.reset()
    while not step.last():
        step = env.step([11.0, 0.0])
    assert step.discount == 0.0
    assert env.physics.walk().outcome == env.physics.outcome().words != "interrupted"
    limited = load("walk_level", {"residual": True, "time_limit": 0.5})
    step, count = limited.reset(), 0
    while not step.last():
        step, count = limited.step([0.0, 0.0]), count + 1
    assert (count, step.discount) == (25, 1.0)


def test_what_was_drawn_is_told_and_a_knee_feels_its_lock() -> None:
    env = load("walk_level", {"robot": {"kind": "kneed", "hip_mass": {"uniform": [4.8, 5.2]}}, "residual": True})
    env.reset()
    assert env.physics.walk().robot.hip_mass == env.physics.drawn()["robot.hip_mass"]
    locked = set()
    for _ in range(60):
        step = env.step(np.zeros(3))
        locked.add(env.physics.knee_locked())
        assert env.physics.knee_locked() == bool(step.observation["knee_locked"][0])
    assert locked == {False, True}


def test_a_copied_and_a_pickled_physics_go_on_by_themselves() -> None:
    env = load("walk_random", {"random": 0})
    env.reset()
    for _ in range(20):
        env.step([0.2, 0.1])
    physics = env.physics
    others, state = [physics.copy(), pickle.loads(pickle.dumps(physics)), copy.deepcopy(physics)], physics.get_state()
    for each in (physics, *others):
        each.set_control([0.2, 0.1])
        each.step(10)
        assert each.get_state().tobytes() == physics.get_state().tobytes()
    after, velocities = physics.joint_angles(), physics.get_state(mujoco.mjtState.mjSTATE_QVEL)
    physics.set_state(velocities, mujoco.mjtState.mjSTATE_QVEL)
    with pytest.raises(mjbiped.InputError, match="leave sig out"):
        physics.set_state(state, mujoco.mjtState.mjSTATE_USERDATA)
    with pytest.raises(mjbiped.InputError, match="finite"):
        physics.set_state(np.nan * velocities, mujoco.mjtState.mjSTATE_QVEL)
    physics.set_state(state)
    mujoco.mj_forward(physics.model.ptr, physics.data.ptr)  # as the viewer does, without our callbacks
    physics.step(10)
    np.testing.assert_array_equal(physics.joint_angles(), after)
    physics.reset()
    assert physics.time() == 0.0


@pytest.mark.slow
@pytest.mark.skipif(gl_available() is None, reason="no OpenGL here")
def test_pixels() -> None:
    env = load("walk_random", {"random": 0, "residual": True})
    from dm_control.suite.wrappers import pixels

    wrapped = pixels.Wrapper(env, pixels_only=False, render_kwargs={"width": 64, "height": 48, "camera_id": "track"})
    frames = [wrapped.reset().observation["pixels"]]
    frames += [wrapped.step([0.0, 0.0]).observation["pixels"] for _ in range(20)]
    assert frames[0].shape == (48, 64, 3)
    assert (frames[0] != frames[-1]).any()
    wrapped.reset()  # other ground, so another model and another rendering context
    assert wrapped.step([0.0, 0.0]).observation["pixels"].std() > 10.0
    env.physics.free()


def test_the_viewers_runtime_runs_and_begins_again() -> None:
    """All of dm_control's viewer that needs no window."""
    if gl_available():
        ensure_gl()  # before the viewer's own, which would keep other tests of this process from drawing
    pytest.importorskip("dm_control.viewer")
    from dm_control.viewer import runtime

    running = runtime.Runtime(load("walk_random", {"random": 0, "residual": True}), lambda _: np.zeros(2))
    running.tick(0.1, False)
    running.tick(0.1, False)
    assert running.get_time() > 0.1
    running.restart()
    running.tick(0.02, False)
    assert running.get_time() < 0.1
    running.stop()


@pytest.mark.parametrize(
    ("words", "given"),
    [
        ("did you mean 'walk_random'", ("walk_rndom",)),
        ("valid are flat_observation", ("walk_level", {}, {"n_sub_steps": 2})),
        ("random = -1", ("walk_level", {"random": -1})),
    ],
)
def test_mistakes_are_named(words: str, given: tuple[Any, ...]) -> None:
    with pytest.raises(mjbiped.InputError, match=words):
        load(*given)


WITHOUT = """
import sys
sys.modules[{missing!r}] = None
import mjbiped
try:
    {code}
except mjbiped.MjbipedError as error:
    print(error)
"""


@pytest.mark.parametrize(
    ("missing", "code", "said"),
    [
        ("gymnasium", "import mjbiped.envs; print(*mjbiped.envs.TASKS); from mjbiped.envs import single", "[gym]"),
        pytest.param("stable_baselines3", "import mjbiped.envs.stable_baselines", "[sb3]", marks=pytest.mark.slow),
        pytest.param("dm_control", "mjbiped.envs.load('walk_level')", "install dm-control", marks=pytest.mark.slow),
        pytest.param("labmaze", "print(mjbiped.envs.load('walk_level').reset())", "FIRST", marks=pytest.mark.slow),
        ("nothing", "print('dm_control' in sys.modules or 'gymnasium' in sys.modules)", "False"),
    ],
)
def test_where_a_package_is_missing(missing: str, code: str, said: str, tmp_path: Path) -> None:
    done = python("-c", WITHOUT.format(missing=missing, code=code), cwd=tmp_path)
    assert said in done.stdout, done.stderr


def test_each_seed_draws_episodes_of_its_own() -> None:
    grounds = []
    for random in (1, 1, 2, np.random.RandomState(1)):
        env = load("walk_random", {"random": random})
        for _ in range(2):
            env.reset()
            grounds.append(env.physics.walk().terrain.x)
    assert grounds[:2] == grounds[2:4]
    assert len({*grounds[2:]}) == 6
