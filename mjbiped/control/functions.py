"""A controller's functions with the signatures that engines call in plain Python, and their trial before a walk.

`in_python` gives all controllers the signatures of `mjbiped.control.controller.Law`. `mjbiped.numerics.blocks.call`
calls such functions, and in machine code their compiled form (`mjbiped.control.compiled`).

`try_out` tests the contract (`mjbiped.control.controller.Controller`) as far as a first step can: parameters, the
memory's size, the numbers that `torque` returns, and that these depend on nothing but its arguments and the memory.
Exceptions of the methods are left to the walk, which keeps its record up to then.
"""

from __future__ import annotations

import copy
import inspect
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import FrozenInstanceError
from functools import cached_property, partial
from numbers import Real
from typing import Any

from mjbiped.control.controller import ROOM, Controller, Law, LawController, Memory, Numbers, Room
from mjbiped.errors import InputError, explained, place_of, shown
from mjbiped.utils.domains import as_float, entries

State = tuple[float, ...]

_METHODS = ("on_touchdown", "on_knee_strike", "on_tick", "torque", "slope_estimate", "next_discontinuity")
_TRIED = ("start", "on_touchdown", "on_tick", "torque", "slope_estimate")
_KEPT = "what lasts from one call to the next belongs into the memory, which start and on_touchdown change"
_LATER = 0.1  # s: another time of the step, at which the law is asked too


def law_of(controller: Controller) -> Law | None:
    """The law of a controller; None where it gives none, or one that does not stand for all its methods.

    A method is newer than `law` that was replaced in a class derived from the one that has `law`, or in the object
    itself.

    Raises:
        InputError: `law` gives something else.
    """
    order = (controller, *type(controller).__mro__)
    places = {name: next(i for i, owner in enumerate(order) if name in vars(owner)) for name in ("law", *_METHODS)}
    law = controller.law() if places["law"] == min(places.values()) else None
    if not isinstance(law, Law | None):
        raise InputError(f"{type(controller).__name__}.law() gives {shown(law)}; expected a Law, or None")
    return law


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


def _change(method: str, controller: Controller, memory: Memory, first: float | Numbers, *state: Numbers) -> None:
    """Call a method that may change the memory, of which a disturbed loop's part stands behind."""
    own = memory[: controller.memory_size]
    begin = first if isinstance(first, float) else tuple(first)
    getattr(controller, method)(own, begin, *map(tuple, state))
    memory[: controller.memory_size] = own


_touchdown, _knee_strike, _tick = (partial(_change, name) for name in ("on_touchdown", "on_knee_strike", "on_tick"))


def _slope_estimate(controller: Controller, memory: Memory) -> float:
    return controller.slope_estimate(memory[: controller.memory_size])


def _next_discontinuity(controller: Controller, memory: Memory, t: float) -> float:
    return controller.next_discontinuity(memory[: controller.memory_size], t)


def values_of(controller: Controller, given: object) -> State:
    """Check that `torque` returned as many numbers as it must, and return them as a tuple.

    Raises:
        InputError: `torque` returned something else.
    """
    values, said = entries(given), f"{type(controller).__name__}.torque returned"
    wanted = (*controller.joints, *(f"rate_of_{state}" for state in controller.states))
    if values is None or len(values) != len(wanted):
        got = shown(given) if values is None else f"{len(values)} values"
        rates = ", ".join(controller.states) or "none"
        raise InputError(
            f"{said} {got}; expected {len(wanted)}: {', '.join(controller.joints)} (N m) and a rate per state "
            f"({rates}), as `return {', '.join(wanted)}`"
        )
    for value in values:
        if not isinstance(value, Real):
            raise InputError(f"{said} {shown(given)}; {shown(value)} in it is no number; expected torques in N m")
    return values


