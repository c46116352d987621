"""Walks on a sole in both engines: the centre of pressure, read from the record, never leaves it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from simulations import hybrid_run

import mjbiped
from controllers import AdaptiveController, KneedController
from mjbiped.records import measures
from mjbiped.records.pressure import centre_of_pressure
from mjbiped.robots.robot import Robot

COMPASS, KNEED = mjbiped.Compass(sole=(0.03, 0.05)), mjbiped.KneedBiped(sole=(0.04, 0.06))
EXACT = 1e-9  # m, and N m: the law of the record and that of the engine round differently
MUJOCO = 1e-3  # m; the load is that of the step before, which changes by some 0.2 % (0.23 mm measured on `mixed`)
GROUNDS = {
    "mixed": mjbiped.Terrain.mixed(),
    "stairs": mjbiped.Terrain.stairs(tread=1.8, rise=-0.01),
    "up": mjbiped.Terrain.incline(-1.0),
}
CASES = [(COMPASS, "stairs"), (COMPASS, "up"), (KNEED, "mixed"), (KNEED, "stairs")]
"""Each reaches an end of its sole; on all but the first the robot falls before long."""


def controller_of(robot: Robot) -> Any:
    if isinstance(robot, mjbiped.KneedBiped):
        return KneedController(robot, mjbiped.find_kneed_gait(robot, slope=np.deg2rad(2.5)))
    assert isinstance(robot, mjbiped.Compass)
    return AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))


def walked(robot: Robot, engine: Any, ground: str = "mixed", **terms: Any) -> mjbiped.Walk:
    return mjbiped.walk(controller_of(robot), GROUNDS[ground], engine=engine, **{"steps": 12, **terms})


def farthest(walk: mjbiped.Walk) -> float:
    """How far the centre of pressure has left the sole at most, m; below zero it has not reached its ends."""
    behind, ahead = walk.robot.sole or (np.inf, np.inf)
    steps = walk.touchdowns
    return max(float(np.max(steps["pressure_ahead"])) - ahead, float(np.max(steps["pressure_behind"])) - behind)


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "ground"), CASES)
def test_the_centre_of_pressure_stays_on_the_sole(robot: Robot, ground: str) -> None:
    walk, (behind, ahead) = walked(robot, "hybrid", ground), robot.sole or (0.0, 0.0)
    assert -EXACT < farthest(walk) < EXACT  # it reaches an end, and does not go beyond
    places = centre_of_pressure(walk)[:-1]
    assert np.nanmin(places) > -behind - EXACT
    assert np.nanmax(places) < ahead + EXACT
    given, asked = walk.samples["torque"][:, 0], walk.samples["ankle_asked"]
    bound = given != asked
    assert bound.any()
    assert not bound.all()
    assert (np.abs(given) <= np.abs(asked)).all()
    ends = np.minimum(np.abs(places + behind), np.abs(places - ahead))
    # a robot that falls may drag its swing foot, whose force on the ground the record does not tell
    standing = walk.samples["time"][:-1] < walk.touchdowns["time"][-1]
    assert np.max(ends[bound[:-1] & standing]) < EXACT  # where it gives less than is asked, at an end


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "ground", "timestep"), [(*CASES[0], 1e-3), (*CASES[2], 2e-4)])
def test_mujoco_keeps_it_on_the_sole_as_well(robot: Robot, ground: str, timestep: float) -> None:
    """With knees the share of the time converges slowly: 0.46 hybrid, 0.48 with steps of 0.2 ms, 0.57 of 1 ms."""
    engines = (mjbiped.Hybrid(), mjbiped.Mujoco(timestep=timestep))
    walks = [walked(robot, engine, ground, steps=5) for engine in engines]
    assert farthest(walks[1]) < MUJOCO
    shares = [measures.summary(walk)["share_of_time_at_sole_bound"] for walk in walks]
    # single physics steps without contact, in which nothing is transmitted, come to less than a hundredth of the time
    assert shares[0] == pytest.approx(shares[1], abs=0.02)
    assert 0.01 < shares[0] < 0.9
    costs = [walk.cost_of_transport for walk in walks]
    assert costs[0] == pytest.approx(costs[1], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [mjbiped.Compass, mjbiped.KneedBiped])
def test_a_sole_that_is_long_enough_changes_nothing(kind: Any) -> None:
    """Bit by bit; only places of the centre of pressure are told by a force that is known at each stage."""
    free, soled = walked(kind(), "hybrid"), walked(kind(sole=(10.0, 10.0)), "hybrid")
    for table in ("samples", "touchdowns"):
        for name, column in getattr(free, table).items():
            if not name.startswith("pressure"):
                assert column.tobytes() == getattr(soled, table)[name].tobytes(), name
    assert measures.summary(free)["share_of_time_at_sole_bound"] is None
    assert measures.summary(soled)["share_of_time_at_sole_bound"] == 0.0


def test_without_any_length_no_torque_of_the_ankle_acts() -> None:
    walk = mjbiped.walk(controller_of(mjbiped.Compass(sole=(0.0, 0.0))), GROUNDS["mixed"], engine="hybrid", steps=3)
    assert not walk.samples["torque"][:, 0].any()
    assert walk.samples["ankle_asked"].any()


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "ground"), [CASES[1], CASES[2]])
def test_plain_python_walks_as_compiled_code_does(robot: Robot, ground: str) -> None:
    """But for the integrator's error where the bound begins and ends: on either side of it steps differ by rounding."""
    controller = controller_of(robot)
    q, dq = np.split(np.asarray(controller.gait.start), 2)
    first = {"q": q.tolist(), "dq": dq.tolist()}
    compiled, plain = (
        hybrid_run(controller, GROUNDS[ground], robot=robot, steps=2, compile=compile, **first)
        for compile in (True, False)
    )
    for run in (compiled, plain):
        run.walk(lambda *_: None)
    assert compiled.state.bound_time > 0.1
    # measured: 1.6e-7 with the tolerance of 1e-8, 3e-9 with one of 1e-10; the time by the stages' places, 3 ms
    assert np.asarray(plain.state.y) == pytest.approx(np.asarray(compiled.state.y), abs=1e-6)
    assert plain.state.bound_time == pytest.approx(compiled.state.bound_time, abs=0.01)


def test_pushes_load_the_sole_too() -> None:
    """A push at the hip changes the force on the ground, which bounds the torque."""
    pushed = mjbiped.Disturbances(pushes=((0.3, 1.0), (1.1, -1.0)))
    walk = walked(COMPASS, "hybrid", "stairs", disturbances=pushed)
    assert -EXACT < farthest(walk) < EXACT


def test_gaits_are_those_of_the_robot_without_its_sole() -> None:
    free, soled = mjbiped.Compass(), COMPASS
    gaits = [mjbiped.find_passive_gait(robot, slope=0.03) for robot in (free, soled)]
    assert gaits[0].start.tobytes() == gaits[1].start.tobytes()
    assert gaits[1].robot == soled
    assert soled.mechanism == free == free.mechanism


def test_records_hold_the_sole(tmp_path: Any) -> None:
    walk = walked(COMPASS, "hybrid", steps=2)
    walk.save(tmp_path / "walk.npz")
    again = mjbiped.Walk.load(tmp_path / "walk.npz")
    assert again == walk
    assert again.robot == COMPASS
    assert "sole" not in mjbiped.Compass().to_dict()
