"""Policies as controllers: their walks are the episodes of their environments, in files too, and in both engines."""

import hashlib
import json
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documentation import blocks
from episodes import begun, walked
from numpy.typing import NDArray

import mjbiped
from mjbiped.control.loading import digest_of, located
from mjbiped.control.registry import controller_class, controller_from, make_controller, settings_of
from mjbiped.envs import PolicyController, export_policy
from mjbiped.envs.observation import bounds
from mjbiped.envs.policy import OnnxController
from mjbiped.envs.tasks import WalkTask

GROUND = mjbiped.Terrain.level()


def weights_of(task: WalkTask, size: float = 0.02) -> NDArray[np.float64]:
    joints = len(task.limits)
    return np.random.default_rng(0).normal(0.0, size, (joints, len(bounds(joints)[0])))


class Linear:
    """A policy that depends on all that it observes."""

    def __init__(self, weights: NDArray[np.float64]) -> None:
        self.weights = weights
        self.seen: list[NDArray[np.float64]] = []

    def __call__(self, seen: NDArray[np.float64]) -> NDArray[np.float64]:
        self.seen.append(seen.copy())
        return np.tanh(self.weights @ seen)


@pytest.mark.parametrize(
    ("robot", "residual", "disturbances"),
    [
        ("compass", False, None),
        ("kneed", True, {"rate_noise": 0.02, "angle_noise": 0.002, "angle_bias": 0.001, "angle_resolution": 1e-4}),
        ("compass", True, {"rate_noise": 0.02, "angle_noise": 0.002, "control_period": 0.02}),
    ],
)
def test_a_walk_is_the_episode_of_the_environment(robot: str, residual: bool, disturbances: Any) -> None:
    """What the policy observes is bitwise the same, over touchdowns and knee strikes, and so is the walk."""
    task = WalkTask("walk_stairs", residual=residual, robot=robot, disturbances=disturbances)
    policy, walkers, observed = Linear(weights_of(task)), begun(task, seed=3), []
    for _ in range(120):
        observed.append(walkers.observations()[0])
        walked(walkers, policy(observed[-1])[None] * task.limits)
    there, episode = walkers.walk(), walkers.walker().episode
    other = Linear(policy.weights)
    given: Any = {"engine": task.engine, "initial": episode.start, "robot": episode.robot, "steps": there.steps + 1}
    controller = PolicyController(other, task)
    walk = mjbiped.walk(controller, episode.terrain, disturbances=episode.disturbances, **given)
    assert there.steps >= (2 if residual else 0)
    count = min(len(other.seen), len(observed))
    assert count > 30
    np.testing.assert_array_equal(other.seen[:count], observed[:count])
    for name, column in there.touchdowns.items():
        np.testing.assert_array_equal(walk.touchdowns[name][: there.steps], column, err_msg=name)


ONNX = """
<ir_version: 9, opset_import: ["": 18]>
policy (float[1, 12] observation) => (float[1, 2] action) <float[2, 12] W = {%s}>
{ sum = Gemm <transB = 1> (observation, W) action = Tanh (sum) }
"""


def written(path: Path, task: WalkTask, described: dict[str, Any]) -> NDArray[np.float32]:
    """Write a policy by hand, as `export_policy` writes it: tanh(W o); returns W."""
    onnx = pytest.importorskip("onnx", reason="needs the extra onnx")
    pytest.importorskip("onnxruntime", reason="needs the extra onnx")
    weights = weights_of(task).astype(np.float32)
    model = onnx.parser.parse_model(ONNX % ", ".join(map(str, weights.ravel())))
    onnx.helper.set_model_props(model, {"mjbiped": json.dumps(described)} if described else {})
    onnx.save(model, str(path))
    return weights


ROBOT: dict[str, Any] = {"robot": mjbiped.Compass().to_dict()}
RESIDUAL = {"name": "walk_random", "residual": True, "control_period": 0.02, **ROBOT}
"""What a file says of its policy's task."""


