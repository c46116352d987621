"""The adaptive controller with two references: an economical one, and one that climbs where the ground is uneven."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar, NamedTuple

from mjbiped.control.controller import Law, Memory
from mjbiped.controllers import adaptive
from mjbiped.controllers.adaptive import AdaptiveController
from mjbiped.controllers.gait_library import GaitLibrary, Switch, count_steps
from mjbiped.controllers.slope_estimator import slope_estimate_law
from mjbiped.utils import domains

_CLIMBING = AdaptiveController.memory_size
"""Index in the memory of the number of steps left with the climbing gait, this one included."""


class Parameters(NamedTuple):
    """Parameters of the laws of this module.

    Attributes:
        economical: Parameters of the adaptive laws with the economical gait.
        climbing: Parameters of the adaptive laws with the climbing gait.
        switch: When the one takes the place of the other.
    """

    economical: adaptive.Parameters
    climbing: adaptive.Parameters
    switch: Switch


@dataclass(frozen=True)
class LibraryController(GaitLibrary, AdaptiveController):
    """Walks as `AdaptiveController`, with one of two gaits: see `GaitLibrary`. A step down counts as one up does.

    The first step up is met with the economical gait: what that one cannot climb, this controller cannot either.

    Attributes:
        gait: The economical gait.
        climbing_clearance: See `GaitLibrary`, as for the attributes of the climbing gait, and `AdaptiveController` for
            the others.
    """

    climbing_clearance: Annotated[float, domains.CLEARANCE] = 0.1
    height_threshold: Annotated[float, domains.CLEARANCE] = 0.005

    lifts_after_drop: ClassVar[bool] = True
    memory_size: ClassVar[int] = _CLIMBING + 1
    with_knees: ClassVar[str | None] = None

    @cached_property
    def library(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        return Parameters(self.parameters, self.climbing.parameters, self.switch)

    def parameters_of(self, memory: Memory) -> adaptive.Parameters:
        """Return the parameters of the gait with which the current step is made."""
        return _of_step(self.library, memory)

    @cached_property
    def plain_law(self) -> Law:
        """The laws of `AdaptiveController`, with the gait of the step; see `LawController.plain_law`."""
        return Law(self.library, _torque, _touchdown, slope_estimate_law, _next_discontinuity)


def _of_step(parameters: Parameters, memory: Memory) -> adaptive.Parameters:
    """Parameters of the gait with which the current step is made."""
    return parameters.climbing if memory[_CLIMBING] > 0.0 else parameters.economical


def _torque(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float, float]:
    return adaptive.torque_law(_of_step(parameters, memory), memory, t, q1, q2, dq1, dq2)


def _touchdown(
    parameters: Parameters, memory: Memory, before1: float, before2: float, q1: float, q2: float, dq1: float, dq2: float
) -> None:
    count_steps(parameters.switch, memory, _CLIMBING, before1, before2)
    adaptive.touchdown_law(_of_step(parameters, memory), memory, before1, before2, q1, q2, dq1, dq2)


def _next_discontinuity(parameters: Parameters, memory: Memory, t: float) -> float:
    return adaptive.next_discontinuity_law(_of_step(parameters, memory), memory, t)
