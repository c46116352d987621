"""Feet that are bodies, in MuJoCo, beside an ideal sole of the same length in the hybrid engine.

Forty steps on thirteen kinds of ground from three phases, with the law that supervises itself: on pads under heel and
toe, and on a box. Two more phases no choice in the law or the engine has seen. Told of each: how many walks make all
steps, how many of these come through without a pull of the ground or friction of 0.8, how far a standing foot tipped
and slid, how long heel and toe of a landing foot were apart, how long it stood on one of them alone, and how well rates
after a touchdown are those of the impact map. Half an hour on two cores. The results stand in
docs/tables/footed.md.

    python -m scripts.studies.footed_study --tables docs/tables/footed
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import SupervisedController
from mjbiped.records import measures
from mjbiped.records.measures import FINISHED
from scripts.pages import TABLES, show_table
from scripts.studies.soles_study import STEPS, grounds
from scripts.studies.supervised_study import CLEARANCE, SOLES

PHASES = (0, 3, 6)
ALL, UNTRIED = "all", "all, unseen phases"
UNSEEN = (2, 5)
"""Phases that were walked for the first time when all was built."""
STAIRS = tuple(f"stairs {rise} cm" for rise in ("+2", "+4", "−2", "−4", "−6"))
KINDS = ("level", "3° up", "5° up", "3° down", "5° down", *STAIRS, "mixed", "treads, 1 cm", "treads, 2 cm")

HEADINGS = (
    "sole",
    "foot",
    "ground",
    "all steps",
    "through",
    "c_mt",
    "tipped, °",
    "slid, mm",
    "slap, ms",
    "one-sided, ms",
    "impact map, %",
)


def robots(half: float) -> Iterator[tuple[str, str, mjbiped.Compass]]:
    """An ideal sole of a half length (m), and feet of that length: name, engine and robot."""
    yield "ideal sole, hybrid engine", "hybrid", mjbiped.Compass(sole=(half, half))
    yield "pads, MuJoCo", "mujoco", mjbiped.FootedCompass(sole=(half, half))
    yield "box, MuJoCo", "mujoco", mjbiped.FootedCompass(sole=(half, half), underside="box")


def impact_errors(walk: mjbiped.Walk) -> list[float]:
    """How far rates after each touchdown are from the impact map, in the greatest of them."""
    table = walk.touchdowns
    errors = []
    for q, before, after in zip(table["q_before"], table["dq_before"], table["dq"], strict=True):
        wanted = walk.robot.rates_after_touchdown(q, before)
        errors.append(float(np.abs(after - wanted).max() / np.abs(wanted).max()))
    return errors


def told(walks: Sequence[mjbiped.Walk]) -> list[str]:
    """The cells of one ground: of the walks that made all steps the worst, but of cost and impact the median."""
    whole = [walk for walk in walks if walk.outcome == "finished"]
    through = sum(measures.summary(walk)["verdict"] == FINISHED for walk in walks)
    shares = [f"{count} of {len(walks)}" for count in (len(whole), through)]
    if not whole:
        return [*shares, *["–"] * 6]
    cost = np.median([walk.cost_of_transport for walk in whole])
    impact = 100 * np.median([error for walk in whole for error in impact_errors(walk)])
    slid = max(1e3 * walk.touchdowns["slip"].max() for walk in whole)
    if "slap" not in whole[0].touchdowns:
        return [*shares, f"{cost:.3f}", "–", f"{slid:.2f}", "–", "–", f"{impact:.2g}"]
    tipped, slap, one_sided = (
        max(scale * np.nanmax(walk.touchdowns[name]) for walk in whole)
        for name, scale in {"tipped": np.rad2deg(1.0), "slap": 1e3, "one_sided": 1e3}.items()
    )
    return [*shares, f"{cost:.3f}", f"{tipped:.2f}", f"{slid:.2f}", f"{slap:.1f}", f"{one_sided:.0f}", f"{impact:.2g}"]


def rows_of(engine: str, law: SupervisedController, bar: Any) -> list[list[str]]:
    """A row for each ground, one of how many walks came through in all, and one of those from the unseen phases."""
    phases, known = (*PHASES, *UNSEEN), len(PHASES)
    made: Mapping[str, list[mjbiped.Terrain]] = {
        name: [ground(phase) for phase in phases] for name, ground in grounds() if name in KINDS
    }
    walks = mjbiped.walk_many(
        law, [terrain for terrains in made.values() for terrain in terrains], engine=engine, steps=STEPS
    )
    bar.update()
    parts = [walks[k : k + len(phases)] for k in range(0, len(walks), len(phases))]
    rows = [[name, *told(part[:known])] for name, part in zip(made, parts, strict=True)]
    for name, some in ((ALL, slice(known)), (UNTRIED, slice(known, None))):
        rows.append([name, *told([walk for part in parts for walk in part[some]])[:2], *[""] * 6])
    return rows


@click.command()
@TABLES
def main(tables: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    cases = [(sole, half, *case) for sole, half in SOLES.items() for case in robots(half)]
    rows: list[list[str]] = []
    with tqdm(total=len(cases), mininterval=30.0 if not sys.stderr.isatty() else 0.1) as bar:
        for sole, half, name, engine, robot in cases:
            gait = mjbiped.find_reference(mjbiped.Compass(sole=(half, half)), clearance=CLEARANCE, retraction=False)
            rows += [[sole, name, *row] for row in rows_of(engine, SupervisedController(robot, gait), bar)]
    show_table("feet with mass", HEADINGS, rows, tables, "feet with mass")
    write_sums(rows, tables)


def write_sums(rows: Sequence[Sequence[str]], tables: Path | None) -> None:
    """Show the sums over all grounds, and write them."""
    found = {(sole, foot, ground): counts[:2] for sole, foot, ground, *counts in rows if ground in (ALL, UNTRIED)}
    sums = [
        [sole, foot, *counts, *found[sole, foot, UNTRIED]]
        for (sole, foot, ground), counts in found.items()
        if ground == ALL
    ]
    show_table(
        "feet with mass, all grounds",
        ("sole", "foot", "make all steps", "through", "unseen: all steps", "unseen: through"),
        sums,
        tables,
        "survives",
    )


if __name__ == "__main__":
    main()
