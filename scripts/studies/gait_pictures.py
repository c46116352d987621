"""The pictures of docs/gaits.md: return map, bifurcation diagrams, multipliers over slope, basins of attraction.

Some minutes on two cores, most of them for the basin of controlled walking.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

import numpy as np

import mjbiped
from controllers import AdaptiveController
from mjbiped.limit_cycles.bifurcation import Cascade
from mjbiped.limit_cycles.map_slices import map_slices
from mjbiped.limit_cycles.periodic import first_gait, follow
from mjbiped.plotting.gaits import plot_basins, plot_bifurcation, plot_multipliers, plot_return_map
from mjbiped.plotting.style import make_small
from mjbiped.robots.robot import Robot


def draw_bifurcation(robot: Robot, doublings: int, span_deg: tuple[float, float], path: Path) -> Cascade:
    """Draw the bifurcation diagram of a robot; half of its slopes lie where the doublings gather."""
    cascade = mjbiped.find_cascade(robot, doublings, progress=True)
    window = cascade.window
    assert window is not None
    slopes = np.union1d(np.radians(np.linspace(*span_deg, 500)), np.linspace(*window, 500))
    began = time.perf_counter()
    diagram = mjbiped.bifurcation_diagram(robot, slopes, progress=True)
    print(f"diagram of {len(slopes)} slopes: {time.perf_counter() - began:.1f} s; onsets {np.degrees(cascade.onsets)}")
    plot_bifurcation(diagram, cascade, path)
    make_small(path)
    return cascade


def main() -> None:
    """Draw them all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("docs/images"))
    parser.add_argument("--grid", type=int, default=300, help="starts along each side of a basin")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    robot = mjbiped.Compass()

    plot_return_map(map_slices(robot, math.radians(3.2), steps=100), arguments.folder / "return_map.png")
    make_small(arguments.folder / "return_map.png")
    cascade = draw_bifurcation(robot, 5, (2.4, 3.6), arguments.folder / "bifurcation.png")
    draw_bifurcation(mjbiped.KneedBiped(), 4, (5.3, 6.6), arguments.folder / "kneed_bifurcation.png")
    first = first_gait(robot, math.radians(0.1))
    one = list(follow(first, np.radians(np.arange(0.12, 4.5, 0.02)).tolist()))
    plot_multipliers([one, *(branch.gaits for branch in cascade.branches[1:4])], arguments.folder / "multipliers.png")

    began = time.perf_counter()
    passive = mjbiped.basin_of_attraction(
        robot,
        math.radians(2),
        stance_rates=np.linspace(0.8, 1.6, arguments.grid),
        swing_rates=np.linspace(-1.6, 2.4, arguments.grid),
        progress=True,
    )
    print(f"basin, passive: {time.perf_counter() - began:.1f} s")
    began = time.perf_counter()
    controlled = mjbiped.basin_of_control(
        AdaptiveController(robot, mjbiped.find_passive_gait(robot, math.radians(2))),
        stance_rates=np.linspace(-2, 12, arguments.grid),
        swing_rates=np.linspace(-30, 30, arguments.grid),
        progress=True,
    )
    print(f"basin, controlled: {time.perf_counter() - began:.1f} s")
    plot_basins([passive, controlled], arguments.folder / "basin.png")


if __name__ == "__main__":
    main()
