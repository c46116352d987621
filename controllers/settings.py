"""Settings of the paper's adaptive controller for any robot, and the check of a compass biped and its gait."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple

from mjbiped.control.controller import Controller, LawController, Memory, check_tracking
from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Gait, Periodic
from mjbiped.gaits.passive import PassiveGait
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains

SIN, COS, REPLANNED = 0, 1, 2
"""Indices in the memory of the estimates of the slope's sine and cosine, and of whether the step is re-planned."""

REPLANNINGS = ("paper", "additive")
"""Values of `PaperSettings.replanning`."""


class Gains(NamedTuple):
    """Gains and switches of the law as plain numbers; see `PaperSettings`.

    Attributes:
        position: K1, 1/s.
        velocity: K2, 1/s.
        adaptation: gamma.
        transition_time: t_c = zeta T, s; 0 where re-planning is off.
        additive: Whether the transition is added to the gait, or leads to it in its stead.
        estimate_update: Whether (27) acts.
        update_threshold: epsilon of (27), rad.
        replanning_threshold: Distance from the limit cycle beyond which a step is re-planned, rad and rad/s.
        imitated_slope: phi_r, rad.
    """

    position: float
    velocity: float
    adaptation: float
    transition_time: float
    additive: bool
    estimate_update: bool
    update_threshold: float
    replanning_threshold: float
    imitated_slope: float


@dataclass(frozen=True)
class PaperSettings(LawController):
    """Gains and switches of the paper's law, with the checks of their domains.

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated.
        position_gain: K1 = diag(k, k), 1/s.
        velocity_gain: K2 = diag(k, k), 1/s.
        adaptation_gain: gamma_1 = gamma_2.
        replanning_delay: zeta in (0, 1], the transition's time in gait periods; None switches re-planning off.
        replanning: "paper": the curve leads from the measured state to the gait, in its stead. "additive": it leads
            from the measured state's distance from the gait to zero, and is added to the gait, so that the clearance
            of the gait's swing foot is not lost.
        estimate_update: Whether (27) corrects the estimate at touchdown.
        update_threshold: epsilon of (27), rad. The paper gives no number.
        replanning_threshold: A step is re-planned when one of its first angles (rad) or rates (rad/s) is further than
            this from the limit cycle. Above the error of a simulated impact (some 5e-3 rad/s), so that walking on
            constant ground is never re-planned. A slope change of 1 degree brings 1.3e-2 to 4.7e-2, by where between
            the feet the corner lies, and always is; one of 0.3 degrees brings 0.4e-2 to 1.4e-2, and mostly is not.
        initial_slope_estimate: Estimate at the walk's start, rad.
    """

    robot: Robot
    gait: Periodic
    position_gain: Annotated[float, domains.GAIN] = 5.0
    velocity_gain: Annotated[float, domains.GAIN] = 12.0
    adaptation_gain: Annotated[float, domains.ADAPTATION_GAIN] = 0.3
    replanning_delay: Annotated[float | None, domains.REPLANNING_DELAY] = 0.8
    estimate_update: bool = True
    update_threshold: Annotated[float, domains.SLOPE_THRESHOLD] = 2e-3
    replanning_threshold: Annotated[float, domains.STATE_THRESHOLD] = 1e-2
    initial_slope_estimate: Annotated[float, domains.SLOPE] = 0.0
    replanning: str = "paper"

    states: ClassVar[tuple[str, ...]] = ("sin_slope_estimate", "cos_slope_estimate")

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain.

        Raises:
            InputError: One is; see `mjbiped.utils.domains`.
        """
        domains.check_fields(self)
        domains.known_name("replanning", self.replanning, REPLANNINGS)
        self.check_imitated()
        if not isinstance(self.estimate_update, bool):
            raise InputError(f"estimate_update = {shown(self.estimate_update)}: must be True or False")

    @abstractmethod
    def check_imitated(self) -> None:
        """Refuse a robot or a gait that the law is not made for.

        Raises:
            InputError: One is not.
        """

    @cached_property
    def gains(self) -> Gains:
        """Gains and switches in plain numbers, as the laws take them."""
        return Gains(
            position=self.position_gain,
            velocity=self.velocity_gain,
            adaptation=self.adaptation_gain,
            transition_time=float((self.replanning_delay or 0.0) * self.gait.period),
            additive=self.replanning == "additive",
            estimate_update=self.estimate_update,
            update_threshold=self.update_threshold,
            replanning_threshold=self.replanning_threshold,
            imitated_slope=float(self.gait.slope),
        )

    @property
    @abstractmethod
    def parameters(self) -> Any:
        """Parameters of the laws: the attributes in plain numbers."""

    def parameters_of(self, memory: Memory) -> Any:
        """Return the parameters that act in the current step; by default they are the same in all steps."""
        return self.parameters

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the initial estimate, and plan the transition from the first state to the limit cycle."""
        memory[SIN], memory[COS] = math.sin(self.initial_slope_estimate), math.cos(self.initial_slope_estimate)
        self.plan_first_step(memory, q, dq)

    @abstractmethod
    def plan_first_step(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Lay the transition curves where the walk starts off the limit cycle."""

    def transition_end(self, memory: Memory) -> float:
        """Time at which the re-planned transition of the step ends, s; 0 where the step was not re-planned."""
        return float(self.parameters_of(memory).gains.transition_time) if memory[REPLANNED] else 0.0


def check_imitation(controller: Controller) -> None:
    """Refuse a controller whose robot or gait is not a compass biped's, or whose law needs a passive gait.

    Args:
        controller: The controller.

    Raises:
        InputError: Its robot or gait is of another kind.
    """
    robot, gait = controller.robot, controller.gait
    if not isinstance(robot, Compass) or not isinstance(gait, Gait) or not isinstance(gait.robot, Compass):
        of = f" of a {type(gait.robot).__name__}" if isinstance(gait, Gait) else ""
        raise InputError(
            f"{type(controller).__name__} needs a mjbiped.Compass and a mjbiped.Gait of one (see "
            f"mjbiped.find_passive_gait), got {type(robot).__name__} and {type(gait).__name__}{of}"
        )
    if not isinstance(controller.gait, PassiveGait):
        check_tracking(type(controller))
