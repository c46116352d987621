"""The training: the same seed gives the same policy to the last bit, broken off or not."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from mjbiped.errors import InputError
from scripts.learning import train as program
from scripts.learning import training
from scripts.learning.checkpoint import Checkpoint
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


@pytest.mark.slow
def test_the_program_goes_on_bitwise_and_keeps_seeds_apart(tmp_path: Path) -> None:
    def trained(folder: str, generations: int, seed: int = 1) -> str:
        words = ["--task", "free", "--out", tmp_path / folder, "--generations", generations, "--seed", seed]
        result = CliRunner().invoke(program.main, [str(word) for word in words])
        assert result.exit_code == 0, result.output
        return result.output

    assert "processor time" in trained("stopped", 1)
    assert "1 generations so far" in trained("stopped", 2)
    trained("whole", 2)
    file = tmp_path / "stopped" / "free-1.npz"
    assert_same(Checkpoint.load(file), Checkpoint.load(tmp_path / "whole" / "free-1.npz"))
    written = file.read_bytes()
    trained("stopped", 2)
    trained("stopped", 1, seed=2)
    assert file.read_bytes() == written, "it has its generations, and another seed is another file"
    file.rename(file.with_name("residual-1.npz"))
    words = ["--task", "residual", "--out", str(file.parent), "--generations", "2"]
    wrong = CliRunner().invoke(program.main, words)
    assert (wrong.exit_code, "holds another training" in wrong.output) == (2, True)


def test_no_generation_walks_on_the_grounds_of_another() -> None:
    seeds = {seed for generation in range(100) for seed in seeds_of(1, generation)}
    assert len(seeds) == 100 * training.GROUNDS


def test_examples_in_the_help_stay_lines() -> None:
    result = CliRunner().invoke(program.main, ["--help"])
    assert "\n      python -m scripts.learning.train --task residual --seed 1 --generations 20\n" in result.output
