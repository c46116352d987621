"""A controller that adds torques given from outside to those of another controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from mjbiped.control.controller import Controller, Law, Memory, Numbers, Room, never
from mjbiped.control.functions import in_python
from mjbiped.disturbances.loop import Around, law_at, limited, slope_estimate
from mjbiped.numerics.blocks import call, numbers

Torques = tuple[float, ...]
"""A torque for each joint with a motor, N m."""


class Added(NamedTuple):
    """Parameters of the law.

    Attributes:
        inner: The law of the other controller.
        place: Index in the memory of the torque added at the ankle.
        joints: Number of joints.
        most: Limits of the added torques, N m.
        peak: Limits of the motors, N m.
    """

    inner: Sequence[Law]
    place: int
    joints: int
    most: Numbers
    peak: Numbers


@dataclass(frozen=True)
class DrivenController(Around):
    """Adds torques to those of another controller: the last numbers of its memory, one for each joint.

    The environment writes the added torques between two ticks. If they are zero and no motor reaches its limit, the
    walk is bitwise that of the other controller.

    Attributes:
        inner: The other controller; the first numbers of the memory are its own.
        most: Limits of the added torques, N m.
        peak: Limits of the motors, to which the sums are clipped, N m.
    """

    inner: Controller = field()
    most: Torques
    peak: Torques

    def __post_init__(self) -> None:
        """Take over the other controller's joints, states, memory, robot and gait."""
        self._surround(self.inner, len(self.inner.joints))

    @property
    def place(self) -> int:
        """Index in the memory of the torque added at the ankle."""
        return self.inner.memory_size

    @cached_property
    def plain_law(self) -> Law:
        """Add to the other controller's torques, and clip the sum to the motors' limits."""
        parameters: Any = Added([in_python(self.inner)], self.place, len(self.joints), self.most, self.peak)
        return Law(parameters, _torque, _touchdown, slope_estimate, never, None, _knee_strike)

    def describe(self) -> dict[str, object]:
        """Name, limits and the other controller's own description."""
        limits = {"most": list(self.most), "peak": list(self.peak)}
        return {"name": type(self).__name__, "base": self.inner.describe(), **limits}


def _torque(added: Added, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    law, joints = law_at(added.inner, 0), added.joints
    most, peak = numbers(added.most, joints), numbers(added.peak, joints)
    call(law.torque, law.parameters, memory, t, q, dq, out)
    for joint in range(joints):
        more = limited(memory[added.place + joint], most[joint])
        out[joint] = limited(out[joint] + more, peak[joint])


def _touchdown(added: Added, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    law = law_at(added.inner, 0)
    call(law.touchdown, law.parameters, memory, q_before, q, dq)


def _knee_strike(added: Added, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    law = law_at(added.inner, 0)
    call(law.knee_strike, law.parameters, memory, t, q, dq)
