"""The stored policies are those of the page: they load, walk, and reach what its tables say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documentation import table

from mjbiped.controllers.policy import FEATURES
from mjbiped.envs.tasks import WalkTask
from mjbiped.records.record import Walk
from scripts.learning import evaluate
from scripts.learning.evaluation import GROUNDS, by_training, interval, try_out
from scripts.learning.rollouts import WEIGHTS, Array, Rollouts, actions

import gymnasium  # isort: skip
from command_line import run

import mjbiped
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.controller import LearnedController


def test_there_are_five_of_each_kind_and_they_are_small() -> None:
    trainings = evaluate.trained(evaluate.STORED)
    assert {kind: [training.seed for training in of] for kind, of in trainings.items()} == {
        kind: [1, 2, 3, 4, 5] for kind in evaluate.KINDS
    }
    assert all(training.residual == (kind == "residual") for kind, of in trainings.items() for training in of)
    assert sum(file.stat().st_size for file in evaluate.STORED.iterdir()) < 1_000_000


def test_the_page_says_what_the_trainings_took() -> None:
    headings, rows = evaluate.training_table(evaluate.trained(evaluate.STORED))
    assert [dict(zip(headings, row, strict=True)) for row in rows] == table("learning", "trainings")


@pytest.mark.parametrize("kind", evaluate.KINDS)
def test_all_walk_two_seconds_of_level_ground(kind: str) -> None:
    trainings = evaluate.trained(evaluate.STORED)[kind]
    task = WalkTask("walk_level", residual=kind == "residual", time_limit=2.0)
    rollouts = Rollouts(task, len(trainings), threads=1, recorded=True)
    rollouts.returns(np.array([training.weights for training in trainings]), [(0,)])
    walks = rollouts.walks()
    rollouts.close()
    assert [walk.outcome for walk in walks] == ["time limit"] * len(trainings)
    # the gait has a step in 0.76 s; none of them walks slower by half
    assert all(walk.steps >= 2 for walk in walks)


@pytest.mark.slow
@pytest.mark.parametrize("kind", evaluate.KINDS)
def test_the_page_says_what_they_return_on_level_ground(kind: str) -> None:
    ground = next(ground for ground in GROUNDS if ground.name == "level")
    trainings = evaluate.trained(evaluate.STORED)[kind]
    weights = np.array([training.weights for training in trainings])
    seeds = tuple(training.seed for training in trainings)
    found, _ = try_out(ground, kind, seeds, weights, kind == "residual")
    told = evaluate.in_words(interval(by_training(found, "return")), 0)
    (row,) = (row for row in table("learning", "returns") if (row["ground"], row["controller"]) == ("level", kind))
    assert row["return"] == told


@pytest.mark.parametrize("time", [0.0, 0.3, 0.765, 1.2, 3.0])
def test_gains_go_with_time_up_to_a_latest(time: float) -> None:
    random = np.random.default_rng(1)
    weights = random.normal(size=(3, *WEIGHTS))
    angles, rates = random.normal(size=(2, 3, 2))
    stance, slope = random.normal(size=(2, 3))
    told = actions(weights, angles, rates, np.full(3, time), stance, slope)
    phase = 2.0 * min(time / 0.765, 1.5) - 1.0
    for robot in range(3):
        features = [*angles[robot] / 0.2, *rates[robot], phase, stance[robot] / 0.2 + 1.0, slope[robot] / 0.035, 1.0]
        for joint in range(2):
            constant, with_time = weights[robot, joint]
            expected = sum((constant[k] + with_time[k] * phase) * features[k] for k in range(len(FEATURES)))
            # sums of 16 numbers of size one in another order
            assert told[robot, joint] == pytest.approx(expected, abs=1e-13)


def test_each_robot_has_its_own_policy() -> None:
    """A robot's action depends neither on the others nor on how many there are, to the last bit."""
    random = np.random.default_rng(2)
    weights = random.normal(size=(7, *WEIGHTS))
    felt = [random.normal(size=(7, 2)), random.normal(size=(7, 2)), random.uniform(size=7), *random.normal(size=(2, 7))]
    together = actions(weights, *felt)
    for robot in range(7):
        alone = actions(weights[robot : robot + 1], *(part[robot : robot + 1] for part in felt))
        np.testing.assert_array_equal(alone[0], together[robot])


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


