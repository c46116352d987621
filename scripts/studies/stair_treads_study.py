"""How long the treads of stairs have to be, for the paper's law and for the laws for a bounded ankle.

Forty steps in the hybrid engine. Treads of one length: twelve risers from the eight phases of `soles_study`. Treads of
random length: as many risers as the walk can meet, with sixteen seeds. A walk counts where it comes through and the
ground neither has to pull nor needs friction over 0.8. Five minutes on one core. The tables stand in
`docs/tables/feet.md`.

    python -m scripts.studies.stair_treads_study --tables docs/tables/feet
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController
from mjbiped import Terrain
from mjbiped.records.measures import FINISHED
from scripts.pages import TABLES, show_table
from scripts.studies.soles_study import BEFORE, PHASES, STEP, STEPS, Ground, through
from scripts.studies.supervised_study import CLEARANCE, SOLES, laws

TREADS = (0.45, 0.6, 0.8, 1.0, 1.2, 1.5, 1.8, 2.4)
"""Depths of the treads, m; the stairs of all other tables have 1.8 m."""

RISES = (2, 4, 6, -2, -4, -6)
"""Heights of the risers, cm, up positive."""

BETWEEN = ((0.45, 0.8), (0.8, 1.2), (1.2, 1.8), (1.8, 2.4))
"""Least and greatest depth of random treads, m."""

RISERS, ALL_RISERS, SEEDS = 12, 45, 16
RANDOM_RISES = (4, 6, -4, -6)
NAMES = ("paper", "bounded ankle", "supervised")


def walkers() -> Iterator[tuple[str, str, Any]]:
    """What walks: sole, law and controller, all with the reference of 7.7 cm without retraction."""
    robot = mjbiped.Compass()
    gait = mjbiped.find_reference(robot, clearance=CLEARANCE, retraction=False)
    yield "none", "paper", AdaptiveController(robot, gait, replanning="additive")
    for sole, half in SOLES.items():
        yield from ((sole, name, law) for name, law in laws(half) if name in NAMES)


def stairs(tread: float, rise: int) -> Ground:
    """Stairs of treads (m) and risers (cm), as a function of the phase in which the first riser comes."""
    rows = [(tread, 0.0, rise / 100)] * RISERS
    return lambda phase: Terrain.from_segments([(BEFORE + STEP * (phase + 0.5) / PHASES, 0.0, 0.0), *rows])


def cell(law: Any, tread: float, rise: int) -> str:
    """How many of the walks come through."""
    share, _ = through(law, stairs(tread, rise), "hybrid")
    return f"{round(PHASES * share)} of {PHASES}"


def random_stairs(least: float, greatest: float, rise: int, seed: int) -> Terrain:
    """Stairs of risers (cm) with treads drawn uniformly between bounds (m); the first riser's phase is drawn too."""
    chance = np.random.default_rng(seed)
    first = BEFORE + STEP * chance.uniform()
    treads = [(chance.uniform(least, greatest), 0.0, rise / 100) for _ in range(ALL_RISERS)]
    return Terrain.from_segments([(first, 0.0, 0.0), *treads])


def on_random_treads(law: Any, rise: int) -> Iterator[str]:
    """How many of the walks come through, and how many make all steps, for each range of the treads' depth."""
    for least, greatest in BETWEEN:
        terrains = [random_stairs(least, greatest, rise, seed) for seed in range(SEEDS)]
        walks = mjbiped.walk_many(law, terrains, engine="hybrid", steps=STEPS, summaries=True)
        good = sum(walk["verdict"] == FINISHED for walk in walks)
        made = sum(walk["outcome"] == "finished" for walk in walks)
        yield f"{good} of {SEEDS} ({made})"


def told(rise: int) -> str:
    """Write a riser's height."""
    return f"{rise:+d} cm".replace("-", "−")


@click.command(help=__doc__)
@TABLES
def main(tables: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    rows: list[list[str]] = []
    for sole, name, law in tqdm([*walkers()], mininterval=30.0 if not sys.stderr.isatty() else 0.1):
        rows += [[sole, name, told(rise), *(cell(law, tread, rise) for tread in TREADS)] for rise in RISES]
    headings = ["sole", "law", "riser", *(f"tread {tread:g} m" for tread in TREADS)]
    show_table("hybrid: through, by tread", headings, rows, tables, "stairs by tread hybrid")
    random_treads(tables)


def random_treads(tables: Path | None) -> None:
    """Walk the supervised law on random treads, print, and write the table."""
    supervised = [(sole, law) for sole, name, law in walkers() if name == "supervised"]
    rows = [[sole, told(rise), *on_random_treads(law, rise)] for sole, law in supervised for rise in RANDOM_RISES]
    headings = ["sole", "riser", *(f"treads of {least:g} to {greatest:g} m" for least, greatest in BETWEEN)]
    show_table("hybrid: through, by range of random treads", headings, rows, tables, "stairs by random treads hybrid")


if __name__ == "__main__":
    main()
