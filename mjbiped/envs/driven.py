"""A controller that adds torques given from outside to those of another controller."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from mjbiped.control.compiled import MachineCode, compilable_law
from mjbiped.control.controller import Controller, Law, Memory, Numbers, Room
from mjbiped.numerics.addresses import call, call_for_number

Torques = tuple[float, ...]
"""A torque for each joint with a motor, N m."""


_TORQUE, _TOUCHDOWN, _SLOPE_ESTIMATE, _NEXT_DISCONTINUITY, _KNEE_STRIKE, _RECORD, _PLACE, _LIMITS = range(8)
"""Indices in the parameters: addresses of the other controller's machine code, the index in the memory of the torque
added at the ankle, and the limits: of what is added, then of the motors, N m."""


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

    def start(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Start the other controller, with no torque added."""
        self.base.start(memory, q, dq)

    def on_touchdown(self, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
        """Inform the other controller."""
        self.base.on_touchdown(memory, q_before, q, dq)

    def on_knee_strike(self, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
        """Inform the other controller."""
        self.base.on_knee_strike(memory, t, q, dq)

    def torque(self, memory: Memory, t: float, q: Numbers, dq: Numbers) -> Numbers:
        """Add to the other controller's torques, and clip the sum to the motors' limits; see `Controller.torque`."""
        values = list(self.base.torque(memory, t, q, dq))
        _drive((*self.most, *self.peak), 0, memory, self.place, len(self.joints), values)
        return tuple(values)

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
        base = self._machine_code.law
        functions = base.torque, base.touchdown, base.slope_estimate, base.next_discontinuity, base.knee_strike
        parameters = [float(each) for each in (*functions, base.record, self.place, *self.most, *self.peak)]
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


def _drive(limits: Numbers, first: int, memory: Memory, place: int, joints: int, values: Room) -> None:
    """Add the torques in the memory to the first of some values, and clip them, N m; the other values stay.

    Args:
        limits: Numbers among which the limits stand, of what is added and of the motors, N m.
        first: Index of the first of them.
        memory: Of the controller.
        place: Index in it of the torque added at the ankle.
        joints: Number of joints.
        values: Torques, and rates of the states; changed.
    """
    for joint in range(joints):
        added = _within(memory[place + joint], limits[first + joint])
        values[joint] = _within(values[joint] + added, limits[first + joints + joint])


def _within(value: float, limit: float) -> float:
    """Clip a number to a limit in both directions; NaN remains NaN."""
    if value > limit:
        return limit
    return -limit if value < -limit else value


def _torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    call(int(parameters[_TORQUE]), (int(parameters[_RECORD]), memory, t, q, dq, out))
    _drive(parameters, _LIMITS, memory, int(parameters[_PLACE]), len(q), out)


def _touchdown(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    call(int(parameters[_TOUCHDOWN]), (int(parameters[_RECORD]), memory, q_before, q, dq))


def _knee_strike(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    call(int(parameters[_KNEE_STRIKE]), (int(parameters[_RECORD]), memory, t, q, dq))


def _slope_estimate(parameters: Numbers, memory: Memory) -> float:
    return float(call_for_number(int(parameters[_SLOPE_ESTIMATE]), (int(parameters[_RECORD]), memory)))


def _next_discontinuity(parameters: Numbers, memory: Memory, t: float) -> float:
    return float(call_for_number(int(parameters[_NEXT_DISCONTINUITY]), (int(parameters[_RECORD]), memory, t)))
