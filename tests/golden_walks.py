"""Walks whose records stay what they are while the inside of the house changes: robots, engines, grounds and laws.

`scripts.golden_walks` walked all of them, and wrote the columns of each walk into `golden_walks.npz`, with how far each
column moves where gravity differs by its last bits, and with the linear algebra of other processors.
"""

import dataclasses
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import mjbiped
from mjbiped import Disturbances, Terrain
from mjbiped.control.registry import make_controller
from mjbiped.robots.robot import Robot

FILE = Path(__file__).with_name("golden_walks.npz")
STEPS = 12
EVERY = 10  # one of so many samples is kept
SAMPLED = ("time", "q", "dq", "torque", "slope_estimate")

ROBOTS: dict[str, Robot] = {
    "compass": mjbiped.Compass(),
    "heavy hip": mjbiped.Compass(hip_mass=10.0),
    "sole": mjbiped.Compass(sole=(0.1, 0.1)),
    "kneed": mjbiped.KneedBiped(),
    "kneed on soles": mjbiped.KneedBiped(sole=(0.1, 0.1)),
    "footed": mjbiped.FootedCompass(),
    "boxes": mjbiped.FootedCompass(underside="box"),
    "round": mjbiped.RoundCompass(),
    "round kneed": mjbiped.RoundKneed(),
    "wheel": mjbiped.RimlessWheel(),
}
GROUNDS: dict[str, Terrain] = {
    "level": Terrain.level(),
    "2 down": Terrain.incline(2.0),
    "3 down": Terrain.incline(3.0),
    "3 up": Terrain.incline(-3.0),
    "mixed": Terrain.mixed(),
    "downstairs": Terrain.stairs(tread=1.8, rise=-0.03),
    "upstairs": Terrain.stairs(tread=1.8, rise=0.01),
    "random": Terrain.random(seed=3),
    "8 down": Terrain.incline(8.0),
    "treads": Terrain.treads(seed=1, tread=0.3, deviation=0.01),
    "riser": Terrain.from_segments([(0.6, -6.0), (5.0, -6.0, 0.05)]),
    "early riser": Terrain.from_segments([(0.55, 0.0), (20.0, 0.0, 0.08)]),
    "later riser": Terrain.from_segments([(0.7, 0.0), (20.0, 0.0, 0.08)]),
    "breaks": Terrain.from_segments([(0.25, 2.0), (0.5, 0.0), (0.35, -2.0), (9.0, 1.0, -0.01)]),
}
DISTURBED = Disturbances(
    angle_noise=1e-3, rate_noise=1e-2, delay=2e-3, control_period=1e-3, torque_limit=30.0, pushes=((0.5, 1.0),), seed=1
)
ENGINES: dict[str, Any] = {
    "hybrid": "hybrid",
    "mujoco": "mujoco",
    "4 ms": mjbiped.Mujoco(timestep=4e-3),
    "plain": mjbiped.Mujoco(timestep=1e-4, lands=False),
    "motor": mjbiped.Mujoco(stance_knee="motor"),
    "boxes": mjbiped.Mujoco(ground="boxes"),
}
BOTH = ("hybrid", "mujoco")


class Case(NamedTuple):
    """A walk; the names are those of the tables above."""

    robot: str
    law: str
    ground: str
    engine: str
    disturbed: bool = False


COMPARED = ("passivity", "energy-constraint", "kinetic-energy", "limit-cycle")
_ASKED: list[tuple[Any, ...]] = [
    ("compass", "adaptive", ("level", "3 up", "mixed", "downstairs", "random"), BOTH),
    ("compass", "passive", ("2 down", "3 down"), BOTH),
    ("compass", "library", ("mixed",), BOTH),
    *(("compass", law, ("level",), BOTH) for law in ("policy", *COMPARED)),
    ("compass", "adaptive", ("mixed",), ("4 ms", "plain", "boxes")),
    ("heavy hip", "adaptive", ("3 down",), BOTH),
    ("sole", "adaptive", ("level",), BOTH),
    ("sole", "bounded-ankle", ("mixed",), BOTH),
    ("sole", "supervised", ("mixed", "treads"), BOTH),
    ("kneed", "adaptive", ("level", "mixed", "upstairs"), BOTH),
    ("kneed", "adaptive", ("mixed",), ("motor",)),
    ("kneed", "passive", ("3 down",), BOTH),
    ("kneed on soles", "bounded-ankle", ("mixed",), BOTH),
    ("footed", "bounded-ankle", ("level",), BOTH),
    ("footed", "supervised", ("mixed",), BOTH),
    ("boxes", "supervised", ("mixed",), BOTH),
    ("round", "passive", ("2 down",), BOTH),
    ("round kneed", "passive", ("2 down",), BOTH),
    ("wheel", "passive", ("8 down",), BOTH),
    ("compass", "adaptive", ("mixed",), BOTH, True),
    ("compass", "adaptive", ("riser", "breaks"), BOTH),
    ("kneed", "adaptive", ("early riser",), BOTH),
    ("kneed", "adaptive", ("later riser", "breaks"), ("hybrid",)),
    ("footed", "adaptive", ("downstairs",), ("hybrid",)),
]
CASES = [
    Case(robot, law, ground, engine, *disturbed)
    for robot, law, grounds, engines, *disturbed in _ASKED
    for ground in grounds
    for engine in engines
]


def walked(case: Case, *, steps: int = STEPS, heavier: float = 0.0, **terms: Any) -> mjbiped.Walk:
    """Walk a case, with a gravity that is greater by a share."""
    robot = ROBOTS[case.robot]
    return mjbiped.walk(
        make_controller(case.law, robot, {}),
        GROUNDS[case.ground],
        engine=ENGINES[case.engine],
        robot=dataclasses.replace(robot, gravity=robot.gravity * (1.0 + heavier)),  # type: ignore[type-var]  # subclasses
        steps=steps,
        disturbances=DISTURBED if case.disturbed else None,
        **terms,
    )


def kept(walk: mjbiped.Walk) -> dict[str, NDArray[Any]]:
    """What is compared of a walk: all columns of its touchdowns, and some samples."""
    return {
        "outcome": np.array(walk.outcome),
        **{f"touchdowns {name}": column for name, column in walk.touchdowns.items()},
        **{f"samples {name}": walk.samples[name][::EVERY] for name in SAMPLED},
    }


def stored(case: Case) -> dict[str, NDArray[Any]]:
    """What the file holds of a case."""
    prefix = f"{CASES.index(case)}/"
    with np.load(FILE) as file:
        return {name.removeprefix(prefix): file[name] for name in file.files if name.startswith(prefix)}
