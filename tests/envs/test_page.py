"""docs/environments.md: its code runs, and its numbers are those of the tasks."""

from pathlib import Path

import numpy as np

from mjbiped.envs import IDS, TASKS, feeling
from mjbiped.envs.tasks import PEAK, RESIDUAL, TORQUE, WalkTask
from mjbiped.envs.walkers import Walkers

PAGE = (Path(__file__).parents[2] / "docs" / "environments.md").read_text(encoding="utf-8")


def test_its_numbers_are_those_of_the_tasks() -> None:
    for number in (*TORQUE, *RESIDUAL, *PEAK):
        assert f"{number:.4g} N m" in PAGE
    for name in (*IDS, *TASKS, *feeling.OBSERVED):
        assert f"`{name}`" in PAGE
    # the table's last column: means over the first episode with its random start, to its two digits
    walkers = Walkers(WalkTask("walk_level", residual=True))
    walkers.begin(0, np.random.default_rng(0))
    terms = []
    for _ in range(1000):
        walkers.step()
        terms.append((walkers.value(feeling.PROGRESS)[0], walkers.value(feeling.ECONOMY)[0]))
    progress, economy = np.mean(terms, axis=0)
    assert f"| {progress:.2f} |" in PAGE
    assert f"| {economy:.2f} |" in PAGE
