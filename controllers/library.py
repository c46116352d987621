"""The adaptive controller with two references: an economical one, and one that climbs where the ground is uneven."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Annotated, ClassVar, NamedTuple

from controllers import adaptive
from controllers.adaptive import AdaptiveController
from controllers.slope_estimator import slope_estimate_law
from mjbiped.control.controller import Law, Memory
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.optimised import find_reference
from mjbiped.robots import compass
from mjbiped.utils import domains

_CLIMBING = AdaptiveController.memory_size
"""Index in the memory of the number of steps left with the climbing gait, this one included."""


class Parameters(NamedTuple):
    """Parameters of the laws of this module.

    Attributes:
        economical: Parameters of the adaptive laws with the economical gait.
        climbing: Parameters of the adaptive laws with the climbing gait.
        length: Leg length, m.
        threshold: Height change above which the ground counts as uneven, m.
        steps: Number of steps made with the climbing gait after such a change.
    """

    economical: adaptive.Parameters
    climbing: adaptive.Parameters
    length: float
    threshold: float
    steps: float


@dataclass(frozen=True)
class LibraryController(AdaptiveController):
    r"""Walks economically on even ground, and lifts its feet where it has felt a step.

    At touchdown both feet are on the ground, and the legs' angles tell by how much the new foothold is higher than the
    old one, along the normal of the ground under the old one:

    .. math:: \Delta = l \, (\cos q_1^- - \cos q_2^-)

    Where that is more than a threshold, up or down, the next steps are made with a gait of more clearance; after the
    last of them the economical one returns. The re-planning, additive by default, leads from one gait to the other.

    The first step up is met with the economical gait: what that one cannot climb, this controller cannot either.

    Attributes:
        gait: The economical gait.
        climbing_gait: The climbing gait; unless given, the optimised reference of the economical one's speed and of
            `climbing_clearance`.
        climbing_clearance: Clearance of that reference, m; see `mjbiped.find_reference`.
        climbing_steps: Number of steps made with the climbing gait after a height change.
        height_threshold: Height change that counts, m.
        replanning: See `AdaptiveController`, as for all attributes not named here.
    """

    replanning: str = "additive"
    climbing_clearance: Annotated[float, domains.CLEARANCE] = 0.1
    climbing_steps: Annotated[int, domains.STEPS] = 5
    height_threshold: Annotated[float, domains.CLEARANCE] = 0.005
    climbing_gait: Gait | None = None

    memory_size: ClassVar[int] = _CLIMBING + 1
    with_knees: ClassVar[str | None] = None

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain, and find the climbing gait.

        Raises:
            InputError: One is; see `mjbiped.utils.domains`.
            GaitError: There is no such climbing gait.
        """
        super().__post_init__()
        if self.climbing_gait is None:
            found = find_reference(self.gait.robot, speed=self.gait.speed, clearance=self.climbing_clearance)
            object.__setattr__(self, "climbing_gait", found)
        self._with(self.climbing_gait)  # refuses what is no gait

    @cached_property
    def library(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        return Parameters(
            economical=self.parameters,
            climbing=self._with(self.climbing_gait).parameters,
            length=self.robot.leg_length,
            threshold=self.height_threshold,
            steps=float(self.climbing_steps),
        )

    def parameters_of(self, memory: Memory) -> adaptive.Parameters:
        """Return the parameters of the gait with which the current step is made."""
        return _of_step(self.library, memory)

    @cached_property
    def plain_law(self) -> Law:
        """The laws of `AdaptiveController`, with the gait of the step; see `LawController.plain_law`."""
        return Law(self.library, _torque, _touchdown, slope_estimate_law, _next_discontinuity)

    def _with(self, gait: Gait | None) -> AdaptiveController:
        """Make the adaptive controller of one gait."""
        given = {each.name: getattr(self, each.name) for each in fields(AdaptiveController)}
        return AdaptiveController(**{**given, "gait": gait})


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
    _, change = compass.swing_foot(parameters.length, compass.legs_of(before1, before2))
    if abs(change) > parameters.threshold:
        memory[_CLIMBING] = parameters.steps
    elif memory[_CLIMBING] > 0.0:
        memory[_CLIMBING] -= 1.0
    adaptive.touchdown_law(_of_step(parameters, memory), memory, before1, before2, q1, q2, dq1, dq2)


def _next_discontinuity(parameters: Parameters, memory: Memory, t: float) -> float:
    return adaptive.next_discontinuity_law(_of_step(parameters, memory), memory, t)
