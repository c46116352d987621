"""Limits of walking on a sole: the highest single riser, the grounds from other phases, and what knees walk.

Two minutes on two cores. The tables stand in
`docs/feet.md`.

    python -m scripts.studies.sole_limits_study --summary docs/feet.md
"""

from __future__ import annotations

from pathlib import Path

import click

import mjbiped
from controllers import KneedController, SupervisedController
from mjbiped import Terrain
from scripts.pages import show_table
from scripts.studies.soles_study import BEFORE, PHASES, STEP, STEPS, grounds, through, told
from scripts.studies.supervised_study import CLEARANCE, CLIMBING, counted

RISERS = range(3, 9)  # cm
WITH_KNEES = ("level", "3° up", "3° down", "stairs +2 cm", "stairs −2 cm")
OFF = 1e-6  # an adaptation gain that does nothing within a walk


def law(sole: float, clearance: float) -> SupervisedController:
    """The supervised law on a sole that reaches as far behind the ankle as ahead of it, m."""
    robot = mjbiped.Compass(sole=(sole, sole))
    return SupervisedController(robot, mjbiped.find_reference(robot, clearance=clearance, retraction=False))


def over_a_riser(walker: SupervisedController, rise: float) -> str:
    """How many of eight walks over one riser do not fall, and how many of them come through."""
    late = [BEFORE + STEP * (phase + 0.5) / PHASES for phase in range(PHASES)]
    terrains = [Terrain.from_segments([(x, 0.0, 0.0), (60.0, 0.0, rise)]) for x in late]
    walks = mjbiped.walk_many(walker, terrains, engine="hybrid", steps=STEPS, summaries=True)
    return f"{sum(walk['outcome'] == 'finished' for walk in walks)} ({counted(walks)})"


def between_phases(walker: SupervisedController) -> str:
    """Grounds that are not random on which not all come through from phases half-way between those of the tables."""
    missed = []
    for name, made in grounds(BEFORE + 0.5 * STEP / PHASES):
        cell = told(*through(walker, made, "hybrid")) if not name.startswith("treads") else ""
        if "of" in cell or cell == "–":
            missed.append(f"{name}: {cell}")
    return ", ".join(missed) or "none"


@click.command()
@click.option("--summary", type=Path, help="Page that gets the tables.")
def main(summary: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    laws = {
        (sole, clearance): law(sole, clearance) for sole in (0.05, 0.08, 0.12) for clearance in (CLEARANCE, CLIMBING)
    }
    told_by = {key: [f"±{100 * key[0]:g} cm", f"{100 * key[1]:g} cm"] for key in laws}
    heads = ["sole", "clearance", *(f"{rise} cm" for rise in RISERS)]
    rows = [[*told_by[key], *(over_a_riser(each, rise / 100) for rise in RISERS)] for key, each in laws.items()]
    show_table("hybrid: single risers", heads, rows, summary, "risers hybrid")
    rows = [[*told_by[key], between_phases(each)] for key, each in laws.items() if key[0] != 0.05]
    show_table("hybrid: other phases", ["sole", "clearance", "not walked whole"], rows, summary, "phases hybrid")
    robot, made = mjbiped.KneedBiped(sole=(0.12, 0.12)), dict(grounds())
    gait = mjbiped.find_reference(robot, clearance=0.08)
    kneed = {"off": KneedController(robot, gait, adaptation_gain=OFF), "on": KneedController(robot, gait)}
    rows = [
        [engine, state, *(told(*through(each, made[name], engine)) for name in WITH_KNEES)]
        for engine in ("hybrid", "mujoco")
        for state, each in kneed.items()
    ]
    show_table("knees, ±12 cm", ["engine", "adaptive law", *WITH_KNEES], rows, summary, "knees on soles")


if __name__ == "__main__":
    main()
