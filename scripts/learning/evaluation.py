"""Policies of several trainings beside the adaptive controller, on the same unseen grounds and from the same starts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from mjbiped.envs.tasks import WalkTask
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.rules.termination import Outcome
from scripts.learning.rollouts import WEIGHTS, Array, Rollouts

SEED = 0
"""First number of the seeds here. Those of trainings are 1 and more, so that none has seen these grounds."""
TIME = 40.0
"""Longest walk, s: twice an episode of the training."""
LENGTH = 40.0
"""Of random ground, m: more than a robot walks in that time."""
THROUGH = Outcome.TIME_LIMIT.words
"""Outcome of a walk that time ended."""
CONFIDENCE = 0.95

Interval = tuple[float, float, float]
"""A mean and the ends of its interval; NaN where there is none."""


@dataclass(frozen=True)
class Ground:
    """A ground to try controllers on.

    Attributes:
        name: In words.
        task: Its name in `mjbiped.envs.TASKS`.
        walks: Of each policy.
        terrain: Parameters of its preset, other than the task's own.
    """

    name: str
    task: str
    walks: int
    terrain: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def residual(self) -> WalkTask:
        """The task with actions that are added to the adaptive controller's torques."""
        return WalkTask(self.task, residual=True, terrain=self.terrain)

    @cached_property
    def free(self) -> WalkTask:
        """The task with actions that are all there is."""
        return WalkTask(self.task, residual=False, terrain=self.terrain)

    @property
    def seeds(self) -> list[tuple[int, int]]:
        """Of terrains and starts, the same for all controllers."""
        return [(SEED, index) for index in range(self.walks)]


GROUNDS = (
    Ground("random", "walk_random", 40, {"length": LENGTH}),
    Ground("rough", "walk_random", 40, {"length": LENGTH, "slope_deg": (-6.0, 6.0), "rise": (-0.05, 0.015)}),
    Ground("level", "walk_level", 10),
    Ground("slopes", "walk_slopes", 10),
    Ground("stairs", "walk_stairs", 10),
)
"""Random ground as in training but of other seeds; rougher than any of the training; the other tasks'."""


@dataclass(frozen=True)
class Results:
    """Of the policies of one kind on one ground: arrays have a row for each training and a column for each walk.

    Attributes:
        ground: Its name.
        kind: Of the policies.
        seeds: Of the trainings.
        outcomes: How the walks ended.
        measures: By their names: "return" of the first 20 s, "through" (1 for a walk that time ended, else 0), "steps"
            walked, "speed" in m/s, "c_mt", and in N m "peak ankle", "peak hip", "rms ankle" and "rms hip".
    """

    ground: str
    kind: str
    seeds: tuple[int, ...]
    outcomes: NDArray[np.str_]
    measures: Mapping[str, Array]

    @property
    def through(self) -> NDArray[np.bool_]:
        """Walks that time ended."""
        ended: NDArray[np.bool_] = self.outcomes == THROUGH
        return ended

    def rows(self) -> Iterator[dict[str, Any]]:
        """One for each walk, for a table."""
        for (policy, walk), outcome in np.ndenumerate(self.outcomes):
            yield {
                "ground": self.ground,
                "controller": self.kind,
                "seed": self.seeds[policy],
                "walk": walk,
                "outcome": str(outcome),
                **{name: values[policy, walk] for name, values in self.measures.items()},
            }

    def ends(self) -> str:
        """How many walks ended before their time, how, and in how many of the fewest and the most by training."""
        early = Counter(self.outcomes[~self.through].tolist())
        told = ", ".join(f"{count} {outcome}" for outcome, count in early.most_common()) or "none"
        each = (~self.through).sum(axis=1)
        spread = f" ({each.min()} to {each.max()})" if len(self.seeds) > 1 and early else ""
        return f"{told} of {self.outcomes.size}{spread}"


def try_out(
    ground: Ground, kind: str, seeds: tuple[int, ...], weights: Array, residual: bool, *, threads: int | None = None
) -> tuple[Results, Walk]:
    """Let policies walk on a ground, once for each of its seeds.

    Args:
        ground: Which.
        kind: Name of the policies' kind.
        seeds: Of their trainings.
        weights: Shape (policies, *`scripts.learning.rollouts.WEIGHTS`); zeros that are a residual are the adaptive
            controller.
        residual: Whether they are residuals.
        threads: In which robots walk; no result depends on it.

    Returns:
        What they reached, and the first policy's first walk.
    """
    task = ground.residual if residual else ground.free
    shape = (len(weights), ground.walks)
    episodes = Rollouts(task, shape[0] * shape[1], threads=threads)
    returns = episodes.returns(weights, ground.seeds)
    episodes.close()
    longer = Rollouts(replace(task, time_limit=TIME), shape[0] * shape[1], threads=threads, recorded=True)
    longer.returns(weights, ground.seeds)
    walks = longer.walks()
    longer.close()

    peak = np.array([walk.peak_torque for walk in walks])
    rms = np.array([np.sqrt(np.mean(np.square(walk.samples["torque"]), axis=0)) for walk in walks])
    outcomes = np.array([walk.outcome for walk in walks])
    columns = {
        "through": outcomes == THROUGH,
        "steps": [walk.steps for walk in walks],
        "speed": [measures.speed(walk) for walk in walks],
        "c_mt": [walk.cost_of_transport for walk in walks],
        "peak ankle": peak[:, 0],
        "peak hip": peak[:, 1],
        "rms ankle": rms[:, 0],
        "rms hip": rms[:, 1],
    }
    reached = {name: np.asarray(column, dtype=np.float64).reshape(shape) for name, column in columns.items()}
    return Results(ground.name, kind, seeds, outcomes.reshape(shape), {"return": returns, **reached}), walks[0]


def adaptive_on(ground: Ground) -> Results:
    """What the adaptive controller reaches on a ground."""
    return try_out(ground, "adaptive", (0,), np.zeros((1, *WEIGHTS)), residual=True)[0]


WHOLE = ("return", "through", "steps")
"""Measures of all walks. The others are of those that time ended: a fall has its own."""


def by_training(of: Results, measure: str, adaptive: Results | None = None) -> Array:
    """Mean of a measure over the walks of each training; or of its differences from the adaptive controller's.

    Args:
        of: The policies'.
        measure: Its name.
        adaptive: The adaptive controller's results on the same ground. Walks are compared one by one.

    Returns:
        A number for each training that has walks to tell of.
    """
    values, counted = of.measures[measure], of.through
    if adaptive is not None:
        values, counted = values - adaptive.measures[measure], counted & adaptive.through
    if measure in WHOLE:
        counted = np.ones_like(counted)
    return np.array([row[those].mean() for row, those in zip(values, counted, strict=True) if those.any()])


def interval(trainings: Array) -> Interval:
    """The mean over independent trainings, and its 95 % interval by Student's t.

    Args:
        trainings: A number for each; without two of them there is no interval.
    """
    count = len(trainings)
    if count == 0:
        return np.nan, np.nan, np.nan
    mean = float(np.mean(trainings))
    if count == 1:
        return mean, np.nan, np.nan
    half = float(student.ppf(0.5 + CONFIDENCE / 2.0, count - 1) * np.std(trainings, ddof=1) / np.sqrt(count))
    return mean, mean - half, mean + half
