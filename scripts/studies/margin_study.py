"""What was chosen for the supervised law on the training grounds of `recovery_search`: margin and climbing gait.

The climbing gait for the library, too, which so gets its best settings. Ten minutes on one core; the tables stand
in `docs/tables/feet.md`.

    python -m scripts.studies.margin_study --tables docs/tables/feet
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, ClassVar

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import LibraryController, SupervisedController
from mjbiped.records.measures import FINISHED
from scripts.pages import TABLES, show_table
from scripts.studies.recovery_search import STEPS, training
from scripts.studies.supervised_study import CLEARANCE, NOISY, SOLES, counted, wrong

MARGINS = (1.0, 0.9, 0.8)
CLEARANCES, THRESHOLDS, COUNTS = (0.1, 0.12, 0.14, 0.16), (0.005, 0.025), (3, 5)
SEED = 78  # of wrong models; other than that of the tables


def told(walks: Sequence[Mapping[str, Any]]) -> list[str]:
    """Share of walks that come through, and their mean cost of transport."""
    costs = [walk["cost_of_transport"] for walk in walks if walk["verdict"] == FINISHED]
    return [f"{100 * counted(walks) / len(walks):.0f}", f"{np.mean(costs):.3f}" if costs else "–"]


def cells(law: SupervisedController | LibraryController) -> list[str]:
    """What is told of the training walks."""
    return told(mjbiped.walk_many(law, training(), engine="hybrid", steps=STEPS, summaries=True))


def with_margin(margin: float, robot: mjbiped.Compass, gait: mjbiped.Gait) -> list[str]:
    """What is told of the law with a margin: with its true model, with wrong ones, and with noisy sensors."""

    class Tried(SupervisedController):
        margin: ClassVar[float]

    Tried.margin = margin
    law, grounds, chance = Tried(robot, gait), training(), np.random.default_rng(SEED)
    wrongs = [replace(law, robot=wrong(robot, chance)) for _ in grounds]
    noise = [replace(NOISY, seed=1000 + k) for k in range(len(grounds))]
    of_wrong = mjbiped.walk_many(wrongs, grounds, engine="hybrid", robot=robot, steps=STEPS, summaries=True)
    of_noise = mjbiped.walk_many(law, grounds, engine="hybrid", steps=STEPS, disturbances=noise, summaries=True)
    return [*cells(law), told(of_wrong)[0], told(of_noise)[0]]


@click.command()
@TABLES
def main(tables: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    robots = {sole: mjbiped.Compass(sole=(size, size)) for sole, size in SOLES.items()}
    gaits = {
        sole: mjbiped.find_reference(robot, clearance=CLEARANCE, retraction=False) for sole, robot in robots.items()
    }
    cases = list(product(robots, MARGINS))
    rows = [
        [sole, f"{margin:g}", *with_margin(margin, robots[sole], gaits[sole])]
        for sole, margin in tqdm(cases, desc="margins", mininterval=30.0)
    ]
    heads = ["sole", "margin", "%", "cost", "wrong models, %", "noise, %"]
    show_table("hybrid: margins, training grounds", heads, rows, tables, "margins hybrid")
    rows = []
    for name, kind in {"supervised": SupervisedController, "library": LibraryController}.items():
        alone = [kind(gait.robot, gait, climbing_gait=gait) for gait in gaits.values()]
        rows.append([name, "none", "", "", *(cell for law in alone for cell in cells(law))])
        settings = list(product(CLEARANCES, THRESHOLDS, COUNTS))
        for clearance, threshold, steps in tqdm(settings, desc=name, mininterval=30.0):
            given = {"climbing_clearance": clearance, "height_threshold": threshold, "climbing_steps": steps}
            laws = [kind(gait.robot, gait, **given) for gait in gaits.values()]
            rows.append(
                [
                    name,
                    f"{100 * clearance:g} cm",
                    f"{100 * threshold:g} cm",
                    f"{steps}",
                    *(cell for law in laws for cell in cells(law)),
                ]
            )
    heads = ["law", "clearance", "after", "steps", *(f"{sole}: {what}" for sole in SOLES for what in ("%", "cost"))]
    show_table("hybrid: climbing gaits, training grounds", heads, rows, tables, "climbing hybrid")


if __name__ == "__main__":
    main()
