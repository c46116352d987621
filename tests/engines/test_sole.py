"""Walks on a sole: the centre of pressure, read from the record, never leaves it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.records.loads import centre_of_pressure

ROBOT = mjbiped.Compass(sole=(0.03, 0.05))
EXACT = 1e-9  # m, and N m: the law of the record and that of the engine round differently
MUJOCO = 1e-3  # m; the load is that of the step before, which changes by some 0.2 %


def walked(sole: tuple[float, float], engine: Any, ground: mjbiped.Terrain, **terms: Any) -> mjbiped.Walk:
    robot = mjbiped.Compass(sole=sole)
    law = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))
    return mjbiped.walk(law, ground, engine=engine, **{"steps": 6, **terms})


@pytest.mark.parametrize(
    ("engine", "pushes"), [("hybrid", ()), ("hybrid", ((0.3, 1.0), (1.1, -1.0))), ("mujoco", ())], ids=str
)
def test_the_centre_of_pressure_reaches_an_end_and_goes_no_farther(engine: str, pushes: Any) -> None:
    ground = mjbiped.Terrain.stairs(tread=1.8, rise=-0.01)
    disturbances = mjbiped.Disturbances(pushes=pushes) if pushes else None
    walk = walked((0.03, 0.05), engine, ground, disturbances=disturbances)
    steps, (behind, ahead) = walk.touchdowns, walk.robot.sole or (0.0, 0.0)
    over = max(float(steps["pressure_ahead"].max()) - ahead, float(steps["pressure_behind"].max()) - behind)
    assert abs(over) < (EXACT if engine == "hybrid" else MUJOCO)
    given, asked = walk.samples["torque"][:, 0], walk.samples["ankle_asked"]
    bound = given != asked
    assert bound.any()
    assert not bound.all()
    assert (np.abs(given) <= np.abs(asked)).all()
    share = float(np.mean(bound[walk.samples["time"] < steps["time"][-1]]))
    assert steps["sole_bound_time"][-1] / steps["time"][-1] == pytest.approx(share, abs=0.02)
    if engine == "hybrid" and not pushes:
        places = centre_of_pressure(walk)[:-1]
        ends = np.minimum(np.abs(places + behind), np.abs(places - ahead))
        assert np.nanmax(ends[bound[:-1]]) < EXACT  # where it gives less than is asked, at an end


def test_a_sole_of_no_length_transmits_nothing_and_a_long_one_everything() -> None:
    """The long one bit by bit, but for the centre of pressure, which is told by a force that is known at each stage."""
    none = walked((0.0, 0.0), "hybrid", mjbiped.Terrain.mixed(), steps=3)
    assert not none.samples["torque"][:, 0].any()
    assert none.samples["ankle_asked"].any()
    robot = mjbiped.Compass()
    free = mjbiped.walk(
        AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2))),
        mjbiped.Terrain.mixed(),
        engine="hybrid",
        steps=6,
    )
    long = walked((10.0, 10.0), "hybrid", mjbiped.Terrain.mixed())
    for name, column in free.touchdowns.items():
        if not name.startswith("pressure"):
            assert column.tobytes() == long.touchdowns[name].tobytes(), name
