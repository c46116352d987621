"""No control: the robot is moved by gravity alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from mjbiped.control.controller import Controller, Law, Memory, never
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot


@dataclass(frozen=True)
class Unpowered(Controller):
    """Zero torque at all joints, for walks that no controller of `controllers` is asked for."""

    def driving(self, robot: Robot) -> Controller:
        """The same for any robot."""
        return UnpoweredKnees() if robot.knees else self

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """No torque, whatever the state; see `Controller.torque`."""
        return 0.0, 0.0

    def law(self) -> Law:
        """The same for compilation; see `Controller.law`."""
        return Law((), _no_torque, _nothing_new, _no_estimate, never)


@dataclass(frozen=True)
class UnpoweredKnees(Controller):
    """Zero torque at ankle, hip and swing knee: `Unpowered` for a robot with knees."""

    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """No torque, whatever the state; see `Controller.torque`."""
        return 0.0, 0.0, 0.0

    def law(self) -> Law:
        """The same for compilation; see `Controller.law`."""
        return Law((), _no_torque_knees, _nothing_new_knees, _no_estimate, never, knee_strike=_no_strike)


def _no_torque(
    parameters: tuple[()], memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float]:
    return 0.0, 0.0


def _nothing_new(
    parameters: tuple[()],
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> None:
    pass


def _no_torque_knees(
    parameters: tuple[()], memory: Memory, t: float, q1: float, q2: float, q3: float, dq1: float, dq2: float, dq3: float
) -> tuple[float, float, float]:
    return 0.0, 0.0, 0.0


def _nothing_new_knees(
    parameters: tuple[()],
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q3_before: float,
    q1: float,
    q2: float,
    q3: float,
    dq1: float,
    dq2: float,
    dq3: float,
) -> None:
    pass


def _no_strike(
    parameters: tuple[()], memory: Memory, t: float, q1: float, q2: float, q3: float, dq1: float, dq2: float, dq3: float
) -> None:
    pass


def _no_estimate(parameters: tuple[()], memory: Memory) -> float:
    return math.nan
