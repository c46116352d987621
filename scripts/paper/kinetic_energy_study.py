"""What kinetic energy tracking bears: single steps and changes of slope, in both engines (ten minutes).

The paper's introduction says of it that it withstands a step of 5 % of the leg's length and a change of slope of 3
degrees. Writes a figure and the tables of docs/tables/comparison.md: python -m scripts.paper.kinetic_energy_study
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import click
import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm

import mjbiped
from controllers import KineticEnergyController
from mjbiped.controllers.comparison.known_slope import SLOPE_SOURCES
from mjbiped.engines.mujoco import scene
from mjbiped.plotting.panels import titled
from mjbiped.plotting.style import drawn
from mjbiped.terrain.profile import GROUND_FRICTION
from scripts.pages import write_table

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
GAINS = (2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0)
WEIGHTS = {0.0: "ankle alone", 1.0: "both joints (w = 1)"}
SOURCE_WORDS = {"none": "no slope known", "local": "slope at the foot", "two_point": "slope between the feet"}

STEPS = (-0.05, -0.04, -0.03, -0.02, -0.01, 0.01, 0.02, 0.03, 0.04, 0.05)
"""Single steps, m up."""

TURNS = (-3.0, 3.0)
"""Single changes of slope from level ground, degrees downhill."""

CLAIM = ("−50 mm", "−3°", "+3°")
"""What the method is said to bear; the step down, for the imitated gait's swing foot clears 46 mm."""

PLACES = 6
"""Of the change, evenly over two steps, so that it is met after a long and after a short one."""

ON = 30
"""Steps to be walked in all; the change is met in the third or fourth."""

LEVEL = 80  # steps until the robot walks its own way


class Law(NamedTuple):
    """What is varied of the controller."""

    hip_weight: float
    slope_source: str
    gain: float

    @property
    def controller(self) -> KineticEnergyController:
        """The law itself."""
        return KineticEnergyController(ROBOT, GAIT, **self._asdict())

    @property
    def words(self) -> str:
        """As the tables name it."""
        return f"{WEIGHTS[self.hip_weight]}, {self.slope_source}, λ = {self.gain:g}"


_CLASS = KineticEnergyController(ROBOT, GAIT)
DEFAULT = Law(_CLASS.hip_weight, _CLASS.slope_source, _CLASS.gain)
SHOWN = {
    Law(1.0, "local", 6.0): "settled gains",
    Law(1.0, "local", 30.0): "",
    Law(1.0, "local", 50.0): "",
    Law(0.0, "two_point", 15.0): "",
    DEFAULT: "default",
    Law(0.0, "two_point", 30.0): "",
    Law(0.0, "none", 40.0): "nearest to Table II",
}
"""Laws of the table, and what they are."""

Results = Mapping[tuple[Law, str, str], Sequence[Mapping[str, Any]]]
"""Measures of the walks by law, change of the ground and start: "gait" on the imitated gait, "own" as the law walks on
level ground after many steps."""


def changes(place: float) -> dict[str, mjbiped.Terrain]:
    """All changes of the ground at a place, m."""
    grounds = {f"{1000 * rise:+.0f} mm": (99.0, 0.0, rise) for rise in STEPS}
    grounds |= {f"{turn:+.0f}°": (99.0, turn, 0.0) for turn in TURNS}
    return {
        name.replace("-", "−"): mjbiped.Terrain.from_segments([(place, 0.0, 0.0), segment])
        for name, segment in grounds.items()
    }


NAMES = tuple(changes(1.0))


def met(laws: Sequence[Law], engine: str, names: Iterable[str] = NAMES) -> Results:
    """Let each law meet each change at every place, from both starts."""
    wanted = set(names)
    disturbed = (*GAIT.start[:3], GAIT.start[3] + 0.01)  # an unstable gait is left behind within the walk
    level = mjbiped.walk_many(
        [law.controller for law in laws],
        mjbiped.Terrain.level(),
        engine="hybrid",
        steps=LEVEL,
        sample_period=None,
        initial=disturbed,
    )
    keys, grounds, starts = [], [], []
    for law, walk in zip(laws, level, strict=True):
        if walk.outcome != "finished":
            raise SystemExit(f"{law.words} does not walk on level ground")
        x, (q1, _), dq = walk.touchdowns["x"], walk.touchdowns["q"][-1], walk.touchdowns["dq"][-1]
        for place in range(PLACES):
            for name, ground in changes((x[-1] - x[-3]) * (1.0 + (place + 0.5) / PLACES)).items():
                if name in wanted:
                    keys += [(law, name, "gait"), (law, name, "own")]
                    grounds += [ground, ground]
                    starts += ["gait", (q1, -q1, *dq)]
    walks = mjbiped.walk_many(
        [law.controller for law, _, _ in keys],
        grounds,
        engine=engine,
        steps=ON,
        initial=starts,
        sample_period=None,
        summaries=True,
        progress=True,
    )
    results: dict[tuple[Law, str, str], list[Mapping[str, Any]]] = {}
    for key, measures in zip(keys, walks, strict=True):
        results.setdefault(key, []).append(measures)
    return results


def survived(results: Results, law: Law, name: str, *starts: str) -> int:
    """How many walks of a law over a change came to their end."""
    return sum(walk["outcome"] == "finished" for start in starts for walk in results[law, name, start])


def greatest(results: Results, law: Law, measure: str, names: Iterable[str]) -> float:
    """The greatest value of a measure over walks of a law from the imitated gait."""
    return max(float(walk[measure]) for name in names for walk in results[law, name, "gait"])