DOWNHILL = mjbiped.Terrain.from_segments(
    [(0.9, 2.0, 0.0), (0.8, 2.3, 0.0), (9.0, 2.0, 0.0)]
)  # walks with little torque
FILE = Path(__file__).parents[2] / "scripts" / "learning" / "controller.py"


def policy(folder: Path, residual: bool) -> Path:
    """The file of one that does a little, at random."""
    one = np.zeros(1)
    weights = np.random.default_rng(5).normal(0.0, 0.003, WEIGHTS)
    path = folder / "policy.npz"
    Checkpoint(residual, 1, weights, np.zeros((1, 2, 1)), np.zeros((1, 1)), one, one, one).save(path)
    return path


@pytest.mark.parametrize("residual", [True, False], ids=["residual", "free"])
def test_walks_bitwise_as_in_the_environment(residual: bool, tmp_path: Path) -> None:
    controller = LearnedController(str(policy(tmp_path, residual)))
    weights: Array = Checkpoint.load(tmp_path / "policy.npz").weights[None]
    env: Any = gymnasium.make("mjbiped/CompassWalk-v0", residual=residual, terrain=DOWNHILL).unwrapped
    felt, _ = env.reset(seed=4)
    slope = 0.0
    for _ in range(250):  # 5 s
        if felt[4]:
            slope += felt[6] - felt[9]
        row = felt[None]
        told = actions(weights, row[:, 0:2], row[:, 2:4], row[:, 5], row[:, 8], np.array([slope]))
        felt, _, over, _, _ = env.step(told[0])
        if over:
            break
    there = env.walk()
    env.close()
    start, engine = there.settings["initial"], mjbiped.Mujoco(timestep=4e-3, control_period=0.02)
    here = mjbiped.walk(controller, there.terrain, engine=engine, initial=start, steps=201, distance=1.5)
    assert 4 <= here.steps <= there.steps
    for name, column in here.touchdowns.items():
        if not name.startswith("slope_estimate"):  # the environment's controller reckons none
            np.testing.assert_array_equal(column, there.touchdowns[name][: here.steps], err_msg=name)


def test_walks_by_name_in_both_engines(tmp_path: Path) -> None:
    words = ["--controller", f"{FILE}:LearnedController", "--gain", f"checkpoint={policy(tmp_path, True)}"]
    for engine in ("mujoco", "hybrid"):
        result = run("walk", "level", *words, "--engine", engine, "--steps", 2, "--out", tmp_path / f"{engine}.npz")
        assert result.exit_code == 0, result.output
        walk = mjbiped.Walk.load(tmp_path / f"{engine}.npz")
        assert (walk.steps, walk.outcome) == (2, "finished")
        assert walk.settings["controller"]["driven"]["base"]["name"] == "AdaptiveController"


def test_the_slope_estimate_of_a_free_policy_is_the_turn_of_the_ground(tmp_path: Path) -> None:
    """On ground of two slopes, from the touchdown on the second on; exact, as (27) is."""
    controller = LearnedController(str(policy(tmp_path, False)))
    terrain = mjbiped.Terrain.from_segments([(0.3, 2.0, 0.0), (5.0, 3.0, 0.0)])
    walk = mjbiped.walk(controller, terrain, engine=mjbiped.Mujoco(timestep=4e-3, control_period=0.02), steps=2)
    assert walk.steps == 2
    # MuJoCo's foot stands within a fraction of a millimetre of where the leg's angle has it
    np.testing.assert_allclose(np.degrees(walk.touchdowns["slope_estimate"][1:]), 1.0, atol=0.02)
