"""dm_control's environments: specs, determinism, ends, wrappers, the viewer's runtime; as its suite tests its own."""

import copy
import pickle
import sys
from typing import Any

import mujoco
import numpy as np
import pytest

import mjbiped
from mjbiped.engines.compiling import VARIABLE
from mjbiped.envs import TASKS, load
from mjbiped.errors import InputError, MjbipedError
from mjbiped.rendering.gl import ensure_gl, gl_available
from mjbiped.rules.termination import Outcome

pytest.importorskip("dm_control", reason="mjbiped.envs.load needs dm_control, which pip does not install on 3.13")

from absl.testing import absltest  # both come with dm_control
from dm_env import test_utils


def random_action(spec: Any, random: np.random.Generator) -> Any:
    return random.uniform(spec.minimum, spec.maximum)


CASES = [
    *((task, residual, "compass") for task in TASKS for residual in (False, True)),
    ("walk_stairs", True, "kneed"),
    pytest.param(("walk_stairs", False, "kneed"), marks=pytest.mark.slow),
]


@pytest.fixture(params=CASES, ids=str)
def env(request: pytest.FixtureRequest) -> Any:
    task, residual, robot = request.param
    return load(task, task_kwargs={"residual": residual, "privileged": residual, "random": 0, "robot": robot})


@pytest.mark.slow
def test_specs_match_what_comes(env: Any) -> None:
    action, observed, random = env.action_spec(), env.observation_spec(), np.random.default_rng(0)
    assert action.shape == (len(action.name.split("\t")),)
    assert np.isfinite([action.minimum, action.maximum]).all()
    assert env.control_timestep() == 0.02
    step = env.reset()
    assert step.first()
    for _ in range(60):
        assert list(step.observation) == list(observed)
        for name, spec in observed.items():
            spec.validate(step.observation[name])
            assert np.isfinite(step.observation[name]).all()
        step = env.step(random_action(action, random))
        if not step.first():
            env.reward_spec().validate(step.reward)
            env.discount_spec().validate(step.discount)
            assert 0.0 <= step.reward <= 1.0


def test_the_same_seed_gives_the_same_episodes_and_another_gives_others() -> None:
    def rows(seed: int) -> bytes:
        env, random = load("walk_random", {"random": seed}), np.random.default_rng(1)
        out, step = [], env.reset()
        for _ in range(250):
            out.append(np.concatenate([each.ravel() for each in step.observation.values()]))
            step = env.step(random_action(env.action_spec(), random))
        return np.array(out).tobytes()

    assert rows(3) == rows(3)
    assert rows(3) != rows(4)


def test_random_ground_is_another_one_in_each_episode() -> None:
    env = load("walk_random", {"random": 1})
    grounds = []
    for _ in range(3):
        env.reset()
        grounds.append(env.physics.walk().terrain)
    assert len({ground.x for ground in grounds}) == 3
    same = load("walk_random", {"random": 1, "terrain": {"seed": 4}})
    same.reset()
    assert same.physics.walk().terrain == mjbiped.Terrain.random(seed=4, length=15.0)


def test_no_observation_is_constant() -> None:
    """With the adaptive controller in it the robot comes to other slopes; alone it falls on the first metre."""
    env = load("walk_random", {"random": 0, "privileged": True, "residual": True})
    random, step = np.random.default_rng(0), env.reset()
    seen: dict[str, list[Any]] = {name: [] for name in step.observation}
    for _ in range(400):
        for name, value in step.observation.items():
            seen[name].append(value)
        step = env.step(random_action(env.action_spec(), random))
    for name, values in seen.items():
        assert (np.ptp(np.array(values), axis=0) > 0.0).all(), name


def test_an_episode_ends_at_a_fall_and_at_the_time_limit() -> None:
    env = load("walk_level", {"random": 0})
    step = env.reset()
    while not step.last():
        step = env.step([11.0, 0.0])
    assert step.discount == 0.0
    assert env.physics.outcome() is not Outcome.WALKING
    assert env.physics.walk().outcome == env.physics.outcome().words
    assert env.step([0.0, 0.0]).first()
    limited = load("walk_level", {"residual": True, "time_limit": 0.5})
    step, count = limited.reset(), 0
    while not step.last():
        step, count = limited.step([0.0, 0.0]), count + 1
    assert (count, step.discount) == (25, 1.0)


