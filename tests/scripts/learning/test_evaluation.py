"""The evaluation: trainings as independent units, pairs of walks, and grounds that no training has seen."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from legible import assert_legible

import mjbiped
from mjbiped.envs import TASKS
from scripts.learning import evaluate, evaluation, train
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.curve import plot_curves
from scripts.learning.evaluation import GROUNDS, THROUGH, Ground, Results, adaptive_on, by_training, interval
from scripts.learning.policy import WEIGHTS
from scripts.learning.training import seeds_of


def training(residual: bool, seed: int = 1, generations: int = 3) -> Checkpoint:
    """What a training might have come to."""
    random = np.random.default_rng(seed)
    returns = random.uniform(100.0, 900.0, (generations, 24, 4))
    times = np.arange(1.0, generations + 1.0)
    return Checkpoint(residual, seed, np.zeros(WEIGHTS), returns, returns[:, 0], 1e5 * times, 20 * times, 30 * times)


def test_an_interval_holds_the_mean_as_often_as_it_says() -> None:
    """Of 500 samples of five normal numbers, 95 %."""
    samples = np.random.default_rng(3).normal(1.0, 2.0, (500, 5))
    held = np.mean([low <= 1.0 <= high for _, low, high in map(interval, samples)])
    # the share's standard deviation is sqrt(0.95 * 0.05 / 500) = 0.01
    assert held == pytest.approx(evaluation.CONFIDENCE, abs=0.03)


def test_intervals_of_few_and_of_equal_values() -> None:
    assert np.isnan(interval(np.zeros(0))).all()
    assert interval(np.array([2.0]))[0] == 2.0
    assert np.isnan(interval(np.array([2.0]))[1:]).all()
    assert interval(np.ones(5)) == (1.0, 1.0, 1.0)


def results(kind: str, c_mt: list[list[float]], outcomes: list[list[str]]) -> Results:
    """Of so many trainings (rows) and walks (columns)."""
    values, ends = np.array(c_mt), np.array(outcomes)
    names = ("return", "steps", "speed", "c_mt", "peak ankle", "peak hip", "rms ankle", "rms hip")
    measures = {"through": (ends == THROUGH).astype(float), **dict.fromkeys(names, values)}
    return Results("level", kind, tuple(range(1, len(c_mt) + 1)), ends, measures)


ADAPTIVE = results("adaptive", [[0.04, 0.05, 0.04, 9.0]], [[THROUGH, THROUGH, THROUGH, "fell"]])
FREE = results(
    "free",
    [[0.05, 0.07, 9.0, 0.04], [0.06, 0.06, 0.09, 0.04], [7.0, 7.0, 7.0, 7.0]],
    [[THROUGH, THROUGH, "fell", THROUGH], [THROUGH] * 4, ["fell", "stalled", "fell", "fell"]],
)


def test_costs_are_compared_walk_by_walk_where_both_have_walked_through() -> None:
    np.testing.assert_allclose(by_training(FREE, "c_mt", ADAPTIVE), [0.015, (0.02 + 0.01 + 0.05) / 3])
    np.testing.assert_allclose(by_training(FREE, "c_mt"), [0.16 / 3, 0.25 / 4])


def test_a_fall_counts_in_what_is_said_of_all_walks() -> None:
    np.testing.assert_allclose(by_training(FREE, "through"), [0.75, 1.0, 0.0])
    np.testing.assert_allclose(by_training(FREE, "through", ADAPTIVE), [0.0, 0.25, -0.75])
    np.testing.assert_allclose(by_training(FREE, "return")[2], 7.0)


def test_tables_tell_ends_apart_and_mark_differences_beyond_the_spread() -> None:
    headings, rows = evaluate.results_table([ADAPTIVE, FREE], "through")
    assert headings[-1] == "ended early"
    assert [row[-1] for row in rows] == ["1 fell of 4", "4 fell, 1 stalled of 12 (0 to 4)"]
    steady = results("residual", [[0.14, 0.15, 0.14, 0.0], [0.15, 0.15, 0.15, 0.0]], [[THROUGH] * 4] * 2)
    costs = [row[4] for row in evaluate.results_table([ADAPTIVE, FREE, steady], "costs")[1]]
    assert costs[0] == ""
    assert not costs[1].endswith("*"), "0.015 and 0.027 are two trainings, whose interval is wide"
    level = results("residual", [[0.14, 0.15, 0.14, 0.0]] * 2, [[THROUGH] * 4] * 2)
    assert evaluate.results_table([ADAPTIVE, level], "costs")[1][1][4] == "0.1000 *"


def test_the_training_has_not_seen_these_grounds() -> None:
    """NumPy takes (2, 5) and (2, 5, 0) for one seed, so the first number must be one that no training has."""
    assert np.random.default_rng((2, 5)).random() == np.random.default_rng((2, 5, 0)).random()
    seeds = {seed[0] for ground in GROUNDS for seed in ground.seeds}
    (least,) = (option.type.min for option in train.main.params if option.name == "seed")  # type: ignore[attr-defined]
    assert max(seeds) < least
    assert seeds_of(least, 0)[0][0] == least
    assert {ground.task for ground in GROUNDS} == set(TASKS)


@pytest.mark.slow
def test_zero_residual_is_the_adaptive_controller_bitwise(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluation, "TIME", 3.0)
    ground = Ground("random", "walk_random", 1, {"length": 5.0})
    found = adaptive_on(ground)
    task, random = ground.residual, np.random.default_rng(ground.seeds[0])
    episode = task.episode(random)
    steps = int(found.measures["steps"][0, 0])
    walk = mjbiped.walk(task.controller.inner, episode.terrain, engine=task.engine, initial=episode.start, steps=steps)
    assert steps >= 3
    assert found.ends() == "none of 1"
    assert walk.cost_of_transport == found.measures["c_mt"][0, 0]


@pytest.mark.slow
def test_the_program_makes_tables_figures_and_videos(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole of it on little."""
    monkeypatch.setattr(evaluation, "TIME", 3.0)
    monkeypatch.setattr(evaluate, "GROUNDS", (Ground("random", "walk_random", 2, {"length": 5.0}),))
    for name in ("SHOWN", "SMALL_SHOWN"):
        monkeypatch.setattr(evaluate, name, 0.1)  # s
    for seed in (1, 2):
        training(True, seed).save(tmp_path / f"residual-{seed}.npz")
    images = tmp_path / "images"
    images.mkdir()
    words = [
        "--policies",
        str(tmp_path),
        "--out",
        str(tmp_path),
        "--tables",
        str(tmp_path / "tables"),
        "--images",
        str(images),
    ]
    said = CliRunner().invoke(evaluate.main, words)
    assert said.exit_code == 0, said.output
    with (tmp_path / "evaluation.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    of = {
        seed: [{**row, "controller": "", "seed": ""} for row in rows if row["seed"] == str(seed)] for seed in (0, 1, 2)
    }
    assert len(rows) == 6
    assert of[0] == of[1] == of[2], "their weights are zero"
    tables = [file.read_text(encoding="utf-8") for file in sorted((tmp_path / "tables").iterdir())]
    assert [table.count("random,residual,") for table in tables].count(1) == 4
    for name in ("residual.mp4", "curves.png", "images/learning.png", "images/learning.gif"):
        assert (tmp_path / name).stat().st_size > 1000


def test_without_a_policy_it_says_how_to_train_one(tmp_path: Path) -> None:
    said = CliRunner().invoke(evaluate.main, ["--policies", str(tmp_path)])
    assert said.exit_code == 2
    assert "train one: python -m scripts.learning.train" in said.output


def test_the_curves_are_legible() -> None:
    trainings = {kind: [training(kind == "residual", seed) for seed in range(1, 6)] for kind in evaluate.KINDS}
    assert_legible(plot_curves(trainings, 893.0), "page")
