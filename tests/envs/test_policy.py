"""Policies as controllers: their walks are the episodes of their environments, in files too, and in both engines."""

import hashlib
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mjbiped
from mjbiped.cli.main import main
from mjbiped.control.loading import digest_of, located
from mjbiped.control.registry import controller_class, controller_from, make_controller, settings_of
from mjbiped.envs import PolicyController
from mjbiped.envs.observation import bounds
from mjbiped.envs.policy import OnnxController
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.errors import InputError


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
        ("compass", True, None),
        ("compass", False, None),
        ("kneed", True, None),
        ("compass", True, {"rate_noise": 0.02, "angle_noise": 0.002, "control_period": 0.02}),
    ],
)
def test_a_walk_is_the_episode_of_the_environment(robot: str, residual: bool, disturbances: Any) -> None:
    """What the policy observes is bitwise the same, over touchdowns and knee strikes, and so is the walk."""
    task = WalkTask("walk_stairs", residual=residual, robot=robot, disturbances=disturbances)
    policy = Linear(weights_of(task))
    walkers = Walkers(task)
    walkers.begin(0, np.random.default_rng(3))
    observed = []
    for _ in range(120):
        observed.append(walkers.observations()[0])
        walkers.act(policy(observed[-1]) * task.limits)
        walkers.step()
    there, episode = walkers.walk(), walkers.walker().episode
    other = Linear(policy.weights)
    controller = PolicyController(other, task)
    walk = mjbiped.walk(
        controller,
        episode.terrain,
        engine=task.engine,
        initial=episode.start,
        robot=episode.robot,
        disturbances=episode.disturbances,
        steps=there.steps + 1,
    )
    assert there.steps >= (2 if residual else 0)
    count = min(len(other.seen), len(observed))
    assert count > 30
    np.testing.assert_array_equal(other.seen[:count], observed[:count])
    for name, column in there.touchdowns.items():
        np.testing.assert_array_equal(walk.touchdowns[name][: there.steps], column, err_msg=name)


def test_it_begins_on_its_gait_and_walks_in_the_hybrid_engine() -> None:
    """The digital controller ticks there too: the same policy, the same steps to the engines' usual difference."""
    task = WalkTask("walk_level", residual=True)
    controller = PolicyController(Linear(weights_of(task)), task)
    walks = [
        mjbiped.walk(controller, mjbiped.Terrain.level(), engine=engine, initial="gait", steps=4)
        for engine in (task.engine, "hybrid")
    ]
    assert [walk.outcome for walk in walks] == ["finished"] * 2
    # the docs' difference between the engines at a timestep of 4 ms is some 0.1 % of a step
    first, second = (walk.touchdowns["time"] for walk in walks)
    np.testing.assert_allclose(first, second, rtol=1e-3)
    assert walks[1].settings["disturbances"] == {"control_period": 0.02}


@pytest.mark.parametrize(
    ("action", "message"),
    [([0.0], "expected 2 numbers from -1 to 1: ankle, hip"), ("left", "expected 2 numbers"), (None, "expected 2")],
)
def test_what_is_no_action_is_named(action: Any, message: str) -> None:
    controller = PolicyController(lambda _: action, WalkTask("walk_level"))
    with pytest.raises(InputError, match=message):
        mjbiped.walk(controller, mjbiped.Terrain.level(), steps=1)


def test_other_periods_and_privileged_tasks_are_refused() -> None:
    with pytest.raises(InputError, match="observes the ground, which no controller sees"):
        PolicyController(lambda _: [0.0, 0.0], WalkTask("walk_level", privileged=True))
    controller = PolicyController(lambda _: [0.0, 0.0], WalkTask("walk_level"))
    with pytest.raises(InputError, match=r"control_period = 0\.02 of disturbances or controller contradicts"):
        mjbiped.walk(controller, mjbiped.Terrain.level(), engine=mjbiped.Mujoco(control_period=0.01), steps=1)


# ---- files -----------------------------------------------------------------------------------------------------------