def test_named_accessors_say_what_is_observed() -> None:
    env = load("walk_random", {"residual": True, "privileged": True, "random": 2})
    env.reset()
    for _ in range(100):
        step = env.step([0.1, -0.1])
        physics, observed = env.physics, step.observation
        for name in ("joint_angles", "joint_rates", "last_touchdown", "torque", "ground_heights"):
            np.testing.assert_array_equal(getattr(physics, name)(), observed[name])
        assert not physics.knee_locked()
        assert physics.touchdown() == bool(observed["touchdown"][0])
        assert physics.time_since_touchdown() == observed["time_since_touchdown"][0]
        assert physics.slope() == observed["ground_slope"][0]
        assert physics.reward() == step.reward
        terms = physics.reward_terms()
        assert step.reward == terms["progress"] + terms["economy"]
    assert physics.named.data.qpos["hip_x"] == pytest.approx(physics.hip_position(), abs=1e-3)
    assert physics.time() == pytest.approx(2.0, abs=1e-5)  # a tick may come a contact step late
    assert physics.walk().steps >= 2


def test_what_was_drawn_is_told_and_a_knee_feels_its_lock() -> None:
    env = load("walk_level", {"robot": {"kind": "kneed", "hip_mass": {"uniform": [4.8, 5.2]}}, "residual": True})
    masses, locked = set(), set()
    for _ in range(2):
        env.reset()
        masses.add(env.physics.drawn()["robot.hip_mass"])
        assert env.physics.walk().robot.hip_mass in masses
        for _ in range(60):
            step = env.step(np.zeros(3))
            locked.add(env.physics.knee_locked())
            assert env.physics.knee_locked() == bool(step.observation["knee_locked"][0])
    assert len(masses) == 2
    assert locked == {False, True}


@pytest.mark.slow
def test_zero_residual_is_bitwise_the_walk() -> None:
    env = load("walk_stairs", {"residual": True, "random": 5})
    env.reset()
    for _ in range(150):
        env.step(np.zeros(2))
    record = env.physics.walk()
    settings, task = record.settings, env.task.settings
    other = mjbiped.walk(
        task.controller.inner, record.terrain, engine=task.engine, initial=settings["initial"], steps=settings["steps"]
    )
    assert record.steps >= 3
    for name, column in record.samples.items():
        np.testing.assert_array_equal(column, other.samples[name][: len(column)], err_msg=name)


def test_a_copied_and_a_pickled_physics_go_on_by_themselves() -> None:
    env = load("walk_random", {"random": 0})
    env.reset()
    for _ in range(20):
        env.step([0.2, 0.1])
    physics = env.physics
    others = [physics.copy(), pickle.loads(pickle.dumps(physics)), copy.deepcopy(physics)]
    state = physics.get_state()
    for each in (physics, *others):
        each.set_control([0.2, 0.1])
        each.step(10)
        assert each.get_state().tobytes() == physics.get_state().tobytes()
    after = physics.joint_angles()
    with pytest.raises(InputError, match="leave sig out"):
        physics.set_state(state, mujoco.mjtState.mjSTATE_USERDATA)
    velocities = physics.get_state(mujoco.mjtState.mjSTATE_QVEL)
    with pytest.raises(InputError, match="finite"):
        physics.set_state(np.nan * velocities, mujoco.mjtState.mjSTATE_QVEL)
    physics.set_state(velocities, mujoco.mjtState.mjSTATE_QVEL)
    physics.set_state(state)
    physics.step(10)
    np.testing.assert_array_equal(physics.joint_angles(), after)
    physics.reset()
    assert physics.time() == 0.0


