"""What looking ahead is worth: the supervised law beside laws that recover wherever a step begins far from the gait.

The rivals make the same recovery steps, found by the same search, but a threshold decides when: the greatest deviation
of an angle (rad) or a rate (rad/s) from the gait's at the beginning of a step. With a threshold of zero every step is a
recovery step, the cheapest of which three in a row are foreseen. The best threshold is chosen on the training grounds
of `recovery_search`. A quarter of an hour on two cores; the table stands in `docs/feet.md`.

    python -m scripts.studies.threshold_study --summary docs/feet.md
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import SupervisedController
from mjbiped import Terrain
from mjbiped.control.controller import Law, Memory
from mjbiped.controllers.bounded import recovery, supervisor
from mjbiped.controllers.bounded.bounded_ankle import slope_law
from mjbiped.controllers.bounded.prediction import State, plan_nominal, step_ahead
from mjbiped.controllers.bounded.recovery import Step
from mjbiped.controllers.bounded.supervisor import Foresight
from scripts.pages import show_table
from scripts.studies.recovery_search import training
from scripts.studies.soles_study import STEPS, grounds, through
from scripts.studies.supervised_study import CLEARANCE, SEEDS, SOLES, counted, share

THRESHOLDS = (0.0, 0.1, 0.2, 0.3, 0.5)


class Parameters(NamedTuple):
    """Parameters of the rivals' laws.

    Attributes:
        supervised: Those of the supervised law.
        threshold: Deviation from the gait over which a step is a recovery step, rad and rad/s; zero where all are.
    """

    supervised: supervisor.Parameters
    threshold: float


@dataclass(frozen=True)
class ThresholdController(SupervisedController):
    """Recovers where a step begins far from the gait.

    Attributes:
        threshold: Deviation from the gait over which a step is a recovery step, rad and rad/s.
    """

    threshold: float = 0.2

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module; see `LawController.plain_law`."""
        return Law(self.rival, torque_law, touchdown_law, slope_law, next_discontinuity_law)

    @cached_property
    def rival(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        return Parameters(self.library, self.threshold)

    def plan_first_step(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Choose the first step."""
        choose(self.foresight, self.threshold, memory, State(q[0], q[1], dq[0], dq[1]))


def torque_law(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float, float]:
    """Torques of the supervised law."""
    return supervisor.torque_law(parameters.supervised, memory, t, q1, q2, dq1, dq2)


def touchdown_law(
    parameters: Parameters, memory: Memory, before1: float, before2: float, q1: float, q2: float, dq1: float, dq2: float
) -> None:
    """What the supervised law feels, and the choice by the threshold."""
    given = supervisor.begin_step(parameters.supervised, memory, before1, before2, q1, q2, dq1, dq2)
    choose(given, parameters.threshold, memory, State(q1, q2, dq1, dq2))


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """Kinks of the supervised law."""
    return supervisor.next_discontinuity_law(parameters.supervised, memory, t)


def choose(foresight: Foresight, threshold: float, memory: Memory, state: State) -> None:
    """Plan the step that begins in a state."""
    if threshold == 0.0:
        recovery.begin(memory, lasting(foresight, memory, state), state.q1, state.q2, state.dq1, state.dq2)
        return
    cycle = foresight.prediction.bounded.tracking.cycle
    off = max(abs(state.q1 - cycle[0]), abs(state.q2 - cycle[1]), abs(state.dq1 - cycle[2]), abs(state.dq2 - cycle[3]))
    if off < threshold or not supervisor.recovers(foresight, memory, state):
        plan_nominal(foresight.prediction, memory, state)


def lasting(foresight: Foresight, memory: Memory, state: State) -> Step:
    """The recovery step that can be made most often in a row, `AHEAD` times at most, and of those the cheapest."""
    least, chosen = math.inf, Step(0.0, 0.0, 0.0)
    for index in range(supervisor.number_of_steps(foresight.recovery)):
        step, after, found = supervisor.step_of(foresight.recovery, index), state, 0.0
        for made in range(supervisor.AHEAD):
            recovery.begin(memory, step, after.q1, after.q2, after.dq1, after.dq2)
            work, after = step_ahead(foresight.prediction, memory, after, 0.0)
            if work == math.inf:
                found += foresight.weight * (supervisor.AHEAD - made)
                break
            found += work
        if found < least:
            least, chosen = found, step
    return chosen


def row(law: SupervisedController, where: Sequence[Terrain]) -> list[str]:
    """Shares on the training grounds and on treads of 2 cm, grounds of the tables with all eight, and level cost."""
    trained = mjbiped.walk_many(law, where, engine="hybrid", steps=STEPS, summaries=True)
    treads = [Terrain.treads(seed=seed, deviation=0.02, length=60.0) for seed in SEEDS]
    random = mjbiped.walk_many(law, treads, engine="hybrid", steps=STEPS, summaries=True)
    found = {name: through(law, made, "hybrid") for name, made in grounds()}
    whole = sum(part == 1.0 for part, _ in found.values())
    cost = found["level"][1]
    return [
        f"{100 * counted(trained) / len(trained):.0f}",
        str(whole),
        share(counted(random), len(random)),
        f"{cost:.3f}" if np.isfinite(cost) else "–",
    ]


@click.command()
@click.option("--summary", type=Path, help="Page that gets the table.")
def main(summary: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    where, rows = training(), []
    for sole, size in SOLES.items():
        robot = mjbiped.Compass(sole=(size, size))
        gait = mjbiped.find_reference(robot, clearance=CLEARANCE, retraction=False)
        rows.append([sole, "simulation", *row(SupervisedController(robot, gait), where)])
        rivals = [ThresholdController(robot, gait, threshold=threshold) for threshold in THRESHOLDS]
        rows += [
            [sole, f"{law.threshold:g}" if law.threshold else "every step", *row(law, where)]
            for law in tqdm(rivals, desc=sole, mininterval=30.0)
        ]
    heads = [
        "sole",
        "recovers by",
        "training, %",
        f"grounds of {len(list(grounds()))}",
        "treads of 2 cm, %",
        "level cost",
    ]
    show_table("hybrid: thresholds", heads, rows, summary, "thresholds hybrid")


if __name__ == "__main__":
    main()
