"""The training: the same seed gives the same policy to the last bit, broken off or not."""

from dataclasses import fields, replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from mjbiped.envs import TASKS
from mjbiped.errors import InputError
from scripts.learning import evaluation, training
from scripts.learning import train as program
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.evaluation import GROUNDS, interval
from scripts.learning.training import seeds_of, train

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


def assert_same(one: Checkpoint, other: Checkpoint) -> None:
    for field in fields(Checkpoint):
        if field.name not in TIMES:
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name), err_msg=field.name)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_policy_bitwise() -> None:
    """Whatever the threads, and whatever became of NumPy's global generator."""
    first = after(3)
    np.random.seed(99)  # noqa: NPY002 (what an optimiser might draw from)
    assert_same(first, after(3, threads=2))
    assert not np.array_equal(first.weights, after(3, seed=4).weights)


@pytest.mark.slow
def test_goes_on_bitwise_where_it_was_broken_off(tmp_path: Path) -> None:
    after(2).save(tmp_path / "free.npz")
    read = Checkpoint.load(tmp_path / "free.npz")
    went_on = after(2, read)
    assert_same(went_on, after(4))
    assert went_on.generations == 4
    assert np.all(np.diff(went_on.wall) > 0.0)
    assert np.all(np.diff(went_on.steps) > 0.0)


def test_returns_that_lead_elsewhere_are_refused() -> None:
    """A file of other settings is not gone on with as if it were of these."""
    reached = after(2)
    with pytest.raises(InputError, match="remove its file to begin anew"):
        after(1, replace(reached, weights=reached.weights + 1e-12))
    with pytest.raises(InputError, match="remove its file to begin anew"):
        after(1, replace(reached, returns=reached.returns[:, :, :1]))


@pytest.mark.slow
def test_a_residual_begins_as_the_adaptive_controller() -> None:
    """The first mean is zero, and the walk of 20 s on random ground returns what docs/environments.md's table says."""
    run = train(True, 1, threads=1)
    first = next(run)
    run.close()
    # 0.71 + 0.19 in each of 1000 steps on level ground; random ground costs and gives a few percent
    assert first.mean_returns[0] == pytest.approx(900.0, rel=0.05)


def test_an_interval_holds_the_mean_as_often_as_it_says() -> None:
    """Of 500 samples of five normal numbers, 95 %."""
    samples = np.random.default_rng(3).normal(1.0, 2.0, (500, 5))
    held = np.mean([low <= 1.0 <= high for _, low, high in map(interval, samples)])
    # the share's standard deviation is sqrt(0.95 * 0.05 / 500) = 0.01
    assert held == pytest.approx(evaluation.CONFIDENCE, abs=0.03)


def test_the_training_has_not_seen_these_grounds() -> None:
    """NumPy takes (2, 5) and (2, 5, 0) for one seed, so the first number must be one that no training has."""
    assert np.random.default_rng((2, 5)).random() == np.random.default_rng((2, 5, 0)).random()
    seeds = {seed[0] for ground in GROUNDS for seed in ground.seeds}
    (least,) = (option.type.min for option in program.main.params if option.name == "seed")  # type: ignore[attr-defined]
    assert max(seeds) < least
    assert seeds_of(least, 0)[0][0] == least
    assert {ground.task for ground in GROUNDS} == set(TASKS)
