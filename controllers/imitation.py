"""What controllers have in common that imitate a passive gait: a robot and a gait, and laws of plain numbers."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from mjbiped.errors import InputError
from mjbiped.gaits.passive import Gait
from mjbiped.robots.compass import Compass

Parameters = TypeVar("Parameters")

if TYPE_CHECKING:
    from controllers.adaptive import AdaptiveController
    from controllers.comparison.known_slope import KnownSlopeController

    Imitating: TypeAlias = AdaptiveController | KnownSlopeController


def check_imitation(controller: Imitating) -> None:
    """Refuse a controller whose robot or gait is none.

    Raises:
        InputError: One is not.
    """
    if not isinstance(controller.robot, Compass) or not isinstance(controller.gait, Gait):
        raise InputError(
            f"{type(controller).__name__} needs a mjbiped.Compass and a mjbiped.Gait (see mjbiped.find_passive_gait), "
            f"got {type(controller.robot).__name__} and {type(controller.gait).__name__}"
        )


def parameters_of(kind: Callable[..., Parameters], controller: Imitating, **others: Any) -> Parameters:
    """The parameters that a controller's laws take, in plain numbers.

    Args:
        kind: Their NamedTuple. Its fields have the names of the controller's, or are `constants` of the robot model,
            `imitated_slope` (rad), `energy` (J) and `table` of the gait.
        controller: As checked.
        others: Values of all other fields.
    """
    gait = controller.gait
    imitated = {"imitated_slope": float(gait.slope), "energy": gait.energy, "table": gait.table}
    values = {**vars(controller), "constants": controller.robot.constants, **imitated, **others}
    return kind(**{name: values[name] for name in signature(kind).parameters})
