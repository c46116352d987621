"""Walks in space: both engines, costs, knees, soles, pushes, records, and the law's Lyapunov function."""

import math
from pathlib import Path
from typing import Any

import golden_numbers
import numpy as np
import pytest

import mjbiped
from mjbiped.control.registry import make_controller
from mjbiped.records.ending import why_it_failed
from mjbiped.robots.in_space import InSpace

SOLE: dict[str, Any] = {"sole": (0.12, 0.12), "sole_width": 0.08}
LEVEL, SIDE = mjbiped.Terrain.level(), math.pi / 2
each_engine = pytest.mark.parametrize("engine", ["hybrid", "mujoco"])


def walked(robot: InSpace, terrain: mjbiped.Terrain, engine: Any, law: str = "adaptive", **given: Any) -> mjbiped.Walk:
    """A short walk, without samples unless they are asked for."""
    controller = make_controller(law, robot, {})
    return mjbiped.walk(controller, terrain, engine=engine, **{"steps": 4, "sample_period": None, **given})


@pytest.mark.parametrize(
    ("robot", "terrain", "cost"),
    [  # design figures of plain MuJoCo, without the roll's cost
        (mjbiped.Compass3D(), LEVEL, 0.0349),
        pytest.param(mjbiped.Compass3D(), mjbiped.Terrain.incline(3.0), 0.0176, marks=pytest.mark.slow),
        pytest.param(mjbiped.Compass3D(), mjbiped.Terrain.incline(-3.0), 0.0874, marks=pytest.mark.slow),
        pytest.param(mjbiped.Compass3D(), mjbiped.Terrain.incline(0.0, lateral_deg=3.0), 0.0349, id="lateral"),
    ],
)
def test_costs_of_the_plan(robot: InSpace, terrain: mjbiped.Terrain, cost: float) -> None:
    """The first steps are led from level ground's estimate to the ground's own, and count not."""
    walk = walked(robot, terrain, "hybrid", steps=6)
    steps, load = walk.touchdowns, robot.weight * np.diff(walk.touchdowns["x"][[3, -1]])
    work = steps["work_absolute"] - steps["roll_work"]
    assert np.diff(work[[3, -1]]) / load == pytest.approx(cost, abs=3e-4)
    assert np.degrees(steps["slope_estimate"][-1]) == pytest.approx(np.degrees(steps["slope"][-1]), abs=1e-3)
    assert steps["lateral_estimate"][-1] == pytest.approx(steps["lateral_slope"][-1], abs=1e-5)


@pytest.mark.parametrize(
    ("robot", "terrain", "steps", "period", "limit"),
    [
        (mjbiped.Compass3D(), mjbiped.Terrain.stairs(tread=0.8, rise=0.02, first=0.6), 3, 1e-3, 1e-3),
        (mjbiped.Compass3D(), mjbiped.Terrain.incline(-3.0, lateral_deg=1.0), 3, 1e-3, 1.5e-3),
        pytest.param(
            mjbiped.Kneed3D(), mjbiped.Terrain.incline(1.0, lateral_deg=1.0), 1, 2e-4, 2e-3, marks=pytest.mark.slow
        ),
    ],
    ids=["steps", "up", "knees"],
)
def test_engines_agree(robot: InSpace, terrain: mjbiped.Terrain, steps: int, period: float, limit: float) -> None:
    """Touchdown states, to a share of their size: MuJoCo tells them up to two steps late; knees need short ticks."""
    contacts = mjbiped.Mujoco(timestep=1e-4, control_period=period)
    there, here = (walked(robot, terrain, engine, steps=steps) for engine in (contacts, "hybrid"))
    assert there.outcome == here.outcome == "finished"
    for name in ("q", "dq", "q_before", "dq_before"):
        apart = np.linalg.norm(there.touchdowns[name] - here.touchdowns[name], axis=1)
        assert (apart < limit * np.linalg.norm(here.touchdowns[name], axis=1)).all(), name
    for name in ("time", "x", "y"):
        np.testing.assert_allclose(there.touchdowns[name], here.touchdowns[name], rtol=1e-3, err_msg=name)
    # MuJoCo tells a knee strike up to 1 ms late, and the legs' rates change by 5 rad/s^2
    for name, near in (("knee_strike", 1e-3), ("knee_dq_before", 5e-3), ("knee_dq", 5e-3)):
        if name in here.touchdowns:
            np.testing.assert_allclose(there.touchdowns[name], here.touchdowns[name], rtol=0, atol=near, err_msg=name)
    assert there.cost_of_transport == pytest.approx(here.cost_of_transport, rel=2e-3)


@each_engine
def test_a_sole_bounds_both_torques_and_the_law_for_it_walks(engine: str) -> None:
    """A push across makes the law ask for all that the sole's width bears; the exact law asks for more than that."""
    robot, push = mjbiped.Compass3D(**SOLE), mjbiped.Disturbances(pushes=[(0.3, 1.0)], push_direction=SIDE)
    walk = golden_numbers.in_space("sole", engine)
    assert walk.outcome == "finished"
    assert np.abs(walk.samples["qpos"][:, robot.places.index("yaw")]).max() < math.radians(1.0)
    exact = walked(robot, LEVEL, engine, steps=1, disturbances=push)
    force = 1.3 * robot.weight  # the greatest that a step brings
    assert 0.5 * robot.weight * 0.04 < exact.peak_torque[-1] <= force * 0.04
    assert exact.touchdowns["sole_bound_time"][-1] > 0.0
    golden_numbers.check(f"sole in space in {engine}")


