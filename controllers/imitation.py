"""What controllers have in common that imitate a passive gait: a robot model and a gait."""

from __future__ import annotations

from mjbiped.control.controller import Controller
from mjbiped.errors import InputError
from mjbiped.gaits.passive import Gait
from mjbiped.robots.compass import Compass


def check_imitation(controller: Controller) -> None:
    """Refuse a controller whose robot or gait is none.

    Raises:
        InputError: One is not.
    """
    if not isinstance(controller.robot, Compass) or not isinstance(controller.gait, Gait):
        raise InputError(
            f"{type(controller).__name__} needs a mjbiped.Compass and a mjbiped.Gait (see mjbiped.find_passive_gait), "
            f"got {type(controller.robot).__name__} and {type(controller.gait).__name__}"
        )