@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_a_file_walks_as_its_policy_does(engine: str, tmp_path: Path) -> None:
    file, task = tmp_path / "policy.onnx", WalkTask("walk_random", residual=True)
    weights = written(file, task, RESIDUAL)
    made = make_controller(f"policy:{file}", mjbiped.Compass(), {})
    plain = PolicyController(lambda seen: np.tanh(weights @ seen), task)
    walks = [mjbiped.walk(each, mjbiped.Terrain.mixed(), engine=engine, steps=3) for each in (made, plain)]
    # 32 bits in the file: 1e-7 of the torques, which steps do not amplify
    first, second = (walk.touchdowns["time"] for walk in walks)
    np.testing.assert_allclose(first, second, rtol=1e-5)
    for other in (controller_from(walks[0].settings["controller"]), pickle.loads(pickle.dumps(made))):
        assert other == made
        repeated = mjbiped.walk(other, mjbiped.Terrain.mixed(), engine=engine, steps=3)
        np.testing.assert_array_equal(repeated.samples["torque"], walks[0].samples["torque"])


OTHERS: tuple[tuple[dict[str, Any], str], ...] = (
    ({}, "does not say for which task"),
    ({**RESIDUAL, "name": "fly"}, "describes its policy's task in a way"),
    ({**RESIDUAL, "robot": mjbiped.KneedBiped().to_dict()}, "the policy observes 12 numbers; its task has 18"),
    (RESIDUAL, "is another policy than the one recorded"),
)


@pytest.mark.parametrize(("described", "words"), OTHERS)
def test_files_that_are_no_policies_are_named(described: dict[str, Any], words: str, tmp_path: Path) -> None:
    file = tmp_path / "policy.onnx"
    written(file, WalkTask("walk_level"), described)
    with pytest.raises(mjbiped.InputError, match=words):
        OnnxController(str(file), sha256="0" if described is RESIDUAL else "")
    file.write_bytes(b"nothing")
    with pytest.raises(mjbiped.InputError, match="is no ONNX file"):
        OnnxController(str(file))


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
    assert (tmp_path / "residual.zip").exists()
    assert OnnxController(str(tmp_path / "residual.onnx")).task.residual


@pytest.mark.parametrize("algorithm", ["PPO", "SAC"])
def test_an_exported_policy_acts_as_the_model(algorithm: str, tmp_path: Path) -> None:
    """Normalisation included; a walk by the file observes what the normalised environment shows."""
    for package in ("stable_baselines3", "onnx", "onnxruntime"):
        pytest.importorskip(package, reason="needs the extras sb3 and onnx")
    import stable_baselines3
    from stable_baselines3.common.vec_env import VecNormalize

    from mjbiped.envs.stable_baselines import WalkVecEnv

    robots = WalkVecEnv(4, "walk_random", residual=True, time_limit=0.4)
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
    assert mjbiped.walk(controller, GROUND, engine=robots.task.engine, steps=2).steps == 2
    with pytest.raises(mjbiped.InputError, match="the policy observes 12 numbers, and in the task"):
        export_policy(model, tmp_path / "other.onnx", WalkTask("walk_level", robot="kneed"))
    env.close()


def test_names_are_known_without_the_extra_and_files_are_found_beside_a_study(tmp_path: Path) -> None:
    assert controller_class("policy:walk.onnx") is OnnxController
    assert settings_of("policy:walk.onnx")["file"] == "walk.onnx"
    (tmp_path / "walk.onnx").write_bytes(b"a policy")
    reference = located("policy:walk.onnx", tmp_path)
    assert reference == f"policy:{tmp_path / 'walk.onnx'}"
    assert digest_of(reference) == hashlib.sha256(b"a policy").hexdigest()
    with pytest.raises(mjbiped.InputError, match="there is no such file"):
        digest_of("policy:nowhere.onnx")
    with pytest.raises(mjbiped.InputError, match="no file describes the controller adaptive"):
        controller_class("adaptive:walk.onnx")
