"""A stance knee that is held by its motor, beside one that is locked: outcome, cost, torque and sag, in MuJoCo.

Sixty steps with references of 8 cm. Half a minute, and once two minutes for the references. The result stands in
`docs/tables/kneed_walks.md`.

    python -m scripts.studies.stance_knee_study --tables docs/tables/kneed_walks
"""

from collections.abc import Iterator
from pathlib import Path

import click
from tqdm.auto import tqdm

import mjbiped
from controllers import KneedController
from mjbiped import Terrain
from mjbiped.records import loads
from scripts.pages import TABLES, show_table

CLEARANCE = 0.08  # of the optimised references, m
SAMPLED = 1e-3  # s: each physics step, but for the short ones
HEADINGS = (
    "robot, ground",
    "locked: c_mt",
    "locked: torque, N m",
    "motor: c_mt",
    "motor: c_mt without its work",
    "motor: torque, N m",
    "motor: sag, mrad",
)


def grounds() -> Iterator[tuple[str, Terrain]]:
    """What is walked on, by name."""
    yield "level", Terrain.level()
    yield "−3° all along", Terrain.incline(-3.0)
    yield "stairs +4 cm", Terrain.stairs(rise=0.04, first=1.5)
    yield "stairs −4 cm", Terrain.stairs(rise=-0.04, first=1.5)


def cost(walk: mjbiped.Walk, part: float = 0.0) -> str:
    """Its cost of transport less a part, if it came through; else what became of it."""
    if walk.outcome != "finished":
        return f"{walk.outcome} after {walk.steps}"
    return f"{walk.cost_of_transport - part:.4f}"


def row(law: KneedController, ground: Terrain, steps: int) -> list[str]:
    """What the headings say of one ground."""
    locked, held = (
        mjbiped.walk(law, ground, engine=mjbiped.Mujoco(stance_knee=kind), steps=steps, sample_period=SAMPLED)
        for kind in ("locked", "motor")
    )
    measured = held.summary()
    return [
        cost(locked),
        f"{loads.peak_knee_torque(locked):.1f}",
        cost(held),
        cost(held, measured["cost_of_transport_stance_knee"] or 0.0),
        f"{measured['peak_stance_knee_torque_Nm']:.1f}",
        f"{1e3 * loads.flexion(held).max():.1f}",
    ]


@click.command(help=__doc__)
@click.option("--steps", default=60, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
@TABLES
def main(steps: int, tables: Path | None) -> None:
    """Walk everything and print the table."""
    robots = {"light shanks": mjbiped.KneedBiped(), "halved rods": mjbiped.KneedBiped.halved_rods()}
    rows = []
    for name, robot in tqdm(robots.items(), desc="robots", disable=None):
        law = KneedController(robot, mjbiped.find_reference(robot, clearance=CLEARANCE))
        rows += [[f"{name}, {kind}", *row(law, ground, steps)] for kind, ground in grounds()]
    show_table(f"{steps} steps", HEADINGS, rows, tables, "stance knee")


if __name__ == "__main__":
    main()
