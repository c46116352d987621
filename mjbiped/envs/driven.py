"""A controller that adds torques given from outside to those of another controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from mjbiped.control import machine_code
from mjbiped.control.compilation import MachineCode, compilable_law
from mjbiped.control.controller import Controller, Law, Memory
from mjbiped.control.machine_code import CompiledLaw, halves, thirds

Torques = tuple[float, ...]
"""A torque for each joint with a motor, N m."""


class Parameters(NamedTuple):
    """Parameters of the laws of this module.

    Attributes:
        base: Machine code of the other controller's laws.
        place: Index in the memory of the torque added at the ankle; those of the other joints follow.
        most: Greatest torque that is added, N m.
        peak: Greatest torque of the motors, N m.
    """

    base: CompiledLaw
    place: int
    most: Torques
    peak: Torques


@dataclass(frozen=True)
class DrivenController(Controller):
    """Adds the torques in the last numbers of its memory, one for each joint, to those of another controller.

    The environment writes them between two ticks. While they are zero, and the motors strong enough, the walk is
    bitwise that of the other controller.

    Attributes:
        base: The other controller; the first numbers of the memory are its own.
        most: Limits of the added torques, N m.
        peak: Limits of the motors, to which the sums are clipped, N m.
    """

    base: Controller
    most: Torques
    peak: Torques

    def __post_init__(self) -> None:
        """Take over the other controller's joints, states, memory, robot and gait."""
        own = {name: getattr(self.base, name) for name in ("joints", "states", "robot", "gait")}
        for name, value in {**own, "memory_size": self.base.memory_size + len(self.base.joints)}.items():
            object.__setattr__(self, name, value)

    @property
    def inner(self) -> Controller:
        """The other controller, as a disturbed loop names what is in it."""
        return self.base

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

    def on_knee_strike(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Inform the other controller."""
        self.base.on_knee_strike(memory, t, q, dq)

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Add to the other controller's torques, and clip the sum to the motors' limits; see `Controller.torque`."""
        return _driven(memory, self.place, self.most, self.peak, tuple(self.base.torque(memory, t, q, dq)))

    def slope_estimate(self, memory: Memory) -> float:
        """Slope estimate of the other controller, rad."""
        return self.base.slope_estimate(memory)

    @cached_property
    def _machine_code(self) -> MachineCode | None:
        """Machine code of the other controller's laws; None if they cannot be compiled."""
        law = compilable_law(self.base)
        if law is None:
            return None
        joints = len(self.joints)
        return MachineCode(law, len(self.base.states), self.base.memory_size, joints=joints)

    def law(self) -> Law | None:
        """Functions for compilation; None if those of the other controller cannot be compiled."""
        if self._machine_code is None:
            return None
        parameters = Parameters(self._machine_code.law, self.place, self.most, self.peak)
        return Law(parameters, _torque, _touchdown, _slope_estimate, _next_discontinuity, knee_strike=_knee_strike)

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


def _driven(memory: Memory, place: int, most: Torques, peak: Torques, values: Torques) -> Torques:
    """Add the torques in the memory to the first of some values, and clip them, N m; the other values stay."""
    ankle = _sum(memory, place, most, peak, values, 0)
    hip = _sum(memory, place, most, peak, values, 1)
    if len(most) == 2:
        return (ankle, hip) + values[2:]  # noqa: RUF005 (Numba knows no star here)
    return (ankle, hip, _sum(memory, place, most, peak, values, 2)) + values[3:]  # noqa: RUF005 (nor here)


def _sum(memory: Memory, place: int, most: Torques, peak: Torques, values: Torques, joint: int) -> float:
    """Torque of a joint, N m."""
    return _within(values[joint] + _within(memory[place + joint], most[joint]), peak[joint])


def _within(value: float, limit: float) -> float:
    """Clip a number to a limit in both directions; NaN remains NaN."""
    if value > limit:
        return limit
    return -limit if value < -limit else value


def _torque(parameters: Parameters, memory: Memory, t: float, *state: float) -> tuple[float, ...]:
    q, dq = halves(state)
    values = machine_code.torque(parameters.base, memory, t, q, dq)
    return _driven(memory, parameters.place, parameters.most, parameters.peak, values)


def _touchdown(parameters: Parameters, memory: Memory, *postures: float) -> None:
    q_before, q, dq = thirds(postures)
    machine_code.touchdown(parameters.base, memory, q_before, q, dq)


def _knee_strike(parameters: Parameters, memory: Memory, t: float, *state: float) -> None:
    q, dq = halves(state)
    machine_code.knee_strike(parameters.base, memory, t, q, dq)


def _slope_estimate(parameters: Parameters, memory: Memory) -> float:
    return machine_code.slope_estimate(parameters.base, memory)


def _next_discontinuity(parameters: Parameters, memory: Memory, t: float) -> float:
    return machine_code.next_discontinuity(parameters.base, memory, t)
