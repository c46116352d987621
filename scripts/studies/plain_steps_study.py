"""What agrees with the hybrid engine where nothing but plain `mj_step` makes the motion.

The default physics steps end at touchdowns, which are foreseen from the terrain's profile, and their softness and the
weight of their accelerations change with them. Here steps are of one length instead: step length, softness and `qacc`
are MuJoCo's own at every step. The same figures of both, against the hybrid engine. Some four minutes. The result
stands in `docs/tables/convergence.md`.

    python -m scripts.studies.plain_steps_study --tables docs/tables/convergence
"""

import math
from pathlib import Path

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import Controller, KneedController, PassiveController
from mjbiped.records import measures
from mjbiped.robots.robot import Robot
from scripts.pages import TABLES, show_rows
from scripts.studies.gallery import ADAPTIVE, TERRAINS

KNEES = mjbiped.KneedBiped()
PASSIVE = "passive, 2° down"


def engines(robot: Robot) -> list[mjbiped.Mujoco]:
    """The default one, and plain steps; locks and the light shank of a robot with knees need shorter ones."""
    shorter = (5e-5, 2e-5) if "knee" in robot.joints else (1e-4, 5e-5)
    return [mjbiped.Mujoco(), *(mjbiped.Mujoco(timestep=timestep, lands=False) for timestep in shorter)]


def walks() -> dict[str, tuple[Robot, Controller, mjbiped.Terrain]]:
    """Robot, controller and ground of each walk, by its name."""
    kneed = KneedController(KNEES, mjbiped.find_kneed_gait(KNEES, math.radians(2.5)))
    return {
        PASSIVE: (ADAPTIVE.robot, PassiveController(), mjbiped.Terrain.incline(2.0)),
        **{name: (ADAPTIVE.robot, ADAPTIVE, terrain) for name, terrain in TERRAINS.items() if name != "rough"},
        "knees, passive, 2.5° down": (KNEES, PassiveController(), mjbiped.Terrain.incline(2.5)),
        "knees, level": (KNEES, kneed, mjbiped.Terrain.level()),
        "knees, stairs_-20mm": (KNEES, kneed, mjbiped.Terrain.stairs(rise=-0.02)),
    }


def row(name: str, engine: mjbiped.Mujoco, there: mjbiped.Walk, here: mjbiped.Walk) -> dict[str, str]:
    """Cells of a walk: differences to the hybrid engine, of step lengths and periods the greatest.

    Impacts are compared with the impact map.
    """
    kind = f"{1e3 * engine.timestep:g} ms, {'default' if engine.lands else 'plain'}"
    walked = {"ground": name, "physics steps": kind}
    if there.outcome != here.outcome or there.steps != here.steps:
        return walked | {"c_mt %": f"{there.outcome} after {there.steps} steps"}
    impacts = 100.0 * np.abs(measures.impact_errors(there)).max(axis=1)
    ankle, hip = there.peak_torque - here.peak_torque
    powered = here.peak_torque.max() > 0.0
    lengths, periods = (of(there) - of(here) for of in (measures.step_lengths, measures.step_periods))
    return walked | {
        "c_mt %": f"{100.0 * (there.cost_of_transport / here.cost_of_transport - 1.0):+.3f}" if powered else "-",
        "peak ankle, hip N m": f"{ankle:+.3f}, {hip:+.3f}" if powered else "-",
        "impact, mean %": f"{impacts.mean():.3f}",
        "impact, worst %": f"{impacts.max():.3f}",
        "step length mm": f"{1e3 * np.abs(lengths).max():.3f}",
        "period ms": f"{1e3 * np.abs(periods).max():.3f}",
    }


@click.command(help=__doc__)
@click.option("--steps", default=20, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
@TABLES
def main(steps: int, tables: Path | None) -> None:
    """Walk everything and print the table."""
    rows = []
    for name, (robot, controller, terrain) in tqdm(walks().items(), desc="grounds", disable=None):
        here = mjbiped.walk(controller, terrain, robot=robot, engine="hybrid", steps=steps, sample_period=None)
        for engine in engines(robot):
            there = mjbiped.walk(controller, terrain, robot=robot, engine=engine, steps=steps, sample_period=None)
            rows.append(row(name, engine, there, here))
    show_rows(f"MuJoCo - hybrid engine, {steps} steps", rows, tables, "plain")


if __name__ == "__main__":
    main()
