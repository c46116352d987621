"""Searches the recovery steps that `SupervisedController` tries: 26 minutes of CMA-ES on one core.

Before, it tells the loss of the steps that the search begins with, and of those that the law has, on the grounds of the
search and on others, for `docs/tables/feet.md`; with `--generations 0` nothing else.

What is minimised is the share of walks that do not come through, less for those that get far, and half of the cost of
transport of those that do; on soles of ±12 and ±8 cm, with the grounds of `training`. None of these grounds, and none
of their seeds, stands in a table of docs/. The result stands in `controllers/bounded/supervisor.py`.

    python -m scripts.studies.recovery_search --tables docs/tables/feet
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
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
from mjbiped.records.measures import FINISHED
from scripts.pages import TABLES, show_table

STEPS = 30
SOLES = (0.12, 0.08)
CLEARANCE = 0.077
SPREAD = 0.6  # of the search at its beginning, in units of the scales of `recovery_of`

Numbers: TypeAlias = Sequence[float] | NDArray[np.float64]


def training() -> list[Terrain]:
    """The grounds of the search."""
    return _grounds(5000, 0.25, (1.37, 2.1))


def others() -> list[Terrain]:
    """Grounds of the same kinds that the search did not see."""
    return _grounds(6000, 0.75, (1.5, 1.95))


def _grounds(seed: int, later: float, treads: Sequence[float]) -> list[Terrain]:
    """Random treads, stairs, slopes of 5° and changes of 4°, at several phases.

    Args:
        seed: First seed of the random treads.
        later: By which share of the distance between two phases they are later.
        treads: Lengths of the stairs' treads, m.
    """
    late = [1.3 + 0.378 * (phase + later) / 5 for phase in range(5)]
    found = [Terrain.treads(seed=seed + k, deviation=cm / 100, length=60.0) for cm in (1, 2, 3) for k in range(20)]
    for tread in treads:
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
        missed = [0.0 if walk["verdict"] == FINISHED else 1.0 - 0.4 * walk["steps"] / STEPS for walk in walks]
        costs = [walk["cost_of_transport"] for walk in walks if walk["verdict"] == FINISHED]
        losses.append(np.mean(missed) + 0.5 * (np.mean(costs) if costs else 1.0))
    return float(np.mean(losses))


def losses() -> list[list[str]]:
    """Rows of a table: recovery steps, and their loss on the grounds of the search and on others."""
    steps = {"the search begins with": recovery_of(np.zeros(9)), "of the law": SupervisedController.recovery}
    return [
        [name, *(f"{loss(recovery, made):.3f}" for made in (training(), others()))] for name, recovery in steps.items()
    ]


def search(generations: int, seed: int) -> None:
    """Search, and print the best recovery steps after each generation."""
    grounds = training()
    strategy = cma.CMAEvolutionStrategy(
        np.zeros(9), SPREAD, {"popsize": 9, "seed": seed, "verbose": -9, "maxiter": generations}
    )
    for _ in tqdm(range(generations), desc="generations", mininterval=30.0):
        tries = strategy.ask()
        strategy.tell(tries, [loss(recovery_of(x), grounds) for x in tries])
        tqdm.write(f"{strategy.result.fbest:.4f} {recovery_of(strategy.result.xbest)}")
    mean = recovery_of(strategy.result.xfavorite)
    tqdm.write(f"the mean has {loss(mean, grounds):.4f}: {mean}")


@click.command()
@click.option("--generations", default=26, show_default=True, type=click.IntRange(0), help="Each of nine tries.")
@click.option("--seed", default=5, show_default=True, help="Of the search.")
@TABLES
def main(generations: int, seed: int, tables: Path | None) -> None:
    """Tell the losses, then search."""
    heads = ["recovery steps", "training grounds", "other grounds"]
    show_table("loss, with the law as it is", heads, losses(), tables, "searched hybrid")
    if generations:
        search(generations, seed)


if __name__ == "__main__":
    main()
