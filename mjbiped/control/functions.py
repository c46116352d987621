"""A controller's functions as engines call them in plain Python, by the signatures of `mjbiped.control.controller.Law`.

`mjbiped.numerics.blocks.call` calls them, and in machine code what `mjbiped.control.compiled` makes of them.
"""

from __future__ import annotations

from collections.abc import Callable
from numbers import Real
from typing import Any

from mjbiped.control.controller import Controller, Law, LawController, Memory, Numbers, Room
from mjbiped.errors import InputError, shown
from mjbiped.utils.domains import entries

_METHODS = ("on_touchdown", "on_knee_strike", "torque", "slope_estimate", "next_discontinuity")


def gives_its_law(controller: Controller) -> bool:
    """Tell whether `law` stands for all methods of the controller: none of them is newer than it.

    A method is newer that was replaced in a class derived from the one that has `law`, or in the object itself.
    """
    order = (controller, *type(controller).__mro__)

    def place(name: str) -> int:
        return next(i for i, owner in enumerate(order) if name in vars(owner))

    return all(place("law") <= place(name) for name in _METHODS)


def in_python(controller: Controller) -> Law:
    """The functions of a controller's law, or its methods behind the same signatures."""
    law = controller.law() if isinstance(controller, LawController) and gives_its_law(controller) else None
    parameters: Any = controller
    methods = Law(parameters, _torque, _touchdown, _slope_estimate, _next_discontinuity, knee_strike=_knee_strike)
    return methods if law is None else law


def _torque(controller: Controller, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    values: Any = controller.torque(memory[: controller.memory_size], t, tuple(q), tuple(dq))
    # a walk asks thousands of times: what most laws return passes without further checks
    count = len(controller.joints) + len(controller.states)
    if type(values) is not tuple or len(values) != count or not type(values[0]) is type(values[-1]) is float:
        values = values_of(controller, values)
    out[:count] = values


def _touchdown(controller: Controller, memory: Memory, *state: Numbers) -> None:
    _change(controller.on_touchdown, controller, memory, *map(tuple, state))


def _knee_strike(controller: Controller, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    _change(controller.on_knee_strike, controller, memory, t, tuple(q), tuple(dq))


def _slope_estimate(controller: Controller, memory: Memory) -> float:
    found: float = controller.slope_estimate(memory[: controller.memory_size])
    return found


def _next_discontinuity(controller: Controller, memory: Memory, t: float) -> float:
    found: float = controller.next_discontinuity(memory[: controller.memory_size], t)
    return found


def _change(method: Callable[..., None], controller: Controller, memory: Memory, *state: object) -> None:
    """Call a method that changes the controller's own part of the memory; a disturbed loop's stands behind it."""
    own = memory[: controller.memory_size]
    method(own, *state)
    memory[: controller.memory_size] = own


def values_of(controller: Controller, given: object) -> tuple[float, ...]:
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
        if not isinstance(value, Real):
            raise InputError(
                f"{type(controller).__name__}.torque returned {shown(given)}; {shown(value)} in it is no number"
            )
    return values