def try_out(controller: Controller, q: State, dq: State) -> None:
    """Try a controller's methods in the state in which its walk begins.

    Args:
        controller: As `mjbiped.engines.checks.check_controller` has passed it.
        q: The robot's angles, rad.
        dq: Their rates, rad/s.

    Raises:
        InputError: The controller breaks the contract.
    """
    kind, begun = type(controller), "law"
    _check_parameters(controller)
    try:
        law = law_of(controller)
        if law is not None:
            _check_law(controller, law)
        else:  # methods may change the object's attributes
            with suppress(Exception):  # whatever its parts raise
                controller = copy.deepcopy(controller)
        memory, before = [0.0] * controller.memory_size, _attributes(controller)
        for begun, given in (("start", (q, dq)), ("on_tick", (0.0, q, dq))):
            getattr(controller, begun)(memory, *given)
            _check_memory(controller, begun, memory)
        begun = ""
        first = _asked(controller, law, memory, 0.0, q, dq)
        if fault := fault_in(controller, first, 0.0, q, dq):
            raise InputError(f"{fault}: the walk cannot begin")
        _step_on(controller, law, memory, q, dq)
        changed = [key for key, value in _attributes(controller).items() if before.get(key, before) is not value]
        if changed:
            raise InputError(f"{kind.__name__} sets its attribute {', '.join(changed)} while it walks; {_KEPT}")
        again, joints = _asked(controller, law, memory, 0.0, q, dq), len(controller.joints)
        if repr(again) != repr(first):  # a rate may be no number
            raise InputError(
                f"{kind.__name__}.torque gives {first[:joints]} and then {again[:joints]} for the same arguments; "
                f"{_KEPT}, and neither chance nor the clock has a part in it"
            )
    except InputError:
        raise
    except FrozenInstanceError as error:
        raise InputError(
            f"{kind.__name__} sets an attribute while it walks: {error}{place_of(error, kind)}; {_KEPT}"
        ) from error
    except (Exception, SystemExit) as error:
        if not begun:
            return  # the walk tells of it
        raise InputError(f"{kind.__name__}.{begun} fails: {failure(error, controller)}") from error


def failure(error: BaseException, controller: Controller) -> str:
    """Describe an exception of a controller's method, where in the user's code it arose, and what to do about it."""
    size = f"the memory has as many floats as memory_size says, {controller.memory_size}: set that as you need"
    advice = f"; {size}" if isinstance(error, IndexError) else ""
    return f"{explained(error)}{place_of(error, type(controller))}{advice}"


def _names(controller: Controller) -> tuple[str, ...]:
    """Names of the numbers that `torque` gives."""
    return (*(f"{joint} torque" for joint in controller.joints), *(f"rate of {state}" for state in controller.states))


def fault_in(controller: Controller, values: Sequence[float], t: float, q: State, dq: State) -> str:
    """Describe which numbers from `torque` are not finite, and in which state; empty if all are.

    Args:
        controller: The law.
        values: Ankle and hip torque, and the rates of states, if they are known.
        t: Time since the support transfer, s.
        q: The robot's angles, rad.
        dq: Their rates, rad/s.
    """
    faults = [
        f"{shown(value)} for the {name}"
        for name, value in zip(_names(controller), values, strict=False)
        if not math.isfinite(as_float(value))
    ]
    if not faults:
        return ""
    angles, rates = (", ".join(f"{value:.4g}" for value in values) for values in (q, dq))
    return (
        f"{type(controller).__name__}.torque gives {' and '.join(faults)} at t = {t:.4g} s of the step, "
        f"q = ({angles}) rad, dq = ({rates}) rad/s"
    )


def fault_at(controller: Controller, memory: Sequence[float], t: float, q: State, dq: State) -> str:
    """Describe the numbers that are not finite in the state in which a walk ended; see `fault_in`.

    The law is also asked a little later, for the walk ends just before the state in which it fails.

    Args:
        controller: The law.
        memory: Its memory in that state.
        t: Time since the support transfer, s.
        q: The robot's angles, rad.
        dq: Their rates, rad/s.
    """
    for later in (0.0, 1e-11, 1e-9):
        there = tuple(angle + later * rate for angle, rate in zip(q, dq, strict=True))
        with suppress(Exception):  # whatever the user's method raises: there is nothing to describe then
            values = values_of(controller, controller.torque(list(memory), t + later, there, dq))
            if found := fault_in(controller, values, t + later, there, dq):
                return found
    return ""


def _check_parameters(controller: Controller) -> None:
    """Refuse methods, and functions of a law, that do not take what they are called with."""
    for method in _TRIED:
        parameters = [*inspect.signature(getattr(Controller, method)).parameters]
        _check_taken(f"{type(controller).__name__}.{method}", getattr(controller, method), parameters[1:], ["self"])


