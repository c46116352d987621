"""A controller's laws as an engine calls them: its compilable ones, or its methods behind the same signatures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mjbiped.errors import InputError

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller, Memory

_METHODS = ("start", "on_touchdown", "torque", "slope_estimate", "next_discontinuity")


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
    controller: Controller, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> Sequence[float]:
    """The method `torque`, with the controller in the place of its law's parameters.

    Raises:
        InputError: It returned another number of values than it should.
    """
    values = tuple(controller.torque(memory, t, (q1, q2), (dq1, dq2)))
    if len(values) != 2 + len(controller.states):
        rates = ", ".join(controller.states) or "none"
        raise InputError(f"torque returned {len(values)} values; expected ankle, hip and a rate per state ({rates})")
    return values


def touchdown(
    controller: Controller,
    memory: Memory,
    q1_before: float,
    q2_before: float,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
) -> None:
    """The method `on_touchdown` likewise."""
    controller.on_touchdown(memory, (q1_before, q2_before), (q1, q2), (dq1, dq2))


def slope_estimate(controller: Controller, memory: Memory) -> float:
    """The method `slope_estimate` likewise."""
    return controller.slope_estimate(memory)


def next_discontinuity(controller: Controller, memory: Memory, t: float) -> float:
    """The method `next_discontinuity` likewise; a controller without it has no breaks."""
    ask = getattr(controller, "next_discontinuity", None)
    return math.inf if ask is None else float(ask(memory, t))
