"""Episodes of environments, and the walks of `mjbiped.walk` that they are to be."""

import numpy as np
from numpy.typing import NDArray

import mjbiped
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.records.record import Walk


def begun(task: WalkTask, seed: int = 0) -> Walkers:
    walkers = Walkers(task)
    walkers.begin(0, np.random.default_rng(seed))
    return walkers


def walked(walkers: Walkers, actions: NDArray[np.float64]) -> NDArray[np.float64]:
    """What is felt and rewarded after each action."""
    rows = []
    for action in actions:
        walkers.actions[0] = action
        walkers.step()
        rows.append([*walkers.felt[0], walkers.columns["reward"][0], walkers.columns["outcome"][0]])
    return np.array(rows)


def random_actions(task: WalkTask, count: int, seed: int = 1) -> NDArray[np.float64]:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (count, len(task.limits))) * task.limits


def repeated(walkers: Walkers) -> Walk:
    """The walk of `mjbiped.walk` by what the record of an episode says of itself."""
    record, task = walkers.walk(), walkers.task
    settings = record.settings
    return mjbiped.walk(
        task.controller.inner,
        record.terrain,
        engine=task.engine,
        initial=settings["initial"],
        steps=settings["steps"],
        robot=record.robot,
        disturbances=walkers.walker().episode.disturbances,
    )


def assert_begins_like(record: Walk, other: Walk) -> None:
    """All rows of a record are bitwise the first of another's."""
    for mine, theirs in ((record.touchdowns, other.touchdowns), (record.samples, other.samples)):
        for name, column in mine.items():
            np.testing.assert_array_equal(column, theirs[name][: len(column)], err_msg=name)