def _check_law(controller: Controller, law: Law) -> None:
    """Refuse a law whose parameters are no sequence, or whose functions do not take what they are called with."""
    said = f"{type(controller).__name__}.law() gives a Law"
    if entries(law.parameters) is None:
        raise InputError(f"{said} whose parameters are {shown(law.parameters)}; expected a sequence of numbers")
    for name, function in law.functions.items():
        method = getattr(Controller, name, None) or getattr(Controller, f"on_{name}")
        taken = ["parameters", *[*inspect.signature(method).parameters][1:], *(["out"] if name == "torque" else [])]
        _check_taken(f"{said} whose {name}", function, taken, [])


def _check_taken(what: str, function: Callable[..., object], taken: list[str], bound: list[str]) -> None:
    """Refuse a function that cannot be called with some positional arguments.

    Args:
        what: The function in words.
        function: The function.
        taken: Names of the arguments.
        bound: Names that its definition has in front of them.
    """
    try:
        inspect.signature(function).bind(*taken)
    except ValueError:  # a compiled extension tells no signature
        return
    except TypeError as error:
        name = what.split(".")[-1].split()[-1]
        raise InputError(
            f"{what} does not take what it is given: {error}; expected is def {name}({', '.join([*bound, *taken])})"
        ) from error


def _check_memory(controller: Controller, method: str, memory: list[Any]) -> None:
    called, size = f"{type(controller).__name__}.{method}", controller.memory_size
    if len(memory) != size:
        raise InputError(
            f"{called} leaves a memory of {len(memory)} floats where memory_size = {size}: change its entries, never "
            "its length"
        )
    for index, value in enumerate(memory):
        if not isinstance(value, Real):
            raise InputError(f"{called} writes {shown(value)} into memory[{index}]; expected a number")


def _asked(controller: Controller, law: Law | None, memory: list[float], t: float, q: State, dq: State) -> State:
    """Torques and rates of states, by the law if there is one; they must leave the memory unchanged.

    Raises:
        InputError: The memory has changed, or not all numbers were given.
    """
    given, name = list(memory), f"{type(controller).__name__}{'' if law is None else '.law()'}.torque"
    if law is None:
        values = values_of(controller, controller.torque(given, t, q, dq))
    else:
        names = _names(controller)
        out: list[Any] = [None] * len(names) + [0.0] * ROOM
        returned: object = law.torque(law.parameters, given, t, q, dq, out)
        if returned is not None:
            raise InputError(f"{name} returns {shown(returned)}; expected are {len(names)} numbers written into out")
        if None in out:
            raise InputError(f"{name} leaves out[{out.index(None)}], the {names[out.index(None)]}, unwritten")
        values = tuple(out[: len(names)])
    if given != memory:
        index = next((i for i, (a, b) in enumerate(zip(given, memory, strict=False)) if a != b), len(memory))
        raise InputError(
            f"{name} writes into memory[{index}]: torque must leave the memory as it is, for engines ask it more than "
            "once at a time; name the number in `states` and return its rate, or change it in on_touchdown"
        )
    return values


def _step_on(controller: Controller, law: Law | None, memory: list[float], q: State, dq: State) -> None:
    """Call all methods that a step calls, on a copy of the memory, so that only the object's attributes can change."""
    kept = list(memory)
    try:
        _asked(controller, law, kept, _LATER, tuple(0.5 * angle for angle in q), dq)
        controller.slope_estimate(kept)
        if len(q) > 2:
            controller.on_knee_strike(kept, _LATER, q, dq)
        others = len(q) - 1  # as a passive gait's
        before, after = (0.2, *(-0.2,) * others), (-0.2, *(0.2,) * others)
        controller.on_touchdown(kept, before, after, (1.1, *(0.8,) * others))
    except (InputError, FrozenInstanceError):
        raise
    except Exception:  # in a state that the walk may never come to
        return
    _check_memory(controller, "on_touchdown", kept)


def _attributes(controller: Controller) -> dict[str, object]:
    """Return the attributes of the object, except cached properties."""
    kind = type(controller)
    return {
        key: value
        for key, value in vars(controller).items()
        if not isinstance(inspect.getattr_static(kind, key, None), cached_property)
    }
