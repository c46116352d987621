"""An interpreted walk and the same walk as machine code have the same record, to the last bit.

200 walks: robots, laws, engines and grounds, some in a disturbed loop. The quick tests compile for two robots and two
laws.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import mjbiped
from mjbiped import Disturbances, Terrain
from mjbiped.control.registry import make_controller
from mjbiped.engines.compiling import VARIABLE
from mjbiped.robots.robot import Robot

ROBOTS: dict[str, Robot] = {
    "compass": mjbiped.Compass(),
    "sole": mjbiped.Compass(sole=(0.1, 0.1)),
    "kneed": mjbiped.KneedBiped(),
    "kneed on soles": mjbiped.KneedBiped(sole=(0.1, 0.1)),
    "footed": mjbiped.FootedCompass(),
    "round": mjbiped.RoundCompass(),
    "round kneed": mjbiped.RoundKneed(),
    "wheel": mjbiped.RimlessWheel(),
}
LAWS = {
    "compass": (
        "adaptive",
        "passive",
        "library",
        "policy",
        "passivity",
        "energy-constraint",
        "kinetic-energy",
        "limit-cycle",
    ),
    "sole": ("adaptive", "bounded-ankle", "supervised"),
    "kneed": ("adaptive", "passive"),
    "kneed on soles": ("adaptive", "bounded-ankle"),
    "footed": ("bounded-ankle", "supervised"),
    "round": ("passive",),
    "round kneed": ("passive",),
    "wheel": ("passive",),
}
PLANES = {
    "level": Terrain.level(),
    "2 degrees": Terrain.incline(2.0),
    "3 degrees": Terrain.incline(3.0),
    "1 degree up": Terrain.incline(-1.0),
}
GROUNDS = {
    **PLANES,
    "mixed": Terrain.mixed(),
    "downstairs": Terrain.stairs(tread=1.8, rise=-0.03),
    "upstairs": Terrain.stairs(tread=1.8, rise=0.01),
    "random": Terrain.random(seed=3),
}
DISTURBED = Disturbances(
    angle_noise=1e-3, rate_noise=1e-2, delay=2e-3, control_period=1e-3, torque_limit=30.0, pushes=((0.5, 1.0),), seed=1
)
QUICK = {
    ("hybrid", "compass", "adaptive", "upstairs", ""),
    ("hybrid", "compass", "passive", "3 degrees", ""),
    ("mujoco", "compass", "adaptive", "mixed", "disturbed"),
    ("mujoco", "kneed", "passive", "3 degrees", ""),
}


def cases() -> Iterator[Any]:
    for robot, laws in LAWS.items():
        for law in laws:
            for ground in PLANES if ROBOTS[robot].radius else GROUNDS:
                for disturbed in ("", "disturbed") if ground == "mixed" else ("",):
                    for engine in ("hybrid", "mujoco"):
                        case = engine, robot, law, ground, disturbed
                        mark = pytest.mark.compiled if case in QUICK else (pytest.mark.slow, pytest.mark.compiled)
                        yield pytest.param(*case, marks=mark, id="-".join(filter(None, case)))


def everything(walk: mjbiped.Walk) -> dict[str, Any]:
    columns = {name: table[name].tobytes() for table in (walk.samples, walk.touchdowns) for name in table}
    ends = walk.outcome, walk.end, walk.peak_torque.tobytes(), walk.pressure_times.tobytes(), walk.settings
    return {**columns, "ends": ends}


@pytest.mark.parametrize(("engine", "robot", "law", "ground", "disturbed"), [*cases()])
def test_both_ways_make_the_same_walk(
    engine: str, robot: str, law: str, ground: str, disturbed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    controller = make_controller(law, ROBOTS[robot], {})
    found = []
    for way in ("never", "always"):
        monkeypatch.setenv(VARIABLE, way)
        try:
            walk = mjbiped.walk(
                controller,
                GROUNDS[ground],
                engine=engine,
                robot=ROBOTS[robot],
                steps=2 if robot == "footed" else 4,
                initial="rest" if law == "passive" and "degrees" not in ground else "gait",
                disturbances=DISTURBED if disturbed else None,
            )
        except mjbiped.MjbipedError as error:  # such as no gait on this ground
            found.append({"error": str(error)})
        else:
            found.append(everything(walk))
    assert found[0] == found[1]
