"""No control: the robot is moved by gravity alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from mjbiped.control.controller import Controller, Law, Memory, never


@dataclass(frozen=True)
class Unpowered(Controller):
    """Zero torque at ankle and hip, for walks that no controller of `controllers` is asked for."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """No torque, whatever the state; see `Controller.torque`."""
        return 0.0, 0.0

    def law(self) -> Law:
        """The same for compilation; see `Controller.law`."""
        return Law((), _no_torque, _nothing_new, _no_estimate, never)


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


def _no_estimate(parameters: tuple[()], memory: Memory) -> float:
    return math.nan
