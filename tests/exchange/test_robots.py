"""Exported scenes and URDF in plain MuJoCo and in the parser of ROS, without any of this package's callbacks."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from foreign_models import DOWNHILL, LEVEL, ROBOTS, addresses, mass_matrix_in, some_angles
from numpy.typing import NDArray
from urdf_parser_py.urdf import URDF

import mjbiped
from controllers import PassiveController
from mjbiped.control.controller import Unpowered
from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.engines.mujoco.scene import SMALLEST_HIP_MASS
from mjbiped.exchange.mjcf import START, TIMESTEP, export_scene
from mjbiped.exchange.ros import export_urdf, urdf_of
from mjbiped.gaits.described import passive_gait_of
from mjbiped.robots.robot import Robot

NAMES = ["compass", "kneed", pytest.param("wheel", marks=pytest.mark.slow)]  # which compiles engines of its own


def exported(folder: Path, robot: Robot, terrain: mjbiped.Terrain, **given: Any) -> tuple[Any, Any]:
    """An exported scene as plain MuJoCo opens it, of its text alone, at its start."""
    path = folder / "scene.xml"
    export_scene(robot, terrain, path, **given)
    model = mujoco.MjModel.from_xml_string(path.read_text(encoding="utf-8"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(START).id)
    return model, data


@pytest.mark.parametrize("name", ROBOTS)
def test_mass_matrix_in_scenes(name: str, tmp_path: Path) -> None:
    robot = ROBOTS[name]
    model, _ = exported(tmp_path, robot, LEVEL, initial="rest")
    seen = robot
    if isinstance(robot, mjbiped.Compass) and not robot.hip_mass:  # MuJoCo has no body without mass
        seen = dataclasses.replace(robot, hip_mass=SMALLEST_HIP_MASS * robot.total_mass)
    if isinstance(robot, mjbiped.RimlessWheel):
        seen = dataclasses.replace(robot, mass=robot.mass * (1 + SMALLEST_HIP_MASS))
    for q in some_angles(robot):
        # rounding: entries are sums of some ten products of numbers with 16 digits
        assert mass_matrix_in(model, robot, q) == pytest.approx(seen.mass_matrix(q), rel=1e-12, abs=1e-12)


def postures(model: Any, data: Any, robot: Robot, times: NDArray[np.float64], halved: int) -> NDArray[np.float64]:
    """Postures at given times in plain steps of TIMESTEP / halved."""
    length = TIMESTEP / halved
    model.opt.timestep = length
    for damped in (model.geom_solref, model.jnt_solref, model.eq_solref):
        damped[damped[:, 1] < -1.0, 1] = -1.0 / length  # as the file's comment says
    seen = []
    for time in times:
        mujoco.mj_step(model, data, nstep=round((time - data.time) / length))
        seen.append(data.qpos[addresses(model, robot)].copy())
    return np.array(seen)


@pytest.mark.parametrize("name", NAMES)
def test_passive_step_is_that_of_the_engine(name: str, tmp_path: Path) -> None:
    robot, slope_deg = DOWNHILL[name]
    terrain = mjbiped.Terrain.incline(slope_deg)
    walk = mjbiped.walk(Unpowered(), terrain, steps=2, robot=robot)
    touchdown = walk.touchdowns["time"][0]
    swing = walk.samples["time"] < touchdown
    times, expected = walk.samples["time"][swing][::10], walk.samples["qpos"][swing][::10]
    whole, halved = (postures(*exported(tmp_path, robot, terrain), robot, times, n) for n in (1, 2))
    # In plain steps the foot, a sphere, rolls by its radius times the leg's turn, which an inverted pendulum lets grow.
    leg = expected[:, 2]
    growth = np.exp(np.sqrt(robot.gravity / robot.leg_length) * times[-1])
    rolled = FOOT_RADIUS * np.ptp(leg) * growth
    # Euler's steps are of first order: halving them takes away half of the error, and twice that leaves none.
    halving = np.abs(whole - halved).max()
    assert np.abs(whole - expected).max() < 2.2 * halving + rolled
    assert np.abs(2.0 * halved - whole - expected).max() < 2.0 * rolled  # a swing shank turns more than the leg
    assert np.abs(whole - expected).max() < 0.02 * np.ptp(leg)


def test_first_states_are_those_of_walks(tmp_path: Path) -> None:
    walk = mjbiped.walk(Unpowered(), mjbiped.Terrain.incline(2.0), steps=1)
    _, data = exported(tmp_path, walk.robot, walk.terrain, initial=walk.settings["initial"])
    assert data.qpos == pytest.approx(walk.samples["qpos"][0], abs=1e-15)
    with pytest.raises(mjbiped.InputError, match="four finite numbers q1, q2, dq1, dq2"):
        exported(tmp_path, walk.robot, walk.terrain, initial=[0.0])
    with pytest.raises(mjbiped.InputError, match=r"ends at x = 0\.1 m"):
        exported(tmp_path, walk.robot, dataclasses.replace(LEVEL, end=0.1), initial="rest")
    with pytest.raises(mjbiped.GaitError, match="--initial rest"):
        exported(tmp_path, mjbiped.RimlessWheel(), LEVEL)


def test_straight_legs_land_from_the_reach_of_the_scuffing_rule_on(tmp_path: Path) -> None:
    """On samples at equal distances too, which share heightfields."""
    file = tmp_path / "trail.csv"
    file.write_text("".join(f"{k * 0.1 - 2:.1f},{0.002 * (k % 2)}\n" for k in range(60)))
    model, _ = exported(tmp_path, mjbiped.Compass(), mjbiped.Terrain.from_file(file), initial="rest")
    behind = [model.geom(k) for k in range(model.ngeom) if model.geom(k).conaffinity[0] == 1]
    ahead = [model.geom(k) for k in range(model.ngeom) if model.geom(k).conaffinity[0] == 3]
    assert max(geom.pos[0] + geom.size[0] for geom in behind if geom.name.startswith("ground")) < 0.2 + 1e-9
    assert min(geom.pos[0] - geom.size[0] for geom in ahead) > 0.2 - 1e-9
    assert model.geom("left_foot").contype[0] == 1
    assert model.geom("right_foot").contype[0] == 2


@pytest.mark.parametrize("robot", [mjbiped.Compass3D(), mjbiped.Kneed3D()], ids=lambda robot: robot.kind)
def test_a_scene_in_space_moves_as_the_equations_do(robot: Robot, tmp_path: Path) -> None:
    start = passive_gait_of(robot, math.radians(2.0)).start.tolist()
    model, data = exported(tmp_path, robot, LEVEL, initial=start)
    given: Any = {"robot": robot, "engine": "hybrid", "initial": start, "steps": 1, "sample_period": 0.1}
    walked = mjbiped.walk(PassiveController(), LEVEL, **given)
    mujoco.mj_step(model, data, 2000)
    qpos = [float(data.joint(name).qpos[0]) for name in robot.places]
    assert qpos == pytest.approx(walked.samples["qpos"][2].tolist(), abs=2e-4)


@pytest.mark.parametrize("name", ROBOTS)
def test_mass_matrix_in_urdf(name: str) -> None:
    robot = ROBOTS[name]
    model = mujoco.MjModel.from_xml_string(urdf_of(robot))
    # slider and hip without mass have so much of the robot's, which are at the hip
    added = 2 * SMALLEST_HIP_MASS * robot.total_mass * robot.leg_length**2
    for q in some_angles(robot):
        assert mass_matrix_in(model, robot, q) == pytest.approx(robot.mass_matrix(q), rel=1e-12, abs=added)


@pytest.mark.parametrize("name", ROBOTS)
def test_feet_are_where_the_robot_has_them(name: str) -> None:
    robot = ROBOTS[name]
    model = mujoco.MjModel.from_xml_string(urdf_of(robot))
    data = mujoco.MjData(model)
    q = np.random.default_rng(1).uniform(0.1, 0.5, len(robot.places))
    data.qpos[addresses(model, robot)] = q
    mujoco.mj_forward(model, data)
    upper, ends = np.moveaxis(robot.limbs(q)[:, -2:], 1, 0)
    centres = ends + robot.radius / robot.bodies.leg[-1].length * (upper - ends)
    assert data.geom_xpos[:, [0, 2]] == pytest.approx(centres, abs=1e-12)
    assert model.geom_size[:, 0].tolist() == [robot.radius + FOOT_RADIUS] * len(robot.bodies.limbs)


def test_parser_of_ros_reads_the_tree(tmp_path: Path) -> None:
    robot = mjbiped.KneedBiped(shank_mass=1 / 7)
    export_urdf(robot, tmp_path / "kneed.urdf")
    read = URDF.from_xml_string((tmp_path / "kneed.urdf").read_bytes())
    assert (read.name, read.get_root()) == ("mjbiped_kneed", "world")
    assert sorted(read.joint_map) == sorted(robot.places)
    shank, knee = read.link_map["left_shank"], read.joint_map["left_knee"]
    assert (shank.inertial.mass, shank.inertial.inertia.iyy) == (1 / 7, robot.shank_inertia)
    assert (knee.type, knee.origin.xyz, knee.limit.lower) == ("revolute", [0.0, 0.0, -0.5], 0.0)
