"""A controller's laws as the hybrid engine calls them: functions of arrays, or C functions of addresses."""

from __future__ import annotations

from typing import Any

from mjbiped.control import adapters
from mjbiped.control.adapters import gives_its_law
from mjbiped.control.compiled import MachineCode
from mjbiped.control.controller import Controller, LawController

NAMES = ("torque", "touchdown", "slope_estimate", "next_discontinuity", "tick", "knee_strike")

Functions = dict[str, Any]
"""The fields of `Constants` that say what the engine calls, and `parameters`, what these take first."""


def plain_functions(controller: Controller) -> Functions:
    """The laws of a controller in plain Python: those that it gives, else its methods."""
    law = controller.law() if isinstance(controller, LawController) and gives_its_law(controller) else None
    if law is not None:
        return law._asdict()
    methods: dict[str, Any] = dict(zip(NAMES, adapters.LAWS, strict=True))

    def torque(law: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
        values = adapters.torque(law, memory, t, tuple(q), tuple(dq))
        out[: len(values)] = values

    def in_tuples(name: str) -> Any:
        method = methods[name]
        return lambda law, memory, *given: method(
            law, memory, *(each if isinstance(each, float) else tuple(each) for each in given)
        )

    return {name: in_tuples(name) for name in NAMES} | {"torque": torque, "parameters": controller}


def machine_functions(code: MachineCode) -> Functions:
    """The C functions of compiled laws, and the address of their record; `code` has to live while they are called."""
    law = code.law
    return {name: getattr(law, name) for name in NAMES} | {"parameters": law.record}
