"""A controller's functions as engines call them in plain Python, by the signatures of `mjbiped.control.controller.Law`.

`mjbiped.numerics.blocks.call` calls them, and in machine code what `mjbiped.control.compiled` makes of them.
"""

from __future__ import annotations

from numbers import Real
from typing import Any

from mjbiped.control.controller import Controller, Law, LawController, Memory, Numbers, Room
from mjbiped.control.scalar_laws import on_arrays
from mjbiped.errors import InputError, shown
from mjbiped.utils.domains import entries

_METHODS = ("on_touchdown", "on_knee_strike", "on_tick", "torque", "slope_estimate", "next_discontinuity")


def law_of(controller: Controller) -> Law | None:
    """The law of a controller, on arrays; None where it gives none, or one that does not stand for all its methods.

    A method is newer than `law` that was replaced in a class derived from the one that has `law`, or in the object
    itself.

    Raises:
        InputError: `law` gives something else.
    """
    order = (controller, *type(controller).__mro__)
    places = {name: next(i for i, owner in enumerate(order) if name in vars(owner)) for name in ("law", *_METHODS)}
    law: object = controller.law() if places["law"] == min(places.values()) else None
    if not isinstance(law, Law | None):
        raise InputError(f"{type(controller).__name__}.law() gives {shown(law)}; expected a Law, or None")
    return None if law is None else on_arrays(law)


def acts_at_ticks(controller: Controller) -> bool:
    """Whether engines call the `on_tick` of a controller: it is digital, and its law has a tick if it has a law."""
    return controller.control_period is not None and ((law := law_of(controller)) is None or law.tick is not None)


def in_python(controller: Controller) -> Law:
    """The functions of a controller's law, or its methods behind the same signatures."""
    parameters: Any = controller
    methods = Law(parameters, _torque, _touchdown, _slope_estimate, _next_discontinuity, _tick, _knee_strike)
    return (law_of(controller) if isinstance(controller, LawController) else None) or methods


def _torque(controller: Controller, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    values: Any = controller.torque(memory[: controller.memory_size], t, tuple(q), tuple(dq))
    # a walk asks thousands of times: what most laws return passes without further checks
    count = len(controller.joints) + len(controller.states)
    if type(values) is not tuple or len(values) != count or not type(values[0]) is type(values[-1]) is float:
        values = values_of(controller, values)
    out[:count] = values


def _touchdown(controller: Controller, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    own = memory[: controller.memory_size]  # a disturbed loop's stands behind it
    controller.on_touchdown(own, tuple(q_before), tuple(q), tuple(dq))
    memory[: controller.memory_size] = own


def _knee_strike(controller: Controller, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    own = memory[: controller.memory_size]
    controller.on_knee_strike(own, t, tuple(q), tuple(dq))
    memory[: controller.memory_size] = own


def _tick(controller: Controller, memory: Memory, t: float, q: Numbers, dq: Numbers) -> None:
    own = memory[: controller.memory_size]
    controller.on_tick(own, t, tuple(q), tuple(dq))
    memory[: controller.memory_size] = own


def _slope_estimate(controller: Controller, memory: Memory) -> float:
    return controller.slope_estimate(memory[: controller.memory_size])


def _next_discontinuity(controller: Controller, memory: Memory, t: float) -> float:
    return controller.next_discontinuity(memory[: controller.memory_size], t)


def values_of(controller: Controller, given: object) -> tuple[float, ...]:
    """Check that `torque` returned as many numbers as it must, and return them as a tuple.

    Raises:
        InputError: `torque` returned something else.
    """
    wanted = len(controller.joints) + len(controller.states)
    values, said = entries(given), f"{type(controller).__name__}.torque returned"
    if values is None or len(values) != wanted:
        got = shown(given) if values is None else f"{len(values)} values"
        rates = ", ".join(controller.states) or "none"
        returned = ", ".join((*controller.joints, *(f"rate_of_{state}" for state in controller.states)))
        raise InputError(
            f"{said} {got}; expected {wanted}: {', '.join(controller.joints)} (N m) and a rate per state ({rates}), "
            f"as `return {returned}`"
        )
    for value in values:
        if not isinstance(value, Real):
            raise InputError(f"{said} {shown(given)}; {shown(value)} in it is no number")
    return values
