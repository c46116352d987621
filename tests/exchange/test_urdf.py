"""URDF in the parser of ROS, and in MuJoCo's own compiler of it."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from foreign_models import ROBOTS, addresses, mass_matrix_in, some_angles
from urdf_parser_py.urdf import URDF

import mjbiped
from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.engines.mujoco.scene import SMALLEST_HIP_MASS
from mjbiped.exchange.ros import export_urdf, urdf_of


@pytest.mark.parametrize("name", ROBOTS)
def test_mass_matrix_is_that_of_the_equations(name: str) -> None:
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
    assert read.get_chain("world", "right_shank", links=False) == ["hip_x", "hip_z", "right", "right_knee"]
    shank, knee = read.link_map["left_shank"], read.joint_map["left_knee"]
    assert (shank.inertial.mass, shank.inertial.inertia.iyy) == (1 / 7, robot.shank_inertia)
    assert shank.inertial.origin.xyz == [0.0, 0.0, -0.09]
    assert (knee.type, knee.origin.xyz, knee.limit.lower) == ("revolute", [0.0, 0.0, -0.5], 0.0)
    assert [each.geometry.length for each in shank.visuals if hasattr(each.geometry, "length")] == [0.5]
