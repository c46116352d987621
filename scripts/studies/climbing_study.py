"""Which climbing gait, and after which change of height: by the training grounds of `recovery_search`.

For the supervised law and for the library, which so gets its best settings, too. Six minutes on two cores; the table
stands in `docs/tables/feet.md`, and its best rows in `GaitLibrary` and in `supervised_study`.

    python -m scripts.studies.climbing_study --page docs/tables/feet.md
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import LibraryController, SupervisedController
from mjbiped.records.measures import THROUGH
from scripts.pages import show_table
from scripts.studies.recovery_search import STEPS, training
from scripts.studies.supervised_study import CLEARANCE, SOLES, counted

CLEARANCES, THRESHOLDS, COUNTS = (0.1, 0.12, 0.14, 0.16), (0.005, 0.025, 0.035), (3, 5)


def cells(law: SupervisedController | LibraryController) -> list[str]:
    """Share of the training walks that come through, and their mean cost of transport."""
    walks = mjbiped.walk_many(law, training(), engine="hybrid", steps=STEPS, summaries=True)
    costs = [walk["cost_of_transport"] for walk in walks if walk["verdict"] == THROUGH]
    return [f"{100 * counted(walks) / len(walks):.0f}", f"{np.mean(costs):.3f}" if costs else "–"]


@click.command()
@click.option("--page", type=Path, help="Page that gets the table.")
def main(page: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    robots = [mjbiped.Compass(sole=(size, size)) for size in SOLES.values()]
    gaits = [mjbiped.find_reference(robot, clearance=CLEARANCE, retraction=False) for robot in robots]
    rows = []
    for name, kind in {"supervised": SupervisedController, "library": LibraryController}.items():
        alone = [kind(gait.robot, gait, climbing_gait=gait) for gait in gaits]
        rows.append([name, "none", "", "", *(cell for law in alone for cell in cells(law))])
        settings = list(product(CLEARANCES, THRESHOLDS, COUNTS))
        for clearance, threshold, steps in tqdm(settings, desc=name, mininterval=30.0):
            given = {"climbing_clearance": clearance, "height_threshold": threshold, "climbing_steps": steps}
            laws = [kind(gait.robot, gait, **given) for gait in gaits]
            told = [f"{100 * clearance:g} cm", f"{100 * threshold:g} cm", f"{steps}"]
            rows.append([name, *told, *(cell for law in laws for cell in cells(law))])
    heads = ["law", "clearance", "after", "steps", *(f"{sole}: {what}" for sole in SOLES for what in ("%", "cost"))]
    show_table("hybrid: climbing gaits, training grounds", heads, rows, page, "climbing hybrid")


if __name__ == "__main__":
    main()
