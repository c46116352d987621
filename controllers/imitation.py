"""What controllers have in common that imitate a gait: a robot model and a gait."""

from __future__ import annotations

from mjbiped.control.controller import Controller
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.robots.compass import Compass


def check_imitation(controller: Controller, *, passive: bool = False) -> None:
    """Refuse a controller whose robot or gait is none.

    Args:
        controller: To be checked.
        passive: Whether its law imitates the passive motion itself, and so needs a gait that has one.

    Raises:
        InputError: One is not.
    """
    if not isinstance(controller.robot, Compass) or not isinstance(controller.gait, Gait):
        raise InputError(
            f"{type(controller).__name__} needs a mjbiped.Compass and a mjbiped.Gait (see mjbiped.find_passive_gait), "
            f"got {type(controller.robot).__name__} and {type(controller.gait).__name__}"
        )
    if passive and not isinstance(controller.gait, PassiveGait):
        raise InputError(
            f"{type(controller).__name__} imitates how a passive walker's energy goes, and needs a passive gait (see "
            "mjbiped.find_passive_gait); an optimised reference is tracked by controllers that follow it in time, as "
            "AdaptiveController and LimitCycleController"
        )
