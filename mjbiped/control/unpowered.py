"""No control: the robot is moved by gravity alone."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from mjbiped.control.controller import Controller, Law, LawController, Memory, never
from mjbiped.robots.robot import Robot


@dataclass(frozen=True)
class Unpowered(LawController):
    """Zero torque at all joints of any robot, for walks without a controller from `controllers`."""

    def driving(self, robot: Robot) -> Controller:
        """A copy of the controller with as many torques as the robot has joints."""
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
        """The law of no torque, whatever the state."""
        zeros = (0.0,) * len(self.joints)
        return Law(zeros, _no_torque, _no_notice, _no_estimate, never, knee_strike=_no_notice)


def _no_torque(zeros: tuple[float, ...], memory: Memory, t: float, *state: float) -> tuple[float, ...]:
    return zeros


def _no_notice(zeros: tuple[float, ...], memory: Memory, *state: float) -> None:
    pass


def _no_estimate(zeros: tuple[float, ...], memory: Memory) -> float:
    return math.nan
