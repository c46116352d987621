"""The training: the same seed gives the same policy to the last bit, broken off or not."""

from __future__ import annotations

import io
import os
import tracemalloc
import zipfile
from collections.abc import Callable
from dataclasses import fields, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import mjbiped
from mjbiped.envs import TASKS
from mjbiped.errors import InputError
from scripts.learning import evaluate, evaluation, training
from scripts.learning import train as program
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.evaluation import GROUNDS, THROUGH, Ground, Results, adaptive_on, by_training, interval
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


STORED = evaluate.STORED / "free-1.npz"


def changed(path: Path, **arrays: ArrayLike) -> None:
    """A stored policy with other arrays."""
    with np.load(STORED) as file, path.open("wb") as stream:
        np.savez(stream, **{**file, **arrays})


def claiming(path: Path) -> None:
    """A policy with a header that claims 745 GiB."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**11,)})
    with zipfile.ZipFile(STORED) as stored, zipfile.ZipFile(path, "w") as archive:
        for name in stored.namelist():
            archive.writestr(name, stream.getvalue() if name == "returns.npy" else stored.read(name))


def one_array(path: Path) -> None:
    with path.open("wb") as stream:
        np.save(stream, np.zeros(3))


DAMAGED: dict[str, tuple[Callable[[Path], Any], str]] = {
    "one array": (one_array, "File is not a zip file"),
    "text": (lambda path: path.write_text("a policy"), "File is not a zip file"),
    "pipe": (os.mkfifo, "is a device or a pipe"),
    "claims": (claiming, "cannot reshape"),
    "seed of text": (lambda path: changed(path, seed="one"), "seed is of type <U3"),
    "seeds": (lambda path: changed(path, seed=[1, 2]), r"seed is of type int64 and shape \(2,\)"),
    "seed of none": (lambda path: changed(path, seed=np.nan), "seed is of type float64"),
    "kinds": (lambda path: changed(path, residual=[True, False]), "residual is of type bool"),
    "weights": (lambda path: changed(path, weights=np.full((2, 2, 8), np.nan)), "weights holds what is no finite"),
    "shape": (lambda path: changed(path, weights=np.zeros((2, 2, 7))), r"expected float64 and \(2, 2, 8\)"),
    "generations": (lambda path: changed(path, steps=np.zeros(3)), r"steps is of type float64 and shape \(3,\)"),
    "returns": (lambda path: changed(path, returns=np.array(3.0)), "expected generations, policies, grounds"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_policy_is_refused(name: str, tmp_path: Path) -> None:
    damage, message = DAMAGED[name]
    path = tmp_path / "free-1.npz"
    damage(path)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=message) as refused:
            Checkpoint.load(path)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()
    assert str(path) in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


def test_an_interval_holds_the_mean_as_often_as_it_says() -> None:
    """Of 500 samples of five normal numbers, 95 %."""
    samples = np.random.default_rng(3).normal(1.0, 2.0, (500, 5))
    held = np.mean([low <= 1.0 <= high for _, low, high in map(interval, samples)])
    # the share's standard deviation is sqrt(0.95 * 0.05 / 500) = 0.01
    assert held == pytest.approx(evaluation.CONFIDENCE, abs=0.03)


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


def test_the_training_has_not_seen_these_grounds() -> None:
    """NumPy takes (2, 5) and (2, 5, 0) for one seed, so the first number must be one that no training has."""
    assert np.random.default_rng((2, 5)).random() == np.random.default_rng((2, 5, 0)).random()
    seeds = {seed[0] for ground in GROUNDS for seed in ground.seeds}
    (least,) = (option.type.min for option in program.main.params if option.name == "seed")  # type: ignore[attr-defined]
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
