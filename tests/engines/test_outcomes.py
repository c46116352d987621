"""How walks end, in both engines, and what their records say then."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from simulations import Torques

import mjbiped
from controllers import Controller, PassiveController
from mjbiped import Terrain

BOTH = pytest.mark.parametrize("engine", ["hybrid", "mujoco"])


BALANCE = Torques(lambda _, q, dq: (-200.0 * q[0] - 20.0 * dq[0], -20.0 * dq[1]))
PASSIVE = PassiveController()
FALLS, SHORT = (-0.19, 0.19, 0.3, 0.0), Terrain((-1.0,), (0.0,), (math.radians(2.0),), end=0.5)
STALLED = 10.0 / math.sqrt(9.81)  # s


@BOTH
@pytest.mark.parametrize(
    ("outcome", "law", "ground", "terms"),
    [
        ("fell", PASSIVE, Terrain.level(), {"initial": FALLS}),
        ("stalled", BALANCE, Terrain.level(), {"initial": "rest"}),
        ("finished", PASSIVE, Terrain.incline(2.0), {"steps": 2}),
        ("finished", PASSIVE, Terrain.incline(2.0), {"distance": 0.5}),
        ("left the terrain", PASSIVE, SHORT, {"steps": 20}),
        ("diverged", Torques(lambda t, *_: (math.nan if t > 0.3 else 0.0, 0.0)), Terrain.incline(2.0), {"steps": 5}),
    ],
)
def test_outcomes(
    outcome: str, law: Controller, ground: Terrain, terms: Any, engine: str, tmp_path: Path, monkeypatch: Any
) -> None:
    monkeypatch.chdir(tmp_path)  # where MuJoCo would leave its log
    walk = mjbiped.walk(law, ground, engine=engine, **terms)
    assert (walk.outcome, walk.fell) == (outcome, outcome == "fell")
    assert walk.end == (walk.samples["time"][-1], walk.samples["qpos"][-1, 0])
    assert np.isfinite(walk.samples["q"]).all()
    assert not Path("MUJOCO_LOG.TXT").exists()
    if outcome == "fell":  # the hip is at half a leg's height; MuJoCo looks each millisecond
        assert walk.steps == 0
        assert walk.samples["qpos"][-1, 1] == pytest.approx(0.5, abs=1e-6 if engine == "hybrid" else 5e-3)
    elif outcome == "stalled":
        assert walk.end[0] == pytest.approx(STALLED, abs=1e-9 if engine == "hybrid" else 1e-3)
    elif outcome == "diverged":
        assert walk.end[0] == pytest.approx(0.3, abs=1e-6 if engine == "hybrid" else 2e-3)
        assert any("nan for the ankle torque" in text for text in walk.warnings)
    elif "distance" in terms:
        assert [0.0, *walk.touchdowns["x"]][-2] < 0.5 <= walk.distance


@pytest.mark.parametrize(
    ("law", "start"),
    [(Torques(lambda t, *_: (500.0 if t > 0.0 else 0.0, 0.0)), "rest"), (PASSIVE, (0.0, 0.0, 0.0, 20.0))],
    ids=["along the ground", "off the ground"],
)
def test_a_foot_of_mujoco_slips(law: Controller, start: Any) -> None:
    """500 N m at the ankle ask for more than friction holds; a swing leg that is thrown up takes the robot with it."""
    walk = mjbiped.walk(law, Terrain.level(), initial=start)
    assert (walk.outcome, walk.steps) == ("slipped", 0)
    foot = walk.robot.limbs(walk.samples["qpos"][-1])[0, -1]
    assert 0.1 < np.abs(foot).max() < 0.1055  # a tenth of a leg, and what is passed in a physics step


def test_a_foot_of_mujoco_that_slides_under_a_step_has_diverged() -> None:
    """The ankle pushes the foot back over an edge, and forward again below it, as nothing on a riser stops a foot."""
    law = Torques(lambda t, *_: (100.0 if t < 0.02 else -60.0, 0.0))
    ground = Terrain((-5.0, -0.01), (-0.05, 0.0), (0.0, 0.0))
    icy = mjbiped.Disturbances(friction=0.02)
    walk = mjbiped.walk(law, ground, initial="rest", steps=1, sample_period=1e-3, disturbances=icy)
    x, z = walk.robot.limbs(walk.samples["qpos"])[:, 0, -1].T
    assert (walk.outcome, walk.end[0] < 0.1) == ("diverged", True)
    assert x.min() < -0.01 < x[-1]
    assert z[-1] < -0.02  # of a leg's length