def written(path: Path, task: WalkTask, described: dict[str, Any] | None = None) -> NDArray[np.float32]:
    """Write a policy by hand, as `export_policy` writes it: tanh(W o); returns W."""
    onnx = pytest.importorskip("onnx", reason="needs the extra onnx")
    pytest.importorskip("onnxruntime", reason="needs the extra onnx")
    from onnx import helper, numpy_helper

    from mjbiped.envs.policy import _described

    weights = weights_of(task).astype(np.float32)
    kind, (joints, numbers) = onnx.TensorProto.FLOAT, weights.shape
    nodes = [
        helper.make_node("Gemm", ["observation", "W"], ["sum"], transB=1),
        helper.make_node("Tanh", ["sum"], ["action"]),
    ]
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("observation", kind, [1, numbers])],
        [helper.make_tensor_value_info("action", kind, [1, joints])],
        [numpy_helper.from_array(weights, "W")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)
    if described != {}:
        helper.set_model_props(model, {"mjbiped": json.dumps(described or _described(task))})
    onnx.save(model, str(path))
    return weights


@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_a_file_walks_as_its_policy_does(engine: str, tmp_path: Path) -> None:
    file, task = tmp_path / "policy.onnx", WalkTask("walk_random", residual=True)
    weights = written(file, task)
    made = make_controller(f"policy:{file}", mjbiped.Compass(), {})
    assert isinstance(made, OnnxController)
    plain = PolicyController(lambda seen: np.tanh(weights @ seen), task)
    walks = [mjbiped.walk(each, mjbiped.Terrain.mixed(), engine=engine, steps=3) for each in (made, plain)]
    # 32 bits in the file: 1e-7 of the torques, which steps do not amplify
    first, second = (walk.touchdowns["time"] for walk in walks)
    np.testing.assert_allclose(first, second, rtol=1e-5)
    again = controller_from(walks[0].settings["controller"])
    for other in (again, pickle.loads(pickle.dumps(made))):
        assert other == made
        repeated = mjbiped.walk(other, mjbiped.Terrain.mixed(), engine=engine, steps=3)
        np.testing.assert_array_equal(repeated.samples["torque"], walks[0].samples["torque"])


def test_a_command_walks_by_a_file(tmp_path: Path) -> None:
    from click.testing import CliRunner

    task = WalkTask("walk_level", residual=True)
    written(tmp_path / "policy.onnx", task)
    done = CliRunner().invoke(
        main, ["walk", "level", "--controller", f"policy:{tmp_path / 'policy.onnx'}", "--steps", "2"]
    )
    assert done.exit_code == 0, done.output
    for words, message in (
        (["--controller", f"policy:{tmp_path / 'other.onnx'}"], "there is no such file"),
        (["--controller", f"adaptive:{tmp_path / 'policy.onnx'}"], "no file describes the controller adaptive"),
    ):
        failed = CliRunner().invoke(main, ["walk", "level", *words])
        assert failed.exit_code == 2
        assert message in " ".join(failed.output.split())


def test_files_that_are_no_policies_are_named(tmp_path: Path) -> None:
    file = tmp_path / "policy.onnx"
    written(file, WalkTask("walk_level"), {})
    with pytest.raises(InputError, match="does not say for which task"):
        OnnxController(str(file))
    robot = {"robot": mjbiped.Compass().to_dict()}
    for described in ({"name": "walk_level"}, {**robot, "name": "fly"}, {**robot, "wings": 2}, {"robot": 5}):
        written(file, WalkTask("walk_level"), described)
        with pytest.raises(InputError, match="describes its policy's task in a way"):
            OnnxController(str(file))
    written(file, WalkTask("walk_level"))
    with pytest.raises(InputError, match="is another policy than the one recorded"):
        OnnxController(str(file), sha256="0")
    file.write_bytes(b"nothing")
    with pytest.raises(InputError, match="is no ONNX file"):
        OnnxController(str(file))


def test_names_are_known_without_the_extra() -> None:
    assert controller_class("policy:walk.onnx") is OnnxController
    assert settings_of("policy:walk.onnx")["file"] == "walk.onnx"


def test_studies_find_a_file_beside_them_and_notice_another(tmp_path: Path) -> None:
    (tmp_path / "walk.onnx").write_bytes(b"a policy")
    reference = located("policy:walk.onnx", tmp_path)
    assert reference == f"policy:{tmp_path / 'walk.onnx'}"
    assert digest_of(reference) == hashlib.sha256(b"a policy").hexdigest()
    with pytest.raises(InputError, match="there is no such file"):
        digest_of("policy:nowhere.onnx")
