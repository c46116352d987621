"""The stored policies are those of the page: they load, walk, and reach what its tables say."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documentation import table

from mjbiped.envs.tasks import WalkTask
from mjbiped.records.record import Walk
from scripts.learning import evaluate
from scripts.learning.evaluation import GROUNDS, by_training, interval, try_out
from scripts.learning.rollouts import WEIGHTS, Array, Rollouts, actions

import gymnasium  # isort: skip
from command_line import run

import mjbiped
from scripts.learning.checkpoint import Checkpoint


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


FILE = Path(__file__).parents[2] / "scripts" / "learning" / "controller.py"


def policy(folder: Path, residual: bool) -> Path:
    """The file of one that does a little, at random."""
    one = np.zeros(1)
    weights = np.random.default_rng(5).normal(0.0, 0.003, WEIGHTS)
    path = folder / "policy.npz"
    Checkpoint(residual, 1, weights, np.zeros((1, 2, 1)), np.zeros((1, 1)), one, one, one).save(path)
    return path


def test_walks_by_name_in_both_engines(tmp_path: Path) -> None:
    words = ["--controller", f"{FILE}:LearnedController", "--gain", f"checkpoint={policy(tmp_path, True)}"]
    for engine in ("mujoco", "hybrid"):
        result = run("walk", "level", *words, "--engine", engine, "--steps", 2, "--out", tmp_path / f"{engine}.npz")
        assert result.exit_code == 0, result.output
        walk = mjbiped.Walk.load(tmp_path / f"{engine}.npz")
        assert (walk.steps, walk.outcome) == (2, "finished")
        assert walk.settings["controller"]["driven"]["base"]["name"] == "AdaptiveController"
