"""Walks in space: robots, grounds and pushes, eight phases each, as a table.

A phase of steps and of pushes is where, or when, the first one comes, in eighths; a phase of bumps is a seed, from 1000
on; these numbers tuned nothing. Walks that are finished only with a pull of the ground or with friction over 0.8 are
counted apart. The table grows row by row, and rows that it has are not walked again.

    python -m scripts.studies.three_d_study --engine mujoco --table docs/tables/three_dimensions/mujoco.csv
"""

from __future__ import annotations

import csv
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import click
import numpy as np

import mjbiped
from controllers import AdaptiveController, Controller
from mjbiped.control.registry import make_controller
from mjbiped.controllers.bounded.sideways import SidewaysController

STEPS, PHASES, FIRST_SEED = 30, 8, 1000
SOLE = {"sole": (0.12, 0.12), "sole_width": 0.08}
FRICTION = 0.8


@dataclass(frozen=True)
class PlanarLaw(Controller):
    """The rival: the planar law on the pitch angles, which knows nothing of the roll, and the bounded roll beside it.

    Attributes:
        robot: Robot model of the law.
        gait: Gait in space, for the roll.
    """

    robot: mjbiped.Compass3D
    gait: mjbiped.Gait

    states: ClassVar[tuple[str, ...]] = AdaptiveController.states
    joints: ClassVar[tuple[str, ...]] = mjbiped.Compass3D.joints
    memory_size: ClassVar[int] = AdaptiveController.memory_size

    @cached_property
    def planar(self) -> AdaptiveController:
        """The planar law."""
        flat: Any = self.robot.planar
        return AdaptiveController(flat, mjbiped.find_passive_gait(flat, self.gait.slope))

    @cached_property
    def sideways(self) -> SidewaysController:
        """The law of the roll."""
        return SidewaysController(self.robot, self.gait)

    def start(self, memory: Any, q: Any, dq: Any) -> None:
        """Begin as the planar law."""
        self.planar.start(memory, q[:2], dq[:2])

    def on_touchdown(self, memory: Any, q_before: Any, q: Any, dq: Any) -> None:
        """Update as the planar law."""
        self.planar.on_touchdown(memory, q_before[:2], q[:2], dq[:2])

    def torque(self, memory: Any, t: float, q: Any, dq: Any) -> tuple[float, ...]:
        """Torques of the planar law, and that of the roll."""
        ankle, hip, *rates = self.planar.torque(memory, t, q[:2], dq[:2])
        level = [0.0, 1.0, 0.0, *[0.0] * (self.sideways.memory_size - 3)]
        return ankle, hip, self.sideways.torque(level, t, q, dq)[2], *rates

    def slope_estimate(self, memory: Any) -> float:
        """That of the planar law."""
        return self.planar.slope_estimate(memory)


class Place(NamedTuple):
    """A ground, or a push on level ground.

    Attributes:
        name: In the table.
        phases: Number of phases.
        preset: Name of the terrain's preset.
        given: Its parameters.
        moved: Name of the parameter that a phase moves, its first value, and how far all phases reach.
        push: Lateral impulse, N s.
    """

    name: str
    phases: int = 1
    preset: str = "level"
    given: Mapping[str, Any] = MappingProxyType({})
    moved: tuple[str, float, float] | None = None
    push: float = 0.0


def steps_of(rise: float) -> Place:
    """Stairs of a rise, m."""
    name = f"steps of {100 * rise:+.0f} cm"
    return Place(name, PHASES, "stairs", {"tread": 0.8, "rise": rise}, ("first", 0.6, 0.8))


def bumps_of(rms: float) -> Place:
    """Bumps of a height, m."""
    return Place(f"bumps of {1000 * rms:.0f} mm rms", PHASES, "bumps", {"rms": rms}, ("seed", FIRST_SEED, PHASES))