def test_passive_walks_keep_their_energy_and_mirror_themselves() -> None:
    robot = mjbiped.Compass3D()
    gait = mjbiped.find_gait_in_space(robot, math.radians(2.0))
    terrain, law = mjbiped.Terrain.incline(2.0), make_controller("passive", robot, {})
    engine = mjbiped.Hybrid(tolerance=1e-3)  # its steps are so short, 19 ms, that no tolerance is felt
    walk = mjbiped.walk(law, terrain, engine=engine, robot=robot, initial=gait.start, steps=1, sample_period=0.05)
    first = walk.samples["time"] < gait.period
    states = zip(walk.samples["q"][first], walk.samples["dq"][first], strict=True)
    energies = [robot.energy(q, dq, gait.slope) for q, dq in states]
    np.testing.assert_allclose(energies, energies[0], rtol=0, atol=1e-9)  # of the dense output
    np.testing.assert_allclose(walk.touchdowns["q"][0], gait.start[:3], rtol=0, atol=1e-11)
    np.testing.assert_allclose(abs(gait.multipliers), [16.030, 0.5078, 0.5078, 0.2912, 0.0667], rtol=1e-3)  # prototype


@pytest.mark.parametrize("robot", [mjbiped.Compass3D(), mjbiped.Kneed3D()], ids=["compass", "knees"])
def test_the_lyapunov_function_falls_as_in_the_plane(robot: InSpace) -> None:
    """dV_a/dt = -z_1' K_1 z_1 - z_2' K_2 z_2 for any error of the three estimates."""
    law: Any = make_controller("adaptive", robot, {})
    rng, n = np.random.default_rng(0), len(robot.angles)
    for _ in range(10):
        q, dq, t = rng.normal(0.0, 0.3, n), rng.normal(0.0, 1.0, n), rng.uniform(0.0, 0.7)
        memory = [0.0] * law.memory_size
        law.start(memory, q, dq)
        true = np.array([0.0, 1.0, 0.0]) + rng.normal(0.0, 0.1, 3)
        memory[:3] = (true + rng.normal(0.0, 0.2, 3)).tolist()
        out = np.array(law.torque(memory, t, q, dq))
        ddq = robot.in_space[n - 1].accelerations(robot.input_matrix @ out[:n], q, dq, true)
        target, rate, acceleration = law.reference(memory, t)
        z1, dz1, ddz1 = target - q, rate - dq, acceleration - ddq
        k1, k2 = law.position_gain, law.velocity_gain
        z2 = dz1 + k1 * z1
        change = z1 @ dz1 + z2 @ (ddz1 + k1 * dz1) + (np.array(memory[:3]) - true) @ out[n:] / law.adaptation_gain
        assert change == pytest.approx(-k1 * z1 @ z1 - k2 * z2 @ z2, rel=1e-9)


@each_engine
def test_a_record_tells_all_and_repeats_bit_by_bit(engine: str, tmp_path: Path) -> None:
    first, again = golden_numbers.in_space("knees", engine), golden_numbers.in_space.__wrapped__("knees", engine)
    first.save(tmp_path / "walk.npz")
    loaded = mjbiped.Walk.load(tmp_path / "walk.npz")
    assert loaded.robot == mjbiped.Kneed3D()
    assert first == again == loaded
    assert first.touchdowns["knee_strike"][0] == pytest.approx(0.89, abs=0.02)
    assert 0.4 < first.touchdowns["flexion"][0] < 1.0
    golden_numbers.check(f"knees in space in {engine}")


def test_what_is_not_for_a_robot_is_refused() -> None:
    space, plane = mjbiped.Compass3D(), mjbiped.Compass()
    noise = mjbiped.Disturbances(angle_noise=0.01)
    across = mjbiped.Disturbances(pushes=[(1.0, 1.0)], push_direction=1.0)
    for robot, disturbances, named in ((space, noise, "noise"), (plane, across, "push_direction")):
        with pytest.raises(mjbiped.InputError, match=named):
            mjbiped.walk(make_controller("adaptive", robot, {}), LEVEL, steps=1, disturbances=disturbances)
    with pytest.raises(mjbiped.InputError, match="gait in space"):
        make_controller("adaptive", space, {}, gait=mjbiped.find_passive_gait(plane, 0.03))
    with pytest.raises(mjbiped.InputError, match="eight finite numbers"):
        mjbiped.walk(make_controller("passive", space, {}), LEVEL, robot=mjbiped.Kneed3D(), initial=[0.0] * 7)


def test_a_fall_to_the_side_is_told() -> None:
    robot, push = mjbiped.Compass3D(**SOLE), mjbiped.Disturbances(pushes=[(0.3, 8.0)], push_direction=SIDE)
    walk = walked(robot, LEVEL, "hybrid", "bounded-ankle", disturbances=push, sample_period=0.02)
    assert walk.outcome == "fell"
    assert "to the left" in why_it_failed(walk)
