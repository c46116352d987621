"""No control, for every robot."""

from collections.abc import Sequence

import pytest

import mjbiped
from controllers import Memory, PassiveController
from mjbiped.control.controller import ROOM, Unpowered
from mjbiped.robots.robot import Robot


@pytest.mark.parametrize("robot", [mjbiped.Compass(), mjbiped.KneedBiped()])
def test_it_has_a_torque_for_each_joint_of_the_robot_that_it_drives(robot: Robot) -> None:
    driver = Unpowered().driving(robot)
    zeros = (0.0,) * len(robot.joints)
    assert driver.joints == robot.joints
    assert tuple(driver.torque([], 0.0, zeros, zeros)) == zeros
    law = driver.law()
    assert law is not None
    out = [1.0] * (len(zeros) + ROOM)
    law.torque(law.parameters, [], 0.0, zeros, zeros, out)
    assert tuple(out[: len(zeros)]) == zeros
    assert Unpowered().joints == mjbiped.Compass.joints


def test_a_law_of_ones_own_that_is_derived_from_it_drives_knees_too() -> None:
    class HipSpring(PassiveController):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return 0.0, -1.0 * (q[1] - q[0]), 0.0

    ground = mjbiped.Terrain.incline(2.5)
    robot = mjbiped.KneedBiped()
    walk = mjbiped.walk(HipSpring(), ground, robot=robot, engine="hybrid", steps=1, initial="gait")
    assert walk.peak_torque[1] > 0.1