def incline_of(slope: float, lateral: float = 0.0) -> Place:
    """A plane, degrees."""
    name = f"lateral {lateral:g} deg" if lateral else f"slope {slope:+g} deg"
    return Place(name, 1, "incline", {"slope_deg": slope, "lateral_deg": lateral})


def push_of(impulse: float) -> Place:
    """A lateral push on level ground, N s."""
    return Place(f"push {impulse:g} N s", PHASES, push=impulse)


PLACED = [push_of(1.0), bumps_of(0.01), Place("level"), incline_of(3), incline_of(-3), incline_of(0, 2), push_of(2.0),
          bumps_of(0.005), steps_of(0.02), steps_of(-0.02)]  # fmt: skip
ALONE = {"sole_share": 0.0, "margin": 0.0, "timing_share": 0.0, "placement_gain": 0.9, "lead": 0.0833, "pace": 20.0,
         "closest": -0.12}  # fmt: skip
"""Best gains of the law that places the feet alone; see `scripts.studies.placement_gains`."""

WALKERS: dict[str, tuple[Any, dict[str, Any], str, list[Place]]] = {
    "compass, roll not bounded": (
        mjbiped.Compass3D, {}, "adaptive",
        [Place("level"), incline_of(3), incline_of(-3), steps_of(0.02), steps_of(-0.02), incline_of(0, 3),
         bumps_of(0.01), push_of(3.0)],
    ),
    "compass, sole of 24 by 8 cm": (
        mjbiped.Compass3D, SOLE, "bounded-ankle",
        [Place("level"), incline_of(3), incline_of(-3), steps_of(0.02), steps_of(-0.02), incline_of(0, 2),
         bumps_of(0.005), bumps_of(0.01), push_of(1.0)],
    ),
    "rival: planar law, roll beside it, same sole": (
        mjbiped.Compass3D, SOLE, "rival",
        [Place("level"), incline_of(3), incline_of(-3), steps_of(0.02), steps_of(-0.02), incline_of(0, 2),
         bumps_of(0.005), bumps_of(0.01), push_of(1.0)],
    ),
    "compass whose hips abduct, same sole": (mjbiped.Abducting3D, SOLE, "bounded-ankle", PLACED),
    "rival: feet placed, no torque about the heading": (mjbiped.Abducting3D, SOLE, "placement alone", PLACED),
    "knees, roll not bounded": (
        mjbiped.Kneed3D, {}, "adaptive",
        [Place("level"), incline_of(2), incline_of(-2), incline_of(0, 1), bumps_of(0.005)],
    ),
}  # fmt: skip


def walked(walker: str, place: Place, phase: int, engine: str) -> mjbiped.Walk:
    """Make a walk."""
    kind, feet, law, _ = WALKERS[walker]
    robot = kind(**feet)
    given, pushes = dict(place.given), None
    if place.moved:
        name, first, reach = place.moved
        given[name] = type(first)(first + phase * reach / place.phases)
    if place.push:
        time = 5.0 + 0.8 * phase / place.phases
        pushes = mjbiped.Disturbances(pushes=[(time, place.push)], push_direction=math.pi / 2)
    terrain = mjbiped.Terrain.preset(place.preset, **given)
    if law == "rival":
        controller: Controller = PlanarLaw(robot, mjbiped.find_gait_in_space(robot, math.radians(2.0)))
    elif law == "placement alone":
        controller = make_controller("bounded-ankle", robot, dict(ALONE))
    else:
        controller = make_controller(law, robot, {})
    return mjbiped.walk(controller, terrain, engine=engine, steps=STEPS, sample_period=0.02, disturbances=pushes)


