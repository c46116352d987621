"""CMA-ES on a policy's weights, generation by generation; each can be gone on from, bitwise as if never left.

A generation walks the whole population, and the mean of its distribution, on the same grounds; the next has others.
"""

from __future__ import annotations

import time
from collections.abc import Generator
from math import prod

import numpy as np

from mjbiped.envs.tasks import WalkTask
from mjbiped.errors import InputError
from mjbiped.utils.packages import needed
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.rollouts import WEIGHTS, Array, Rollouts

POPULATION = 24
"""Policies of a generation: some twice what CMA-ES takes by itself for 32 weights, for returns vary with the ground."""
GROUNDS = 4
"""Episodes of each policy in a generation."""
SPREAD = {True: 0.05, False: 0.2}
"""Standard deviation of the first weights about zero, for residual and free policies. A residual begins as the adaptive
controller; with the greater spread it would unlearn to walk first."""


class _Optimiser:
    """CMA-ES with random numbers of its own; the same returns lead to the same policies."""

    def __init__(self, residual: bool, seed: int) -> None:
        cma = needed("cma", "rl", "learning")
        random = np.random.default_rng(seed)
        options = {
            "popsize": POPULATION,
            "randn": lambda *shape: random.standard_normal(shape),
            "seed": np.nan,  # leaves NumPy's global generator alone
            "verbose": -9,
        }
        self._strategy = cma.CMAEvolutionStrategy(np.zeros(prod(WEIGHTS)), SPREAD[residual], options)

    @property
    def mean(self) -> Array:
        """Of the distribution."""
        return np.array(self._strategy.mean).reshape(WEIGHTS)

    def ask(self) -> Array:
        """The population, shape (`POPULATION`, *`WEIGHTS`)."""
        self._asked = self._strategy.ask()
        return np.array(self._asked).reshape(POPULATION, *WEIGHTS)

    def tell(self, returns: Array) -> None:
        """What each of them has returned, shape (`POPULATION`, grounds)."""
        self._strategy.tell(self._asked, (-returns.mean(axis=1)).tolist())


def seeds_of(seed: int, generation: int) -> list[tuple[int, int, int]]:
    """Of the grounds and starts of a generation."""
    return [(seed, generation, ground) for ground in range(GROUNDS)]


def train(
    residual: bool, seed: int, before: Checkpoint | None = None, *, threads: int | None = None
) -> Generator[Checkpoint, None, None]:
    """Train on random ground, without end.

    Args:
        residual: Whether the policy's torques are added to the adaptive controller's.
        seed: Of everything random.
        before: A training of the same kind and seed that is to be gone on with.
        threads: In which robots walk; no result depends on it.

    Yields:
        What has been reached after each generation.

    Raises:
        InputError: The earlier training was another one.
    """
    optimiser = _Optimiser(residual, seed)
    reached = before or _nothing(residual, seed)
    _repeat(optimiser, reached)
    rollouts = Rollouts(WalkTask("walk_random", residual=residual), (POPULATION + 1) * GROUNDS, threads=threads)
    steps, wall, processor = ((of[-1] if len(of) else 0.0) for of in (reached.steps, reached.wall, reached.processor))
    wall_began, processor_began = time.perf_counter(), time.process_time()
    try:
        while True:
            policies = np.concatenate([optimiser.mean[None], optimiser.ask()])
            returns = rollouts.returns(policies, seeds_of(seed, reached.generations))
            optimiser.tell(returns[1:])
            reached = Checkpoint(
                residual,
                seed,
                optimiser.mean,
                np.concatenate([reached.returns, returns[None, 1:]]),
                np.concatenate([reached.mean_returns, returns[:1]]),
                np.append(reached.steps, steps + rollouts.steps),
                np.append(reached.wall, wall + time.perf_counter() - wall_began),
                np.append(reached.processor, processor + time.process_time() - processor_began),
            )
            yield reached
    finally:
        rollouts.close()


def _nothing(residual: bool, seed: int) -> Checkpoint:
    """Before the first generation."""
    none = np.zeros(0)
    returns, mean_returns = np.zeros((0, POPULATION, GROUNDS)), np.zeros((0, GROUNDS))
    return Checkpoint(residual, seed, np.zeros(WEIGHTS), returns, mean_returns, none, none, none)


def _repeat(optimiser: _Optimiser, reached: Checkpoint) -> None:
    """Bring the optimiser to where an earlier training had it, by the returns that it was told.

    Raises:
        InputError: It comes to another policy.
    """
    for returns in reached.returns:
        optimiser.ask()
        if returns.shape != (POPULATION, GROUNDS):
            break
        optimiser.tell(returns)
    if not np.array_equal(optimiser.mean, reached.weights):
        raise InputError(
            "the earlier training cannot be gone on with: its returns lead to another policy here, so it was made with "
            "other settings or another version of cma; remove its file to begin anew"
        )