def test_an_interpreted_episode_that_begins_again_is_interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another simulation took its place, and the physics went on showing the old one."""
    monkeypatch.setenv(VARIABLE, "never")
    env = load("walk_level", {"random": 0})
    env.reset()
    env.step([0.0, 0.0])
    monkeypatch.setenv(VARIABLE, "always")
    env.physics.reset()
    assert env.physics.time() == 0.0


def test_extra_forward_calls_and_pictures_change_nothing() -> None:
    """dm_control's viewer calls `mj_forward` by itself, without our callbacks."""
    import mujoco

    rows = []
    for disturbed in (False, True):
        env = load("walk_random", {"random": 0})
        env.reset()
        for _ in range(60):
            step = env.step([0.2, 0.1])
            if disturbed:
                mujoco.mj_forward(env.physics.model.ptr, env.physics.data.ptr)
                env.physics.forward()
        rows.append(np.concatenate([each.ravel() for each in step.observation.values()]))
    np.testing.assert_array_equal(rows[0], rows[1])


class TestContract(test_utils.EnvironmentTestMixin, absltest.TestCase):  # type: ignore[misc]  # without types
    """dm_env's own tests of an environment, over the end of an episode."""

    def make_object_under_test(self) -> Any:
        return load("walk_random", {"random": 0, "residual": True, "time_limit": 0.2})


def test_flat_observations() -> None:
    env = load("walk_level", environment_kwargs={"flat_observation": True})
    assert env.observation_spec()["observations"].shape == (12,)
    assert env.reset().observation["observations"].shape == (12,)


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


def test_wrappers_of_dm_control() -> None:
    made = load("walk_level", {"random": 0, "residual": True})
    from dm_control.suite.wrappers import action_noise, action_scale, mujoco_profiling

    noisy = action_noise.Wrapper(made, scale=0.1)
    scaled = action_scale.Wrapper(load("walk_level", {"residual": True}), minimum=-1.0, maximum=1.0)
    timed = mujoco_profiling.Wrapper(load("walk_level", {"residual": True}))
    for env in (noisy, scaled, timed):
        env.reset()
        for _ in range(30):
            step = env.step(np.zeros(2))
        assert not step.last()
    assert step.observation["step_timing"][1] == 30.0


def test_the_viewers_runtime_runs_and_begins_again() -> None:
    """All of dm_control's viewer that needs no window."""
    env = load("walk_random", {"random": 0, "residual": True})
    if gl_available():
        ensure_gl()  # before the viewer's own, which would keep other tests of this process from drawing
    pytest.importorskip("dm_control.viewer")
    from dm_control.viewer import runtime

    running = runtime.Runtime(env, lambda _: np.zeros(2))
    running.tick(0.1, False)
    running.tick(0.1, False)
    assert running.get_time() > 0.1
    running.restart()
    running.tick(0.02, False)
    assert running.get_time() < 0.1
    running.stop()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("walk_rndom",), "did you mean 'walk_random'"),
        (("walk_level", {"residul": True}), "did you mean 'residual'"),
        (("walk_level", {}, {"n_sub_steps": 2}), "valid are flat_observation"),
        (("walk_level", {"residual": 1}), "must be True or False"),
        (("walk_level", {"terrain": 3}), "must be a Terrain, the name of a preset"),
        (("walk_level", {"terrain": "stair"}), "did you mean 'stairs'"),
        (("walk_stairs", {"terrain": {"raise": 0.1}}), "did you mean 'rise'"),
        (("walk_level", {"control_period": 0.005}), "must be a multiple of the timestep"),
        (("walk_level", {"random": -1}), "random = -1: must be a whole number from 0"),
        (("walk_level", {"control_period": 2.0}), "control_period = 2.0: must be from 0.004 to 1 s"),
        (("walk_level", {"time_limit": "long"}), "time_limit"),
    ],
)
def test_mistakes_are_named(arguments: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load(*arguments)


def test_without_dm_control_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dm_control", None)
    monkeypatch.delitem(sys.modules, "mjbiped.envs.dm", raising=False)
    monkeypatch.delattr("mjbiped.envs.dm", raising=False)
    with pytest.raises(MjbipedError, match="pip install dm-control"):
        load("walk_level")
