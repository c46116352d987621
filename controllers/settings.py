"""What the paper's adaptive controller is set by, for any robot."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from controllers.slope_estimator import slope_of
from mjbiped.control.controller import Controller, Memory
from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Periodic
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains

SIN, COS = 0, 1
"""Indices of the estimates in the memory."""

REPLANNINGS = ("paper", "additive")
"""Values of `PaperSettings.replanning`."""


@dataclass(frozen=True)
class PaperSettings(Controller):
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
    position_gain: float = 5.0
    velocity_gain: float = 12.0
    adaptation_gain: float = 0.3
    replanning_delay: float | None = 0.8
    estimate_update: bool = True
    update_threshold: float = 2e-3
    replanning_threshold: float = 1e-2
    initial_slope_estimate: float = 0.0
    replanning: str = "paper"

    states: ClassVar[tuple[str, ...]] = ("sin_slope_estimate", "cos_slope_estimate")

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain.

        Raises:
            InputError: One is; see `mjbiped.utils.domains`.
        """
        domains.check_fields(
            self,
            position_gain=domains.GAIN,
            velocity_gain=domains.GAIN,
            adaptation_gain=domains.ADAPTATION_GAIN,
            update_threshold=domains.SLOPE_THRESHOLD,
            replanning_threshold=domains.STATE_THRESHOLD,
            initial_slope_estimate=domains.SLOPE,
        )
        if self.replanning_delay is not None:
            domains.check_fields(self, replanning_delay=domains.REPLANNING_DELAY)
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

    def slope_estimate(self, memory: Memory) -> float:
        """Slope estimate arcsin(s), rad."""
        return slope_of(memory[SIN])
