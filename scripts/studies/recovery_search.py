"""Searches the recovery steps that `SupervisedController` tries: 26 minutes of CMA-ES on one core.

What is minimised is the share of walks that do not come through, less for those that get far, and half of the cost of
transport of those that do; on soles of ±12 and ±8 cm, with the grounds of `training`. None of these grounds, and none
of their seeds, stands in a table of docs/. The result stands in `controllers/bounded/supervisor.py`.

    python -m scripts.studies.recovery_search
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, TypeAlias

import click
import cma
import numpy as np
from numpy.typing import NDArray
from tqdm.auto import tqdm

import mjbiped
from controllers import SupervisedController
from mjbiped import Terrain
from mjbiped.controllers.bounded.recovery import Ankle
from mjbiped.controllers.bounded.supervisor import Range, Recovery
from mjbiped.records.measures import THROUGH

STEPS = 30
SOLES = (0.12, 0.08)
CLEARANCE = 0.077
SPREAD = 0.6  # of the search at its beginning, in units of the scales of `recovery_of`

Numbers: TypeAlias = Sequence[float] | NDArray[np.float64]


def training() -> list[Terrain]:
    """Random treads, stairs of two lengths of tread, slopes of 5° and changes of 4°, at several phases."""
    late = [1.3 + 0.378 * (phase + 0.25) / 5 for phase in range(5)]
    found = [Terrain.treads(seed=5000 + k, deviation=cm / 100, length=60.0) for cm in (1, 2, 3) for k in range(20)]
    for tread in (1.37, 2.1):
        for rise in (0.02, 0.03, 0.04, 0.05, -0.03, -0.05, -0.06):
            found += [Terrain.from_segments([(x, 0.0, 0.0), *[(tread, 0.0, rise)] * 12]) for x in late]
    for degrees in (5.0, -5.0):
        found += [Terrain.from_segments([(x, 0.0, 0.0), (50.0, degrees, 0.0)]) for x in late]
    changes = [(1.7, 4.0 * (1 - 2 * (k % 2)), 0.0) for k in range(14)]
    return found + [Terrain.from_segments([(x, 0.0, 0.0), *changes]) for x in late]


def recovery_of(x: Numbers) -> Recovery:
    """The recovery steps that nine numbers stand for; zero is where the search begins."""
    return Recovery(
        Range(max(0.6, 1.1 + 0.25 * x[0]), 0.31 * math.exp(0.3 * x[1]), 6),
        Range(max(0.08, 0.14 + 0.03 * x[2]), 0.05 * math.exp(0.3 * x[3]), 6),
        Range(-1.4 + 0.4 * x[4], 0.7 * math.exp(0.3 * x[5]), 3),
        Ankle(0.3 * math.exp(0.7 * x[6]), 0.35 + 0.1 * x[7], 0.64 * math.exp(0.7 * x[8])),
    )


def loss(recovery: Recovery, grounds: Sequence[Terrain]) -> float:
    """Mean over the soles of what is minimised."""

    class Tried(SupervisedController):
        recovery: ClassVar[Recovery]

    Tried.recovery = recovery
    losses = []
    for sole in SOLES:
        robot = mjbiped.Compass(sole=(sole, sole))
        gait = mjbiped.find_reference(robot, clearance=CLEARANCE, retraction=False)
        walks = mjbiped.walk_many(Tried(robot, gait), grounds, engine="hybrid", steps=STEPS, summaries=True)
        missed = [0.0 if walk["verdict"] == THROUGH else 1.0 - 0.4 * walk["steps"] / STEPS for walk in walks]
        costs = [walk["cost_of_transport"] for walk in walks if walk["verdict"] == THROUGH]
        losses.append(np.mean(missed) + 0.5 * (np.mean(costs) if costs else 1.0))
    return float(np.mean(losses))


@click.command()
@click.option("--generations", default=26, show_default=True, help="Generations of nine tries each.")
@click.option("--seed", default=5, show_default=True, help="Of the search.")
def main(generations: int, seed: int) -> None:
    """Search, and print the best recovery steps after each generation."""
    grounds = training()
    tqdm.write(f"begins with {loss(recovery_of(np.zeros(9)), grounds):.4f}")
    search = cma.CMAEvolutionStrategy(
        np.zeros(9), SPREAD, {"popsize": 9, "seed": seed, "verbose": -9, "maxiter": generations}
    )
    for _ in tqdm(range(generations), desc="generations", mininterval=30.0):
        tries = search.ask()
        search.tell(tries, [loss(recovery_of(x), grounds) for x in tries])
        tqdm.write(f"{search.result.fbest:.4f} {recovery_of(search.result.xbest)}")
    mean = recovery_of(search.result.xfavorite)
    tqdm.write(f"the mean has {loss(mean, grounds):.4f}: {mean}")


if __name__ == "__main__":
    main()
