"""The lateral state of the compass in space: its return map, and basins on a narrow sole with two laws.

Both laws lean on a sole of 24 by 8 cm, and one of them places the next foot by the hips' abduction; on level ground, in
the hybrid engine, for ten steps: ten minutes of two cores.

    python -m scripts.studies.lateral_study
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import click
import numpy as np

import mjbiped
from mjbiped.control.registry import make_controller
from mjbiped.limit_cycles.lateral import ROLL, ROLL_RATE, LateralBasin
from mjbiped.limit_cycles.map_slices import map_slices
from mjbiped.plotting.style import make_small
from mjbiped.utils.parallel import processes
from scripts.studies.three_d_study import WALKERS

WALKED = ("compass, sole of 24 by 8 cm", "compass whose hips abduct, same sole")
STARTS, TABLE = 17, Path("docs/tables/three_dimensions/lateral_basin.csv")


def basin_of(walker: str) -> LateralBasin:
    """The map of a walker of `WALKERS`."""
    kind, feet, law, _ = WALKERS[walker]
    rolls, rates = np.linspace(-ROLL, ROLL, STARTS), np.linspace(-ROLL_RATE, ROLL_RATE, STARTS)
    return mjbiped.lateral_basin(make_controller(law, kind(**feet), {}), rolls=rolls, roll_rates=rates)


@click.command(help=__doc__)
@click.option("--table", type=click.Path(path_type=Path), default=TABLE)
@click.option("--images", type=click.Path(path_type=Path), default=Path("docs/images"))
def main(table: Path, images: Path) -> None:
    """Draw the map, and walk from all starts of both."""
    slices = map_slices(mjbiped.Compass3D(), math.radians(2.0))
    mjbiped.plot_return_map(slices, images / "return_map_space.png")
    with processes(len(WALKED)) as pool:
        basins = list(pool.map(basin_of, WALKED))
    mjbiped.plot_lateral_basins(basins, images / "lateral_basin.png")
    for name in ("return_map_space.png", "lateral_basin.png"):
        make_small(images / name)
    with table.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["walker", "roll deg", "roll rate rad/s", "divergent component cm", "steps", "goes on"])
        for walker, basin in zip(WALKED, basins, strict=True):
            for i, j in np.ndindex(basin.steps.shape):
                writer.writerow([
                    walker, f"{math.degrees(basin.rolls[j]):g}", f"{basin.roll_rates[i]:.4g}",
                    f"{100 * basin.deviations[i, j]:.2f}", basin.steps[i, j], "no" if basin.fallen[i, j] else "yes",
                ])  # fmt: skip


if __name__ == "__main__":
    main()
