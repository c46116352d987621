"""A controller's methods behind the calls that engines make: `mjbiped.control.machine_code` has them for compiled laws.

Angles q and rates dq are tuples, with a number for each of the robot's angles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

from mjbiped.errors import InputError, shown

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller, Memory

_METHODS = ("start", "on_touchdown", "on_knee_strike", "torque", "slope_estimate", "next_discontinuity")


def gives_its_law(controller: Controller) -> bool:
    """Whether `law` speaks for the controller: no method was replaced in a class derived from the one that has it.

    Nor in the object itself.
    """
    if not hasattr(controller, "law"):
        return False
    order = type(controller).__mro__
    own = getattr(controller, "__dict__", {})

    def place(name: str) -> int:
        return -1 if name in own else next((i for i, owner in enumerate(order) if name in vars(owner)), len(order))

    return all(place("law") <= place(name) for name in _METHODS)


def torque(
    controller: Controller, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]
) -> Sequence[float]:
    """The method `torque`, with the controller in the place of its law's parameters.

    Raises:
        InputError: It returned another number of values than it should, or no numbers.
    """
    given: Any = controller.torque(memory, t, q, dq)
    # what most laws return, and nothing else, is seen at once: a walk asks thousands of times
    wanted = len(controller.joints) + len(controller.states)
    if type(given) is tuple and len(given) == wanted and type(given[0]) is type(given[-1]) is float:
        return given
    return values_of(controller, given)


def values_of(controller: Controller, given: Any) -> tuple[float, ...]:
    """What `torque` returned, if it is as many numbers as it must be.

    Raises:
        InputError: It is not.
    """
    wanted = len(controller.joints) + len(controller.states)
    try:
        values = tuple(given)
    except TypeError:
        values = None
    if values is None or isinstance(given, str) or len(values) != wanted:
        got = shown(given) if values is None or isinstance(given, str) else f"{len(values)} values"
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


def touchdown(
    controller: Controller, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]
) -> None:
    """The method `on_touchdown` likewise."""
    controller.on_touchdown(memory, q_before, q, dq)


def slope_estimate(controller: Controller, memory: Memory) -> float:
    """The method `slope_estimate` likewise."""
    return controller.slope_estimate(memory)


def next_discontinuity(controller: Controller, memory: Memory, t: float) -> float:
    """The method `next_discontinuity` likewise; a controller without it has no breaks."""
    ask = getattr(controller, "next_discontinuity", None)
    return math.inf if ask is None else float(ask(memory, t))


def tick(controller: Any, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
    """The method `tick` of a `mjbiped.disturbances.sampled.SampledController` likewise."""
    controller.tick(memory, t, q, dq)


def knee_strike(controller: Controller, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
    """The method `on_knee_strike` likewise."""
    controller.on_knee_strike(memory, t, q, dq)


LAWS = (torque, touchdown, slope_estimate, next_discontinuity, tick, knee_strike)
"""What an engine calls of a controller, in the order of `Law`'s functions."""
