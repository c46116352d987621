"""Which walks stand on a foot: laws of the laboratory on soles of several lengths, on two dozen kinds of ground.

Forty steps, from eight phases of the step at which the ground begins to change, or on eight seeds of random ground. A
walk counts where it comes through and the ground neither has to pull nor needs friction over 0.8. Half an hour on two
cores, most of it in MuJoCo. The results stand in `docs/feet.md`, `docs/tables/feet.md` and `docs/images/feet.png`.

    python -m scripts.studies.soles_study --tables docs/tables/feet --plot docs/images/feet.png
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import (
    AdaptiveController,
    EnergyConstraintController,
    KineticEnergyController,
    KneedController,
    LibraryController,
    LimitCycleController,
    PassivityController,
)
from mjbiped import Terrain
from mjbiped.plotting.style import drawn
from mjbiped.records.measures import FINISHED
from scripts.pages import TABLES, show_table

STEPS, PHASES = 40, 8
BEFORE, STEP = 1.2, 0.378  # m: level ground before the first change, and the length of a step on it
FOOT = 0.29  # m: a human foot is so long in leg lengths, and legs here are of 1 m

Sole: TypeAlias = tuple[float, float] | None
SOLES: Mapping[str, Sole] = {
    "none": None,
    "±12 cm": (0.12, 0.12),
    "±8 cm": (0.08, 0.08),
    "±5 cm": (0.05, 0.05),
    "foot 1/2": (FOOT / 2, FOOT / 2),
    "foot 1/3": (FOOT / 3, FOOT * 2 / 3),
    "foot 1/4": (FOOT / 4, FOOT * 3 / 4),
}
"""Distances behind and ahead of the ankle, m; a foot has its ankle at a half, a third or a quarter of its length."""

DETAILED = ("none", "±12 cm", "foot 1/3")
"""Soles with a table of their own."""

Ground: TypeAlias = Callable[[int], Terrain]


def grounds(before: float = BEFORE) -> Iterator[tuple[str, Ground]]:
    """What is walked on, by name: a function of the phase, or of the seed, from 0 to `PHASES` - 1.

    Args:
        before: Level ground before the first change at the earliest phase, less half of a phase, m.
    """

    def placed(*rows: tuple[float, float, float]) -> Ground:
        return lambda phase: Terrain.from_segments([(before + _late(phase), 0.0, 0.0), *rows])

    def mixed(phase: int) -> Terrain:
        ground, late = Terrain.mixed(), before - BEFORE + _late(phase)
        return Terrain((ground.x[0], *(x + late for x in ground.x[1:])), ground.z, ground.angle)

    def treads(deviation: float) -> Ground:
        return lambda seed: Terrain.treads(seed=9000 + seed, deviation=deviation, length=60.0)

    yield "level", placed()
    for degrees in (1, 2, 3, 5):
        yield f"{degrees}° up", placed((50.0, -degrees, 0.0))
    for degrees in (1, 2, 3, 5):
        yield f"{degrees}° down", placed((50.0, degrees, 0.0))
    yield "changes of ±3°", placed(*[(1.5, 3.0 * (1 - 2 * (k % 2)), 0.0) for k in range(16)])
    for rise in (1, 2, 3, 4, 6):
        yield f"stairs +{rise} cm", placed(*[(1.8, 0.0, rise / 100)] * 12)
    for rise in (2, 4, 6):
        yield f"stairs −{rise} cm", placed(*[(1.8, 0.0, -rise / 100)] * 12)
    yield "mixed", mixed
    for centimetres in (1, 2, 3):
        yield f"treads, {centimetres} cm", treads(centimetres / 100)


def _late(phase: int) -> float:
    return STEP * (phase + 0.5) / PHASES


def laws(sole: Sole) -> Iterator[tuple[str, Any]]:
    """The laws by name, for robots on a sole."""
    robot, knees = mjbiped.Compass(sole=sole), mjbiped.KneedBiped(sole=sole)
    passive = mjbiped.find_passive_gait(robot, slope=np.deg2rad(2))
    lifting = {height: mjbiped.find_reference(robot, speed=0.494, clearance=height) for height in (0.04, 0.06)}
    yield "paper", AdaptiveController(robot, passive)
    for height, gait in lifting.items():
        yield f"{100 * height:g} cm", AdaptiveController(robot, gait, replanning="additive")
    yield "library", LibraryController(robot, lifting[0.04], replanning="additive")
    yield "LCTC", LimitCycleController(robot, passive)
    yield "KETC", KineticEnergyController(robot, passive)
    yield "ECTC", EnergyConstraintController(robot, passive)
    yield "PBC", PassivityController(robot, passive)
    yield "knees, 8 cm", KneedController(knees, mjbiped.find_reference(knees, clearance=0.08))


def through(law: Any, ground: Ground, engine: str) -> tuple[float, float]:
    """Share of the walks that come through, and their mean cost of transport (NaN where not all do)."""
    terrains = [ground(phase) for phase in range(PHASES)]
    walks = mjbiped.walk_many(law, terrains, engine=engine, steps=STEPS, summaries=True)
    good = [walk["cost_of_transport"] for walk in walks if walk["verdict"] == FINISHED]
    return len(good) / PHASES, float(np.mean(good)) if len(good) == PHASES else np.nan


def told(share: float, cost: float) -> str:
    """The cost where all come through, else how many do."""
    return f"{cost:.3f}" if share == 1.0 else f"{round(PHASES * share)} of {PHASES}" if share else "–"


Found: TypeAlias = dict[tuple[str, str, str], tuple[float, float]]
"""Share and cost by law, sole and ground."""


def walked(engine: str, names: Sequence[str]) -> Found:
    """Walk all laws on all soles and grounds."""
    found: Found = {}
    cases = [(sole, name, law) for sole, size in SOLES.items() for name, law in laws(size) if name in names]
    for sole, name, law in tqdm(cases, desc=engine, mininterval=30.0 if not sys.stderr.isatty() else 0.1):
        for ground, made in grounds():
            found[name, sole, ground] = through(law, made, engine)
    return found


def draw(found: Found, path: Path) -> None:
    """Draw a map for each law: the share of the walks that come through, by ground and sole."""
    names = list(dict.fromkeys(name for name, _, _ in found))
    rows, columns = [name for name, _ in grounds()], list(SOLES)
    with drawn(path) as figure:
        figure.set_figheight(3.2 * -(-len(names) // 3) + 1.2)
        grid = figure.subplots(-(-len(names) // 3), 3, sharex=True, sharey=True)
        for axes, name in zip(grid.flat, names, strict=True):
            shares = [[found[name, sole, ground][0] for sole in columns] for ground in rows]
            image = axes.imshow(shares, cmap="cividis", vmin=0.0, vmax=1.0, aspect="auto", interpolation="nearest")
            axes.set_xticks(range(len(columns)), columns, rotation=60)
            axes.set_yticks(range(len(rows)), rows)
            axes.tick_params(labelsize=6)
            axes.set_title(name)
        figure.colorbar(image, ax=grid, label="share of the walks that come through", location="bottom", shrink=0.5)


@click.command()
@click.option("--engine", "engines", multiple=True, default=("hybrid", "mujoco"), help="Engine; may be repeated.")
@TABLES
@click.option("--plot", type=Path, help="Figure of the hybrid engine's walks.")
def main(engines: Sequence[str], tables: Path | None, plot: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    names = [name for name, _ in laws(None)]
    kinds = [name for name, _ in grounds()]
    for engine in engines:
        found = walked(engine, names)
        counts = [[summed(found, name, sole, kinds) for sole in SOLES] for name in names]
        rows = [[name, *row] for name, row in zip(names, counts, strict=True)]
        title = f"{engine}: grounds of {len(kinds)} with {PHASES} of {PHASES} through (share of all walks)"
        show_table(title, ["law", *SOLES], rows, tables, f"laws {engine}")
        for sole in DETAILED:
            rows = [[kind, *(told(*found[name, sole, kind]) for name in names)] for kind in kinds]
            show_table(f"{engine}, sole {sole}", ["ground", *names], rows, tables, f"{sole} {engine}")
        if plot is not None and engine == "hybrid":
            draw(found, plot)


def summed(found: Found, name: str, sole: str, kinds: Sequence[str]) -> str:
    """Number of grounds on which all come through, and the share of all walks."""
    shares = [found[name, sole, kind][0] for kind in kinds]
    return f"{sum(share == 1.0 for share in shares)} ({100 * np.mean(shares):.0f} %)"


if __name__ == "__main__":
    main()
