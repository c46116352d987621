"""docs/environments.md: its code runs, and its numbers are those of the tasks."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjbiped.envs import IDS, TASKS, observation
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.utils.files import markdown_table

PAGE = (Path(__file__).parents[2] / "docs" / "environments.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_its_numbers_are_those_of_the_tasks() -> None:
    free, residual = WalkTask("walk_level"), WalkTask("walk_level", residual=True)
    for number in (*free.limits, *residual.limits, *free.peak):
        assert f"{number:.4g} N m" in PAGE
    for name in (*IDS, *TASKS, *observation.observed(3)):
        assert f"`{name}`" in PAGE
    # the last columns of the reward's table: means over the first episode with its random start, to its two digits
    means = np.array([mean_terms(robot) for robot in ("compass", "kneed")])
    for name, (straight, kneed) in zip(("progress", "economy"), means.T, strict=True):
        row = next(line for line in PAGE.splitlines() if line.startswith(f"| {name} "))
        assert row.endswith(f"| {straight:.2f} | {kneed:.2f} |")


def test_its_table_of_observations_is_the_codes() -> None:
    straight = {field.name: place for field, place in observation.fields_of(2, privileged=True).items()}
    rows = []
    for field, place in observation.fields_of(3, privileged=True).items():
        places = numbers(straight[field.name]) if field.name in straight else "", numbers(place)
        only = "only with `privileged=True`: " if field.of == "privileged" else ""
        ends = f"{field.low:g} to {field.high:g}".replace("-", "−")
        rows.append([f"`{field.name}`", *places, only + field.meaning, ends])
    headings = ["name in dm_control", "numbers in Gymnasium", "with knees", "what it is", "bounds"]
    assert markdown_table(headings, rows) in PAGE


def numbers(place: slice) -> str:
    count, last = place.stop - place.start, place.stop - 1
    return f"{last}" if count == 1 else f"{place.start}, {last}" if count == 2 else f"{place.start} to {last}"


def mean_terms(robot: str) -> Any:
    walkers = Walkers(WalkTask("walk_level", residual=True, robot=robot))
    walkers.begin(0, np.random.default_rng(0))
    terms = []
    for _ in range(1000):
        walkers.step()
        terms.append((walkers.columns["reward_progress"][0], walkers.columns["reward_economy"][0]))
    return np.mean(terms, axis=0)
