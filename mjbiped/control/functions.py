"""A controller's functions as engines call them, in plain Python and as machine code.

Their arguments are those of `mjbiped.control.controller.Law`; `mjbiped.numerics.blocks.call` calls them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from mjbiped.control import adapters
from mjbiped.control.compiled import CalledMethods, MachineCode, compilable_law, refused_in_words
from mjbiped.control.controller import Controller, LawController


class Functions(NamedTuple):
    """The functions, or their addresses.

    Attributes:
        parameters: First argument of all of them.
        torque: See `mjbiped.control.controller.Law` for this and all that follow.
        touchdown: See there.
        slope_estimate: See there.
        next_discontinuity: See there.
        tick: See there; 0 or None where there is none.
        knee_strike: See there.
    """

    parameters: Any
    torque: Any
    touchdown: Any
    slope_estimate: Any
    next_discontinuity: Any
    tick: Any
    knee_strike: Any


def in_python(controller: Controller) -> Functions:
    """The functions of a controller's law, or its methods behind the same signatures."""
    law = controller.law() if isinstance(controller, LawController) and adapters.gives_its_law(controller) else None
    if law is not None:
        return Functions(*law[:5], law.tick, law.knee_strike or _strike_nothing)
    return Functions(controller, _torque, *adapters.LAWS[1:])


def as_machine_code(controller: Controller) -> tuple[Functions, MachineCode | CalledMethods]:
    """Addresses of a controller's laws as machine code, or of C functions that call its methods.

    Returns:
        The addresses, and what has to live as long as they are used. The first float at that of the parameters is not
        zero once a function has raised an exception.

    Raises:
        LawError: The laws cannot be compiled.
    """
    law, joints = compilable_law(controller), len(controller.joints)
    code: MachineCode | CalledMethods
    with refused_in_words(controller, law):
        if law is None:
            code = CalledMethods(controller)
        else:
            code = MachineCode(law, len(controller.states), controller.memory_size, joints=joints)
    made = code.law._asdict()
    return Functions(made.pop("record"), **made), code


def _torque(controller: Controller, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    """Call the method `torque`, and write what it returns."""
    values = adapters.torque(controller, memory, t, tuple(q), tuple(dq))
    out[: len(values)] = values


def _strike_nothing(parameters: Any, memory: Any, t: float, q: Any, dq: Any) -> None:
    """Do nothing at a knee strike."""