def row_of(walker: str, place: Place, phase: int, walk: mjbiped.Walk) -> dict[str, str]:
    """Cells of a walk."""
    told, steps = walk.summary(), walk.touchdowns
    roll = np.degrees(walk.samples["q"][:, -1])
    pull, friction = float(np.min(steps["normal_force"], initial=0.0 if not walk.steps else math.inf)), 0.0
    friction = float(np.max(steps["friction"], initial=0.0))
    cost = told["cost_of_transport_roll"] or math.nan
    return {
        "walker": walker, "ground": place.name, "phase": str(phase), "outcome": walk.outcome, "steps": str(walk.steps),
        "c_mt": f"{(told['cost_of_transport'] or math.nan) - cost:.4f}", "c_mt of the roll": f"{cost:.4f}",
        "roll from deg": f"{roll.min():.1f}", "roll to deg": f"{roll.max():.1f}",
        "yaw deg": f"{np.degrees(np.abs(walk.samples['qpos'][:, -1]).max()):.2f}",
        "peak roll torque N m": f"{walk.peak_torque[-1]:.2f}", "least force N": f"{pull:.1f}",
        "friction": f"{friction:.2f}",
    }  # fmt: skip


def todo(known: set[tuple[str, str, str]], walkers: Collection[str]) -> Iterator[tuple[str, Place, int]]:
    """Walks that are not in the table yet."""
    for phase in range(PHASES):
        for walker in walkers:
            for place in WALKERS[walker][-1]:
                if phase < place.phases and (walker, place.name, str(phase)) not in known:
                    yield walker, place, phase


def summed_up(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """A row for each walker and ground: how many walks were finished, and how many of these kept to contact's laws."""
    groups: dict[tuple[str, str], list[dict[str, str]]] = {}
    for row in rows:
        groups.setdefault((row["walker"], row["ground"]), []).append(row)
    told = []
    for (walker, ground), walks in groups.items():
        done = [walk for walk in walks if walk["outcome"] == "finished"]
        sound = [walk for walk in done if float(walk["friction"]) <= FRICTION and float(walk["least force N"]) >= 0.0]

        def span(name: str, done: list[dict[str, str]] = done) -> str:
            values = sorted((walk[name] for walk in done), key=float)
            return " to ".join(dict.fromkeys((values[0], values[-1]))) if values else "-"

        told.append({
            "walker": walker, "ground": ground, "finished": f"{len(done)} of {len(walks)}",
            "without a pull, friction to 0.8": f"{len(sound)}", "c_mt of the legs": span("c_mt"),
            "c_mt of the roll": span("c_mt of the roll"), "yaw deg": span("yaw deg").rpartition(" ")[2],
            "peak roll torque N m": span("peak roll torque N m").rpartition(" ")[2],
            "steps of walks that failed": ", ".join(walk["steps"] for walk in walks if walk not in done) or "-",
        })  # fmt: skip
    return told


@click.command(help=__doc__)
@click.option("--engine", type=click.Choice(["mujoco", "hybrid"]), default="mujoco", help="Physics.")
@click.option("--table", type=click.Path(path_type=Path), required=True, help="CSV file that grows.")
@click.option("--walker", "walkers", multiple=True, type=click.Choice(list(WALKERS)), help="Which walk; default: all.")
def main(engine: str, table: Path, walkers: tuple[str, ...]) -> None:
    """Walk what the table lacks."""
    known = set()
    if table.exists():
        with table.open() as file:
            known = {(row["walker"], row["ground"], row["phase"]) for row in csv.DictReader(file)}
    left = list(todo(known, walkers or WALKERS))
    for number, (walker, place, phase) in enumerate(left):
        row = row_of(walker, place, phase, walked(walker, place, phase, engine))
        table.parent.mkdir(parents=True, exist_ok=True)
        with table.open("a", newline="") as file:
            writer = csv.DictWriter(file, row, lineterminator="\n")
            if not file.tell():
                writer.writeheader()
            writer.writerow(row)
        click.echo(f"{number + 1} of {len(left)}: {', '.join(row.values())}")
    with table.open() as file:
        told = summed_up(list(csv.DictReader(file)))
    with table.with_stem(f"{table.stem}_summary").open("w", newline="") as file:
        writer = csv.DictWriter(file, told[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(told)


if __name__ == "__main__":
    main()
