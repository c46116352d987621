"""Controllers side by side on unseen ground: what they reach there, with intervals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import bootstrap

import mjbiped
from controllers import Controller
from mjbiped.envs.tasks import WalkTask
from mjbiped.records import measures
from mjbiped.records.record import Walk
from scripts.learning.policy import WEIGHTS, Array
from scripts.learning.rollouts import Rollouts

STEPS = 60
"""After which a walk has done enough."""
SEED = 2
"""First number of the seeds here; those of the training begin with `scripts.learning.train.SEED`."""
LENGTH = 30.0  # of random ground, m, so that 60 steps fit

Interval = tuple[float, float, float]
"""A mean and the ends of its 95 % interval; NaN where there is none."""


@dataclass(frozen=True)
class Ground:
    """A ground to try controllers on.

    Attributes:
        name: In words.
        task: Its name in `mjbiped.envs.TASKS`.
        walks: Of each controller.
        terrain: Parameters of its preset, other than the task's own.
    """

    name: str
    task: str
    walks: int
    terrain: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def residual(self) -> WalkTask:
        """The task with actions that are added to the adaptive controller's torques."""
        return self._settings(True)

    @cached_property
    def free(self) -> WalkTask:
        """The task with actions that are all there is."""
        return self._settings(False)

    def _settings(self, residual: bool) -> WalkTask:
        return WalkTask(self.task, residual=residual, terrain=self.terrain)

    @property
    def seeds(self) -> list[tuple[int, int]]:
        """Of terrains and starts, the same for all controllers."""
        return [(SEED, index) for index in range(self.walks)]


GROUNDS = (
    Ground("random", "walk_random", 40, {"length": LENGTH}),
    Ground("rough", "walk_random", 40, {"length": LENGTH, "slope_deg": (-6.0, 6.0), "rise": (-0.05, 0.015)}),
    Ground("level", "walk_level", 20),
    Ground("slopes", "walk_slopes", 20),
    Ground("stairs", "walk_stairs", 20),
)
"""Random ground as in training but of other seeds; rougher than any of the training; the other tasks'."""


@dataclass(frozen=True)
class Results:
    """Of one controller on one ground; arrays have a number for each walk.

    Attributes:
        ground: Its name.
        controller: The name that it has here.
        returns: Sum of the rewards of an episode of 20 s.
        steps: Until the fall, at most `STEPS`.
        finished: Whether they were all walked.
        speed: Mean, m/s.
        cost_of_transport: c_mt.
        peak: Greatest ankle and hip torque, N m, shape (walks, 2).
        rms: Root mean square of ankle and hip torque, N m, shape (walks, 2).
    """

    ground: str
    controller: str
    returns: Array
    steps: Array
    finished: NDArray[np.bool_]
    speed: Array
    cost_of_transport: Array
    peak: Array
    rms: Array

    def rows(self) -> Iterator[dict[str, Any]]:
        """One for each walk, for a table."""
        for index in range(len(self.steps)):
            yield {
                "ground": self.ground,
                "controller": self.controller,
                "walk": index,
                "return": self.returns[index],
                "steps": int(self.steps[index]),
                "finished": bool(self.finished[index]),
                "speed": self.speed[index],
                "cost_of_transport": self.cost_of_transport[index],
                "peak_ankle": self.peak[index, 0],
                "peak_hip": self.peak[index, 1],
                "rms_ankle": self.rms[index, 0],
                "rms_hip": self.rms[index, 1],
            }


def try_out(
    ground: Ground,
    name: str,
    controller: Controller,
    weights: Array | None,
    residual: bool,
    *,
    workers: int | None = None,
) -> tuple[Results, Sequence[Walk]]:
    """Let a controller walk on a ground, once for each seed.

    Args:
        ground: Which.
        name: Of the controller.
        controller: As `mjbiped.walk_many` takes it.
        weights: The same as a policy, shape `WEIGHTS`; None for the adaptive controller.
        residual: Whether that policy is a residual.
        workers: Walks at a time.

    Returns:
        What it reached, and the walks.
    """
    task = ground.residual if residual else ground.free
    rollouts = Rollouts(task, ground.walks, threads=workers)
    returns = rollouts.returns((np.zeros(WEIGHTS) if weights is None else weights)[None], ground.seeds)[0]
    rollouts.close()

    terrains, starts = [], []
    for seed in ground.seeds:
        random = np.random.default_rng(seed)
        terrains.append(task.ground(random))
        starts.append(task.start(random))
    walks = mjbiped.walk_many(
        controller, terrains, initial=starts, steps=STEPS, engine=task.engine, workers=workers, progress=True
    )
    return _measured(ground.name, name, returns, walks), walks


def _measured(ground: str, controller: str, returns: Array, walks: Sequence[Walk]) -> Results:
    return Results(
        ground,
        controller,
        returns,
        np.array([walk.steps for walk in walks], dtype=np.float64),
        np.array([walk.outcome == "finished" for walk in walks]),
        np.array([measures.speed(walk) for walk in walks]),
        np.array([walk.cost_of_transport for walk in walks]),
        np.array([walk.peak_torque for walk in walks]),
        np.array([np.sqrt(np.mean(np.square(walk.samples["torque"]), axis=0)) for walk in walks]),
    )


def interval(values: Array | NDArray[np.bool_]) -> Interval:
    """The mean of independent values, and its 95 % interval by the bootstrap (bias-corrected and accelerated).

    Args:
        values: Any number of them; NaN without two, and where all are the same the interval is that number.
    """
    values = np.asarray(values, dtype=np.float64)
    if not len(values):
        return np.nan, np.nan, np.nan
    mean = float(np.mean(values))
    if len(values) < 2:
        return mean, np.nan, np.nan
    if np.ptp(values) == 0.0:
        return mean, mean, mean
    low, high = bootstrap((values,), np.mean, rng=np.random.default_rng(0)).confidence_interval
    return mean, float(low), float(high)


def intervals(of: Results, adaptive: Results) -> Mapping[str, Interval]:
    """All measures of a controller on a ground.

    Costs, speed and torques are of the walks that were walked to their ends: a fall has its own.

    Args:
        of: The controller's.
        adaptive: The adaptive controller's, of the same grounds and starts.
    """
    done, both = of.finished, of.finished & adaptive.finished
    return {
        "return": interval(of.returns),
        "steps": interval(of.steps),
        "finished": interval(of.finished),
        "speed": interval(of.speed[done]),
        "cost": interval(of.cost_of_transport[done]),
        "cost less adaptive": interval(of.cost_of_transport[both] - adaptive.cost_of_transport[both]),
        "peak ankle": interval(of.peak[done, 0]),
        "peak hip": interval(of.peak[done, 1]),
        "rms ankle": interval(of.rms[done, 0]),
        "rms hip": interval(of.rms[done, 1]),
    }