@click.command(help=__doc__)
@click.option(
    "--figure", default="docs/images/comparison_kinetic_energy.png", show_default=True, type=click.Path(path_type=Path)
)
@click.option("--tables", default="docs/tables/comparison", show_default=True, type=click.Path(path_type=Path))
def main(figure: Path, tables: Path) -> None:
    """Walk, tabulate and draw."""
    every = [Law(weight, source, gain) for weight in WEIGHTS for source in SLOPE_SOURCES for gain in GAINS]
    hybrid = met(every, "hybrid")
    draw(hybrid, figure)
    mujoco = met(list(SHOWN), "mujoco")
    rows = []
    for law, words in SHOWN.items():
        for engine, results in (("hybrid", hybrid), ("MuJoCo", mujoco)):
            counts = [[survived(results, law, name, start) for start in ("gait", "own")] for name in NAMES]
            cells = (f"{gait}, {own}" for gait, own in counts)
            rows.append((law.words + (f" ({words})" if words else ""), engine, *cells))
    write_table(tables, "bears", ("law", "engine", *NAMES), rows)
    write_table(tables, "candidates", *candidates(every, hybrid))
    write_table(tables, "why", *why())
    click.echo(f"wrote {figure}\nwrote {tables}")


Table = tuple[tuple[str, ...], list[tuple[str, ...]]]


def candidates(laws: Sequence[Law], hybrid: Results) -> Table:
    """The laws that bear what the method is said to bear from the imitated gait, at every place."""
    bear = [law for law in laws if all(survived(hybrid, law, name, "gait") == PLACES for name in CLAIM)]
    mujoco = met(bear, "mujoco", CLAIM)
    rows: list[tuple[str, ...]] = []
    for law in bear:
        both = all(survived(mujoco, law, name, "gait") == PLACES for name in CLAIM)
        friction = greatest(hybrid, law, "largest_stance_friction", CLAIM)
        ankle = greatest(hybrid, law, "peak_ankle_torque_Nm", CLAIM)
        every = sum(survived(hybrid, law, name, "gait", "own") for name in NAMES)
        total = 2 * PLACES * len(NAMES)
        asked = f"{friction:.2f}" if math.isfinite(friction) else "the ground must pull"
        rows.append((law.words, "yes" if both else "no", asked, f"{ankle:.0f}", f"{every} of {total}"))
    return ("law", "MuJoCo too", "friction asked", "ankle, N m", "all changes survived, hybrid"), rows


def why() -> Table:
    """Why both joints at λ = 50 bear 50 mm down in the hybrid engine and not in MuJoCo."""
    law = Law(1.0, "local", 50.0).controller
    ground = changes(6.5 * GAIT.step_length)["−50 mm"]
    walks = [(("hybrid", "–", "–"), mjbiped.walk(law, ground, engine="hybrid", steps=ON))]
    for friction, timesteps in ((GROUND_FRICTION, (1e-3, 2e-4, 1e-4)), (2.0, (1e-3, 1e-4)), (5.0, (1e-3, 1e-4))):
        with patch.object(scene, "GROUND_FRICTION", friction):
            for timestep in timesteps:
                walk = mjbiped.walk(law, ground, steps=ON, engine=mjbiped.Mujoco(timestep=timestep))
                walks.append((("MuJoCo", f"{friction:g}", f"{1e3 * timestep:g}"), walk))
    rows: list[tuple[str, ...]] = [
        (
            *cells,
            f"{walk.outcome}, {walk.steps} steps",
            f"{walk.touchdowns['friction'].max():.2f}",
            f"{walk.peak_torque[0]:.0f}",
        )
        for cells, walk in walks
    ]
    return ("engine", "ground's friction", "timestep, ms", "outcome", "greatest friction", "ankle, N m"), rows


def draw(results: Results, path: Path) -> None:
    """How many walks survive each change, over the gain."""
    total = 2 * PLACES
    with drawn(path) as figure:
        figure.set_figheight(6.6)
        grid = figure.subplots(len(WEIGHTS), len(SLOPE_SOURCES), sharex=True, sharey=True)
        norm = BoundaryNorm(np.arange(-0.5, total + 1), 256)
        for row, (weight, words) in enumerate(WEIGHTS.items()):
            for column, source in enumerate(SLOPE_SOURCES):
                mine = [Law(weight, source, gain) for gain in GAINS]
                table = [[survived(results, law, name, "gait", "own") for law in mine] for name in NAMES]
                axes = grid[row, column]
                mesh = axes.pcolormesh(
                    np.array(table), cmap=colormaps["cividis"], norm=norm, edgecolors="white", linewidth=0.4
                )
                titled(axes, "abcdef"[row * len(SLOPE_SOURCES) + column], f"{words}, {SOURCE_WORDS[source]}")
                axes.set_xticks(np.arange(len(GAINS)) + 0.5, [f"{gain:g}" for gain in GAINS], rotation=90)
                axes.set_yticks(np.arange(len(NAMES)) + 0.5, NAMES)
        for axes in grid[-1]:
            axes.set_xlabel("λ (1/s)")
        for axes in grid[:, 0]:
            axes.set_ylabel("single change of the ground")
        figure.colorbar(mesh, ax=grid, label=f"walks survived, of {total}", ticks=range(0, total + 1, 2))


if __name__ == "__main__":
    main()
