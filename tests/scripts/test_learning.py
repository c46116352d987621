"""Learned policies: trainings repeat themselves to the last bit, and the stored ones are those of the page."""

from dataclasses import fields
from itertools import islice
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from command_line import run

import mjbiped
from mjbiped.envs.tasks import WalkTask
from mjbiped.records.record import Walk
from scripts.learning import training
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.rollouts import WEIGHTS, Array, Rollouts, actions
from scripts.learning.training import train

TIMES = {"wall", "processor"}  # the only fields that differ from run to run


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few robots, which in the first generations fall after two seconds."""
    monkeypatch.setattr(training, "POPULATION", 6)
    monkeypatch.setattr(training, "GROUNDS", 2)


def after(generations: int, before: Checkpoint | None = None, *, seed: int = 1, threads: int = 1) -> Checkpoint:
    run = train(False, seed, before, threads=threads)
    *_, last = islice(run, generations)
    run.close()
    return last


@pytest.mark.slow
def test_a_seed_gives_one_policy_bitwise_broken_off_or_not(tmp_path: Path) -> None:
    """Whatever the threads, and whatever became of NumPy's global generator."""
    after(2).save(tmp_path / "free.npz")
    np.random.seed(99)  # noqa: NPY002 (what an optimiser might draw from)
    went_on, whole = after(2, Checkpoint.load(tmp_path / "free.npz")), after(4, threads=2)
    for field in fields(Checkpoint):
        if field.name not in TIMES:
            np.testing.assert_array_equal(getattr(went_on, field.name), getattr(whole, field.name), field.name)
    assert went_on.generations == 4
    assert np.all(np.diff([went_on.wall, went_on.steps]) > 0.0)
    assert not np.array_equal(whole.weights, after(4, seed=4).weights)


# ---- stored policies -----------------------------------------------------------------------------------------------


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


def test_walks_by_name_in_both_engines(tmp_path: Path) -> None:
    """A policy that does a little, at random."""
    one, weights = np.zeros(1), np.random.default_rng(5).normal(0.0, 0.003, WEIGHTS)
    file = tmp_path / "policy.npz"
    Checkpoint(True, 1, weights, np.zeros((1, 2, 1)), np.zeros((1, 1)), one, one, one).save(file)
    words = ["--controller", f"{FILE}:LearnedController", "--gain", f"checkpoint={file}", "--steps", 2]
    for engine in ("mujoco", "hybrid"):
        result = run("walk", "level", *words, "--engine", engine, "--out", tmp_path / f"{engine}.npz")
        assert result.exit_code == 0, result.output
        walk = mjbiped.Walk.load(tmp_path / f"{engine}.npz")
        assert (walk.steps, walk.outcome) == (2, "finished")
        assert walk.settings["controller"]["driven"]["base"]["name"] == "AdaptiveController"
