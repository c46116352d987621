"""Calls of a controller's methods by the signatures of compiled laws, which `mjbiped.control.machine_code` calls.

Angles q and rates dq are tuples, with a number for each of the robot's angles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

from mjbiped.errors import InputError, shown
from mjbiped.utils.domains import entries

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller, Memory

_METHODS = ("on_touchdown", "on_knee_strike", "torque", "slope_estimate", "next_discontinuity")


def gives_its_law(controller: Controller) -> bool:
    """Tell whether `law` stands for all methods of the controller: none of them is newer than it.

    A method is newer that was replaced in a class derived from the one that has `law`, or in the object itself.
    """
    order = (controller, *type(controller).__mro__)

    def place(name: str) -> int:
        return next(i for i, owner in enumerate(order) if name in vars(owner))

    return all(place("law") <= place(name) for name in _METHODS)


def torque(
    controller: Controller, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]
) -> Sequence[float]:
    """Call the method `torque` by the signature of `Law.torque`, whose first argument is the controller here.

    Raises:
        InputError: It returned another number of values than it should, or no numbers.
    """
    given: Any = controller.torque(memory, t, q, dq)
    # a walk asks thousands of times: what most laws return passes without further checks
    wanted = len(controller.joints) + len(controller.states)
    if type(given) is tuple and len(given) == wanted and type(given[0]) is type(given[-1]) is float:
        return given
    return values_of(controller, given)


def values_of(controller: Controller, given: Any) -> tuple[float, ...]:
    """Check that `torque` returned as many numbers as it must, and return them as a tuple.

    Raises:
        InputError: `torque` returned something else.
    """
    wanted = len(controller.joints) + len(controller.states)
    values = entries(given)
    if values is None or len(values) != wanted:
        got = shown(given) if values is None else f"{len(values)} values"
        rates = ", ".join(controller.states) or "none"
        returned = ", ".join((*controller.joints, *(f"rate_of_{state}" for state in controller.states)))
        raise InputError(
            f"{type(controller).__name__}.torque returned {got}; expected {wanted}: {', '.join(controller.joints)} "
            f"(N m) and a rate per state ({rates}), as `return {returned}`"
        )
    for value in values:
        if type(value) is not float and not isinstance(value, Real):
            raise InputError(
                f"{type(controller).__name__}.torque returned {shown(given)}; {shown(value)} in it is no number"
            )
    return values


def _method(name: str) -> Callable[..., Any]:
    """Return a function that calls a method by the signature of a law, whose first argument is the controller here."""
    return lambda controller, *arguments: getattr(controller, name)(*arguments)


touchdown, slope_estimate, next_discontinuity, tick, knee_strike = map(
    _method, ("on_touchdown", "slope_estimate", "next_discontinuity", "tick", "on_knee_strike")
)
LAWS = (torque, touchdown, slope_estimate, next_discontinuity, tick, knee_strike)
"""What an engine calls of a controller, in the order of `Law`'s functions."""
