"""A controller that adds torques given from outside to those of another controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from mjbiped.control import machine_code
from mjbiped.control.compilation import MachineCode, compilable_law
from mjbiped.control.controller import Controller, Law, Memory
from mjbiped.control.machine_code import CompiledLaw

Pair = tuple[float, float]
"""Torques of ankle and hip, N m."""


class Parameters(NamedTuple):
    """Parameters of the laws of this module.

    Attributes:
        base: Machine code of the other controller's laws.
        place: Index in the memory of the torque added at the ankle; that at the hip follows.
        most: Greatest torque that is added, N m.
        peak: Greatest torque of the motors, N m.
    """

    base: CompiledLaw
    place: int
    most: Pair
    peak: Pair


@dataclass(frozen=True)
class DrivenController(Controller):
    """Adds the torques in the last two numbers of its memory to those of another controller.

    The environment writes them between two ticks. While they are zero, and the motors strong enough, the walk is
    bitwise that of the other controller.

    Attributes:
        base: The other controller; the first numbers of the memory are its own.
        most: Limits of the added ankle and hip torque, N m.
        peak: Limits of the motors at ankle and hip, to which the sum is clipped, N m.
    """

    base: Controller
    most: Pair
    peak: Pair

    def __post_init__(self) -> None:
        """Take over the other controller's states, memory, robot and gait."""
        own = {"states": self.base.states, "memory_size": self.base.memory_size + 2}
        for name, value in {**own, "robot": self.base.robot, "gait": self.base.gait}.items():
            object.__setattr__(self, name, value)

    @property
    def place(self) -> int:
        """Index in the memory of the torque added at the ankle."""
        return self.base.memory_size

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Start the other controller, with no torque added."""
        self.base.start(memory, q, dq)

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Inform the other controller."""
        self.base.on_touchdown(memory, q_before, q, dq)

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Add to the other controller's torques, and clip the sum to the motors' limits; see `Controller.torque`."""
        ankle, hip, *rates = self.base.torque(memory, t, q, dq)
        return (*_driven(memory, self.place, self.most, self.peak, ankle, hip), *rates)

    def slope_estimate(self, memory: Memory) -> float:
        """Slope estimate of the other controller, rad."""
        return self.base.slope_estimate(memory)

    @cached_property
    def _machine_code(self) -> MachineCode | None:
        """Machine code of the other controller's laws; None if they cannot be compiled."""
        law = compilable_law(self.base)
        if law is None:
            return None
        return MachineCode(law, len(self.base.states), self.base.memory_size, contract=False)

    def law(self) -> Law | None:
        """Functions for compilation; None if those of the other controller cannot be compiled."""
        if self._machine_code is None:
            return None
        parameters = Parameters(self._machine_code.law, self.place, self.most, self.peak)
        return Law(parameters, _torque, _touchdown, _slope_estimate, _next_discontinuity)

    def describe(self) -> dict[str, Any]:
        """Name, limits and the other controller's own description."""
        return {
            "name": type(self).__name__,
            "base": self.base.describe(),
            "most": list(self.most),
            "peak": list(self.peak),
        }

    def __getstate__(self) -> dict[str, Any]:
        """Return all attributes but the machine code, which belongs to this process."""
        return {name: value for name, value in self.__dict__.items() if name != "_machine_code"}


def _driven(memory: Memory, place: int, most: Pair, peak: Pair, ankle: float, hip: float) -> Pair:
    """Add the torques in the memory to those of ankle and hip, and clip both, N m."""
    return (
        _within(ankle + _within(memory[place], most[0]), peak[0]),
        _within(hip + _within(memory[place + 1], most[1]), peak[1]),
    )


def _within(value: float, limit: float) -> float:
    """Clip a number to a limit in both directions; NaN remains NaN."""
    if value > limit:
        return limit
    return -limit if value < -limit else value


def _torque(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, ...]:
    values = machine_code.torque(parameters.base, memory, t, (q1, q2), (dq1, dq2))
    driven = _driven(memory, parameters.place, parameters.most, parameters.peak, values[0], values[1])
    return driven + values[2:]


def _touchdown(
    parameters: Parameters,
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> None:
    machine_code.touchdown(parameters.base, memory, (q1_before, q2_before), (q1, q2), (dq1, dq2))


def _slope_estimate(parameters: Parameters, memory: Memory) -> float:
    return machine_code.slope_estimate(parameters.base, memory)


def _next_discontinuity(parameters: Parameters, memory: Memory, t: float) -> float:
    return machine_code.next_discontinuity(parameters.base, memory, t)
