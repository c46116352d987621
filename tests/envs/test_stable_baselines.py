"""stable-baselines3's vector environment: Gymnasium's robots, which begin anew in the step that ends an episode."""

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documentation import blocks

import mjbiped
from mjbiped.envs import export_policy
from mjbiped.envs.policy import OnnxController
from mjbiped.envs.single import WalkEnv
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.vector import WalkVectorEnv
from mjbiped.errors import InputError

WITHOUT = """
import sys
sys.modules["stable_baselines3"] = None
import mjbiped.errors
try:
    import mjbiped.envs.stable_baselines
except mjbiped.errors.MjbipedError as error:
    print(error)
"""


@pytest.mark.slow
def test_without_it_is_said_what_to_install() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=True)
    assert "pip install 'mjbiped[sb3]'" in done.stdout


def made(count: int, **settings: Any) -> Any:
    pytest.importorskip("stable_baselines3", reason="needs the extra sb3")
    from mjbiped.envs.stable_baselines import WalkVecEnv

    return WalkVecEnv(count, "walk_random", **settings)


def test_it_has_the_steps_of_gymnasiums_robots_without_those_that_reset() -> None:
    env, plain = made(3, time_limit=1.0), WalkVectorEnv(3, "walk_random", time_limit=1.0)
    env.seed(5)
    np.testing.assert_array_equal(env.reset(), plain.reset(seed=5)[0])
    assert env.reset_infos[0]["terrain.seed"] != env.reset_infos[1]["terrain.seed"]
    random, ends = np.random.default_rng(0), []
    for _ in range(120):
        actions = random.uniform(-1.0, 1.0, (3, 2)).astype(np.float32)
        observed, rewards, done, infos = env.step(actions)
        expected, theirs, terminated, truncated, told = plain.step(actions)
        np.testing.assert_array_equal(rewards, theirs)
        np.testing.assert_array_equal(done, terminated | truncated)
        for index in np.flatnonzero(done):
            np.testing.assert_array_equal(infos[index]["terminal_observation"], expected[index])
            assert infos[index]["TimeLimit.truncated"] == truncated[index]
            assert infos[index]["outcome"] == told["outcome"][index]
            assert infos[index]["terrain.seed"] == told["terrain.seed"][index]
            ends.append(infos[index]["outcome"])
        if done.any():
            expected, _ = plain.reset(options={"reset_mask": done})
        np.testing.assert_array_equal(observed, expected)
    assert len(ends) >= 6
    assert [each.outcome for each in env.env_method("walk")] == ["interrupted"] * 3
    env.close()


def test_the_program_of_the_page_trains(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("stable_baselines3", "onnx", "onnxruntime"):
        pytest.importorskip(package, reason="needs the extras sb3 and onnx")
    program = next(block.code for block in blocks("docs/environments.md") if "stable_baselines3" in block.code)
    for long, short in (
        ("WalkVecEnv(64,", "WalkVecEnv(4, time_limit=0.4, task="),
        ("n_steps=128", "n_steps=32"),
        ("64 * 128", "4 * 32"),
        ("batch_size=2048", "batch_size=64"),
    ):
        assert long in program
        program = program.replace(long, short)
    monkeypatch.chdir(tmp_path)
    space: dict[str, Any] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the exporter's age
        exec(program, space)
    assert space["model"].num_timesteps == 256
    assert {episode["l"] for episode in space["model"].ep_info_buffer} == {20}
    assert (tmp_path / "residual.zip").exists()
    assert OnnxController(str(tmp_path / "residual.onnx")).task.residual


@pytest.mark.parametrize("algorithm", ["PPO", "SAC"])
def test_an_exported_policy_acts_as_the_model(algorithm: str, tmp_path: Path) -> None:
    """Normalisation included; a walk by the file observes what the normalised environment shows."""
    for package in ("stable_baselines3", "onnx", "onnxruntime"):
        pytest.importorskip(package, reason="needs the extras sb3 and onnx")
    import stable_baselines3
    from stable_baselines3.common.vec_env import VecNormalize

    robots = made(4, residual=True, time_limit=0.4)
    env = VecNormalize(robots)
    model: Any = getattr(stable_baselines3, algorithm)("MlpPolicy", env, seed=0, device="cpu")
    seen = env.reset()
    for _ in range(30):
        seen, *_ = env.step(model.predict(seen)[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the exporter's age
        export_policy(model, tmp_path / "policy.onnx", robots.task, normalisation=env)
    controller = OnnxController(str(tmp_path / "policy.onnx"))
    actions = np.array([controller.predict(each) for each in env.get_original_obs()])
    np.testing.assert_allclose(actions, model.predict(seen, deterministic=True)[0], rtol=0, atol=1e-6)  # 32 bits
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine=robots.task.engine, initial="gait", steps=2)
    assert walk.steps == 2
    with pytest.raises(InputError, match="the policy observes 12 numbers, and in the task"):
        export_policy(model, tmp_path / "other.onnx", WalkTask("walk_level", robot="kneed"))
    env.close()


def test_its_own_checker_has_nothing_to_say() -> None:
    pytest.importorskip("stable_baselines3", reason="needs the extra sb3")
    from stable_baselines3.common.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(WalkEnv("walk_random", residual=True))


def test_settings_are_fixed() -> None:
    env = made(1)
    with pytest.raises(InputError, match="give settings when"):
        env.set_attr("task", 1)
    assert env.env_is_wrapped(object) == [False]
    env.close()
