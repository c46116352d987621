"""No control: the robot is moved by gravity alone."""

from __future__ import annotations

import copy
from dataclasses import dataclass

from mjbiped.control.controller import Controller, Law, LawController, Memory, Numbers, Room
from mjbiped.robots.robot import Robot


@dataclass(frozen=True)
class Unpowered(LawController):
    """Zero torque at all joints of any robot, for walks without a controller from `controllers`."""

    def driving(self, robot: Robot) -> Controller:
        """Return a copy of the controller with as many torques as the robot has joints."""
        if robot.joints == self.joints:
            return self
        driver = copy.copy(self)
        object.__setattr__(driver, "joints", robot.joints)
        return driver

    @classmethod
    def drives(cls, robot: Robot) -> bool:
        """Whether the robot has joints, which may be any: they are left alone."""
        return bool(robot.joints)

    @property
    def plain_law(self) -> Law:
        """Law that applies no torque in any state."""
        return Law([], _no_torque)


def _no_torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    for joint in range(len(q)):
        out[joint] = 0.0
