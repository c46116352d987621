"""The laws for a bounded ankle beside the paper's, on soles of ±12 and ±8 cm.

Four tables: the grounds of `soles_study` from eight phases; random treads with 200 seeds; the same grounds by laws
whose model of the robot is wrong; and with noisy sensors that are read late. Ten minutes on two cores for the hybrid
engine, an hour for MuJoCo. The results stand in `docs/tables/feet.md`.

    python -m scripts.studies.supervised_study --tables docs/tables/feet
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import click
import numpy as np
from scipy.stats import binomtest
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, BoundedAnkleController, LibraryController, SupervisedController
from mjbiped import Terrain
from mjbiped.records.measures import FINISHED
from scripts.pages import TABLES, show_table
from scripts.studies.soles_study import PHASES, STEPS, grounds, through, told

SOLES: Mapping[str, float] = {"±12 cm": 0.12, "±8 cm": 0.08}
CLEARANCE = 0.077  # m: as much as costs no more than the paper's walk on level ground
SEEDS = range(20_000, 20_200)  # of random treads; no table or search has used them
MODELS = 8  # wrong models for each kind of ground and phase

MASS, INERTIA, CENTRE = 0.1, 0.2, 0.02
"""By how much a model is wrong at most: shares of mass and inertia, and the place of the centre of mass, m."""

NOISY = mjbiped.Disturbances(angle_noise=0.002, rate_noise=0.02, delay=0.002)

BEYOND = ("stairs +4 cm", "stairs +6 cm", "treads, 2 cm", "treads, 3 cm")
"""Grounds that no law need walk with a wrong model: beyond what is asked of one on ±8 cm."""

ONE_GAIT = "supervised, one gait"
"""What the climbing gait brings is told by the hybrid engine only."""

Law: TypeAlias = AdaptiveController | BoundedAnkleController


def laws(sole: float) -> Iterator[tuple[str, Law]]:
    """The laws by name, on a sole that reaches as far behind the ankle as ahead of it, m."""
    robot = mjbiped.Compass(sole=(sole, sole))
    gait = mjbiped.find_reference(robot, clearance=CLEARANCE, retraction=False)
    yield "paper", AdaptiveController(robot, gait, replanning="additive")
    yield "library", LibraryController(robot, gait, replanning="additive")
    yield "bounded ankle", BoundedAnkleController(robot, gait)
    yield "supervised", SupervisedController(robot, gait)
    yield ONE_GAIT, SupervisedController(robot, gait, climbing_gait=gait)


def wrong(robot: mjbiped.Compass, chance: np.random.Generator) -> mjbiped.Compass:
    """A model of the robot that is wrong, evenly distributed within `MASS`, `INERTIA` and `CENTRE`."""
    mass, inertia = 1.0 + MASS * chance.uniform(-1.0, 1.0), 1.0 + INERTIA * chance.uniform(-1.0, 1.0)
    lower = robot.lower_length + CENTRE * chance.uniform(-1.0, 1.0)
    return replace(
        robot,
        leg_mass=robot.leg_mass * mass,
        leg_inertia=robot.leg_inertia * mass * inertia,
        lower_length=lower,
        upper_length=robot.leg_length - lower,
    )


def share(good: int, count: int) -> str:
    """A share in percent, with Wilson's interval of 95 %."""
    low, high = binomtest(good, count).proportion_ci(method="wilson")
    return f"{100 * good / count:.1f} ({100 * low:.1f} to {100 * high:.1f})"


def counted(walks: Sequence[Mapping[str, object]]) -> int:
    """How many walks come through."""
    return sum(walk["verdict"] == FINISHED for walk in walks)


def on_treads(law: Law, engine: str) -> list[str]:
    """Share of the walks over random treads of 1, 2 and 3 cm that come through."""
    cells = []
    for centimetres in (1, 2, 3):
        terrains = [Terrain.treads(seed=seed, deviation=centimetres / 100, length=60.0) for seed in SEEDS]
        walks = mjbiped.walk_many(law, terrains, engine=engine, steps=STEPS, summaries=True)
        cells.append(share(counted(walks), len(walks)))
    return cells


def disturbed(law: Law, engine: str) -> list[str]:
    """Shares of the walks with wrong models, and with noisy sensors, that come through."""
    return [with_wrong_models(law, engine), with_noise(law, engine)]


def with_wrong_models(law: Law, engine: str) -> str:
    """Share of the walks that come through over all grounds but `BEYOND`, with a new wrong model for each."""
    chance = np.random.default_rng(4)
    terrains = [made(k % PHASES) for name, made in grounds() if name not in BEYOND for k in range(MODELS)]
    wrongs = [replace(law, robot=wrong(law.robot, chance)) for _ in terrains]
    walks = mjbiped.walk_many(wrongs, terrains, engine=engine, robot=law.robot, steps=STEPS, summaries=True)
    return share(counted(walks), len(walks))


def with_noise(law: Law, engine: str) -> str:
    """Share of the walks that come through over all grounds but `BEYOND`, with `NOISY` sensors."""
    terrains = [made(phase) for name, made in grounds() if name not in BEYOND for phase in range(PHASES)]
    noise = [replace(NOISY, seed=seed) for seed in range(len(terrains))]
    walks = mjbiped.walk_many(law, terrains, engine=engine, steps=STEPS, disturbances=noise, summaries=True)
    return share(counted(walks), len(walks))


def on_grounds(law: Law, engine: str) -> list[str]:
    """Cost of transport on each ground, or how many of eight come through."""
    return [told(*through(law, made, engine)) for _, made in grounds()]


def shown(
    cases: Sequence[tuple[str, str, Law]], found: Callable[[Law, str], list[str]], engine: str
) -> list[list[str]]:
    """Rows of a table: sole, law, and what is found of it."""
    bar = tqdm(cases, desc=f"{engine}, {found.__name__}", mininterval=30.0 if not sys.stderr.isatty() else 0.1)
    return [[sole, name, *found(law, engine)] for sole, name, law in bar]


@click.command()
@click.option("--engine", "engines", multiple=True, default=("hybrid", "mujoco"), help="Engine; may be repeated.")
@TABLES
def main(engines: Sequence[str], tables: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    every = [(sole, name, law) for sole, size in SOLES.items() for name, law in laws(size)]
    kinds = [name for name, _ in grounds()]
    for engine in engines:
        cases = [case for case in every if engine == "hybrid" or case[1] != ONE_GAIT]
        rows = shown(cases, on_grounds, engine)
        columns = [f"{sole}: {name}" for sole, name, *_ in rows]
        turned = [
            [kind, *cells] for kind, cells in zip(kinds, zip(*(row[2:] for row in rows), strict=True), strict=True)
        ]
        show_table(f"{engine}: bounded ankles", ["ground", *columns], turned, tables, f"supervised {engine}")
        rows = shown(cases, on_treads, engine)
        heads = ["sole", "law", "treads of 1 cm, %", "2 cm", "3 cm"]
        show_table(f"{engine}: random treads", heads, rows, tables, f"random {engine}")
        rows = shown(cases, disturbed, engine)
        heads = ["sole", "law", "wrong model, %", "noise and delay, %"]
        show_table(f"{engine}: wrong models and noise", heads, rows, tables, f"wrong {engine}")


if __name__ == "__main__":
    main()
