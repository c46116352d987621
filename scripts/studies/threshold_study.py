"""What looking ahead is worth: the supervised law beside laws that recover wherever a step begins far from the gait.

The rivals make the same recovery steps, found by the same search, but a threshold decides when: the greatest deviation
of an angle (rad) or a rate (rad/s) from the gait's at the beginning of a step. With a threshold of zero every step is a
recovery step, the cheapest of which three in a row are foreseen. The best threshold is chosen on the training grounds
of `recovery_search`. A quarter of an hour on two cores; the table stands in `docs/tables/feet.md`.

    python -m scripts.studies.threshold_study --tables docs/tables/feet
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import SupervisedController
from mjbiped import Terrain
from mjbiped.control.controller import Law, Memory
from mjbiped.controllers.bounded import recovery, supervisor
from mjbiped.controllers.bounded.bounded_ankle import feel_step, next_discontinuity, torque
from mjbiped.controllers.bounded.identifier import slope_estimate
from mjbiped.controllers.bounded.prediction import FAILURE, State, plan_nominal, step_ahead
from mjbiped.controllers.bounded.recovery import Step
from mjbiped.controllers.layout import CYCLE, SUPERVISION, gait_of
from scripts.pages import TABLES, show_rows
from scripts.studies.recovery_search import training
from scripts.studies.soles_study import STEPS, grounds, through
from scripts.studies.supervised_study import CLEARANCE, SEEDS, SOLES, counted, share

THRESHOLDS = (0.0, 0.1, 0.2, 0.3, 0.5)


@dataclass(frozen=True)
class ThresholdController(SupervisedController):
    """Recovers where a step begins far from the gait.

    Attributes:
        threshold: Deviation from the gait over which a step is a recovery step, rad and rad/s.
    """

    threshold: float = 0.2

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module, with the threshold behind all other parameters; see `LawController.plain_law`."""
        parameters = [*self.parameters, self.threshold]
        return Law(parameters, torque, touchdown, slope_estimate, next_discontinuity)

    def plan_first_step(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Choose the first step."""
        choose(self.plain_law.parameters, memory, State(q[0], q[1], dq[0], dq[1]))


def touchdown(
    parameters: Sequence[float], memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]
) -> None:
    """What the supervised law feels, and the choice by the threshold."""
    feel_step(parameters, memory, q_before, q, dq)
    choose(parameters, memory, State(q[0], q[1], dq[0], dq[1]))


def choose(parameters: Sequence[float], memory: Memory, state: State) -> None:
    """Plan the step that begins in a state; where the threshold is zero, all are recovery steps."""
    threshold, cycle = parameters[len(parameters) - 1], gait_of(parameters, memory) + CYCLE
    if threshold == 0.0:
        recovery.begin(memory, lasting(parameters, memory, state), (state.q1, state.q2), (state.dq1, state.dq2))
        return
    off = 0.0
    for index in range(4):
        off = max(off, abs(state[index] - parameters[cycle + index]))
    if off < threshold or not supervisor.recovers(parameters, memory, state):
        plan_nominal(parameters, memory, state)


def lasting(parameters: Sequence[float], memory: Memory, state: State) -> Step:
    """The recovery step that can be made most often in a row, `AHEAD` times at most, and of those the cheapest."""
    least, chosen = math.inf, Step(0.0, 0.0, 0.0)
    failure = parameters[int(parameters[SUPERVISION]) + FAILURE]
    for index in range(supervisor.number_of_steps(parameters)):
        step, after, found = supervisor.step_of(parameters, index), state, 0.0
        for made in range(supervisor.AHEAD):
            recovery.begin(memory, step, (after.q1, after.q2), (after.dq1, after.dq2))
            work, after = step_ahead(parameters, memory, after, 0.0)
            if work == math.inf:
                found += failure * (supervisor.AHEAD - made)
                break
            found += work
        if found < least:
            least, chosen = found, step
    return chosen


def row(law: SupervisedController, where: Sequence[Terrain]) -> dict[str, str]:
    """Shares on the training grounds and on treads of 2 cm, grounds of the tables with all eight, and level cost."""
    trained = mjbiped.walk_many(law, where, engine="hybrid", steps=STEPS, summaries=True)
    treads = [Terrain.treads(seed=seed, deviation=0.02, length=60.0) for seed in SEEDS]
    random = mjbiped.walk_many(law, treads, engine="hybrid", steps=STEPS, summaries=True)
    found = {name: through(law, made, "hybrid") for name, made in grounds()}
    whole = sum(part == 1.0 for part, _ in found.values())
    cost = found["level"][1]
    return {
        "training, %": f"{100 * counted(trained) / len(trained):.0f}",
        f"grounds of {len(found)}": str(whole),
        "treads of 2 cm, %": share(counted(random), len(random)),
        "level cost": f"{cost:.3f}" if np.isfinite(cost) else "–",
    }


@click.command()
@TABLES
def main(tables: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    where, rows = training(), []
    for sole, size in SOLES.items():
        robot = mjbiped.Compass(sole=(size, size))
        gait = mjbiped.find_reference(robot, clearance=CLEARANCE, retraction=False)
        supervised = SupervisedController(robot, gait)
        rows.append({"sole": sole, "recovers by": "simulation", **row(supervised, where)})
        rivals = [ThresholdController(robot, gait, threshold=threshold) for threshold in THRESHOLDS]
        rows += [
            {"sole": sole, "recovers by": f"{law.threshold:g}" if law.threshold else "every step", **row(law, where)}
            for law in tqdm(rivals, desc=sole, mininterval=30.0)
        ]
    show_rows("hybrid: thresholds", rows, tables, "thresholds hybrid")


if __name__ == "__main__":
    main()
