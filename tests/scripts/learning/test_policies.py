"""The stored policies are those of the page: they load, walk, and reach what its tables say."""

from __future__ import annotations

import numpy as np
import pytest
from documentation import table

import mjbiped
from mjbiped.envs.tasks import WalkTask
from scripts.learning import evaluate
from scripts.learning.controller import LearnedController
from scripts.learning.evaluation import GROUNDS, by_training, interval, try_out
from scripts.learning.rollouts import Rollouts

SMALL = 1_000_000
"""Bytes that all of them may take together."""


def test_there_are_five_of_each_kind_and_they_are_small() -> None:
    trainings = evaluate.trained(evaluate.STORED)
    assert {kind: [training.seed for training in of] for kind, of in trainings.items()} == {
        kind: [1, 2, 3, 4, 5] for kind in evaluate.KINDS
    }
    assert all(training.residual == (kind == "residual") for kind, of in trainings.items() for training in of)
    assert sum(file.stat().st_size for file in evaluate.STORED.iterdir()) < SMALL


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


def test_one_walks_by_its_name() -> None:
    engine = mjbiped.Mujoco(timestep=4e-3, control_period=0.02)
    controller = LearnedController(str(evaluate.STORED / "free-1.npz"))
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine=engine, steps=3)
    assert (walk.steps, walk.outcome) == (3, "finished")


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
