"""The evaluation: intervals, pairs, and grounds that no training has seen."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from legible import assert_legible

from mjbiped.envs import TASKS
from scripts.learning import evaluate, evaluation
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.curve import plot_curves
from scripts.learning.evaluation import GROUNDS, Ground, Results, interval, intervals
from scripts.learning.policy import WEIGHTS
from scripts.learning.train import SEED
from scripts.learning.training import seeds_of


def training(residual: bool, generations: int = 3) -> Checkpoint:
    """What a training might have come to."""
    random = np.random.default_rng(1)
    returns = random.uniform(100.0, 900.0, (generations, 24, 4))
    times = np.arange(1.0, generations + 1.0)
    return Checkpoint(residual, SEED, np.zeros(WEIGHTS), returns, returns[:, 0], 1e5 * times, 20 * times, 30 * times)


def test_an_interval_holds_the_mean_as_often_as_it_says() -> None:
    """95 % of 100 samples of 30."""
    random = np.random.default_rng(3)
    samples = random.exponential(size=(100, 30))
    held = sum(low <= 1.0 <= high for _, low, high in map(interval, samples))
    # of 30 skewed values it holds somewhat less often than it says, some 92 %; three standard deviations are 8 of 100
    assert held >= 84


def test_intervals_of_few_and_of_equal_values() -> None:
    assert np.isnan(interval(np.zeros(0))).all()
    assert interval(np.array([2.0]))[0] == 2.0
    assert np.isnan(interval(np.array([2.0]))[1:]).all()
    assert interval(np.ones(5, dtype=bool)) == (1.0, 1.0, 1.0)


def results(cost: list[float], finished: list[bool]) -> Results:
    values = np.array(cost)
    pair = np.column_stack([values, values])
    return Results("level", "x", values, 60.0 * values, np.array(finished), values, values, pair, pair)


def test_costs_are_compared_where_both_have_walked_to_the_end() -> None:
    of = intervals(
        results([0.05, 0.07, 9.0, 0.04], [True, True, False, True]),
        results([0.04, 0.05, 0.04, 9.0], [True, True, True, False]),
    )
    assert of["cost less adaptive"][0] == pytest.approx(0.015)
    assert of["cost"][0] == pytest.approx(0.16 / 3)


def test_the_training_has_not_seen_these_grounds() -> None:
    seeds = {seed for ground in GROUNDS for seed in ground.seeds}
    assert not {seed[0] for seed in seeds} & {seed[0] for seed in seeds_of(SEED, 0)}
    assert {ground.task for ground in GROUNDS} == set(TASKS)


@pytest.mark.slow
def test_zero_residual_is_the_adaptive_controller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole program on little: a residual policy of zeros does what the adaptive controller does, bitwise."""
    monkeypatch.setattr(evaluation, "STEPS", 3)
    monkeypatch.setattr(evaluate, "GROUNDS", (Ground("random", "walk_random", 2, {"length": 5.0}),))
    for name in ("SHOWN", "SMALL_SHOWN"):
        monkeypatch.setattr(evaluate, name, 0.1)  # s
    training(True).save(tmp_path / "residual.npz")
    page = tmp_path / "page.md"
    (tmp_path / "images").mkdir()
    page.write_text("<!-- walking -->\n<!-- end walking -->\n<!-- torques -->\n<!-- end torques -->\n")
    said = CliRunner().invoke(evaluate.main, ["--out", str(tmp_path), "--page", str(page)])
    assert said.exit_code == 0, said.output
    with (tmp_path / "evaluation.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 4
    of = {
        name: [{**row, "controller": ""} for row in rows if row["controller"] == name]
        for name in ("adaptive", "residual")
    }
    assert of["adaptive"] == of["residual"]
    assert all(row["finished"] == "True" for row in rows)
    assert page.read_text().count("| random | residual |") == 2
    for name in ("residual.mp4", "curves.png", "images/learning.png", "images/learning.gif"):
        assert (tmp_path / name).stat().st_size > 1000


def test_without_a_policy_it_says_how_to_train_one(tmp_path: Path) -> None:
    said = CliRunner().invoke(evaluate.main, ["--out", str(tmp_path)])
    assert said.exit_code == 2
    assert "train one: python -m scripts.learning.train" in said.output


def test_the_curves_are_legible() -> None:
    assert_legible(plot_curves({"residual": training(True), "free": training(False)}, 893.0), "page")
