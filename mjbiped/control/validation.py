"""A controller's methods tried once before a walk, so that what is wrong with them is told in words, and in time.

What the contract asks for (`mjbiped.control.controller.Controller`) and a first step would show: parameters, the
memory's size, the numbers that `torque` returns, and that these depend on nothing but its arguments and the memory.
Exceptions that the methods raise are left to the walk, which keeps what was walked until then.
"""

from __future__ import annotations

import copy
import inspect
import math
from collections.abc import Sequence
from dataclasses import FrozenInstanceError
from functools import cached_property, lru_cache
from numbers import Real
from typing import TYPE_CHECKING, Any

from mjbiped.control.adapters import gives_its_law, values_of
from mjbiped.errors import InputError, explained, place_of, shown

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller

_PARAMETERS = {
    "start": ("memory", "q", "dq"),
    "on_touchdown": ("memory", "q_before", "q", "dq"),
    "torque": ("memory", "t", "q", "dq"),
    "slope_estimate": ("memory",),
}
_KEPT = "what lasts from one call to the next belongs into the memory, which start and on_touchdown change"
_LATER = 0.1  # s: another time of the step, at which the law is asked too

State = tuple[float, ...]


def try_out(controller: Controller, q: State, dq: State) -> None:
    """Try a controller's methods in the state in which its walk begins.

    Args:
        controller: As `mjbiped.engines.plan.check_controller` has passed it.
        q: The robot's angles, rad.
        dq: Their rates, rad/s.

    Raises:
        InputError: It breaks the contract.
    """
    kind = type(controller)
    _check_parameters(kind)
    try:
        _try_out(_stand_in(controller), q, dq)
    except InputError:
        raise
    except FrozenInstanceError as error:
        raise InputError(
            f"{kind.__name__} sets an attribute while it walks: {error}{place_of(error, kind)}; {_KEPT}"
        ) from error
    except (Exception, SystemExit):
        return  # the walk tells of it


def _try_out(controller: Controller, q: State, dq: State) -> None:
    """As `try_out`; whatever the methods raise is passed on."""
    name = type(controller).__name__
    memory: list[Any] = [0.0] * controller.memory_size
    before = _attributes(controller)
    _check_law(controller)
    try:
        controller.start(memory, q, dq)
    except FrozenInstanceError:
        raise
    except IndexError as error:
        raise InputError(
            f"{name}.start fails: {error}{place_of(error, type(controller))}; the memory has as many floats as "
            f"memory_size says, {controller.memory_size}: set that to as many as you need"
        ) from error
    except (Exception, SystemExit) as error:  # there is no walk yet that could tell of it
        raise _failing(controller, "start", error) from error
    _check_memory(name, "start", controller.memory_size, memory)
    first = _asked(controller, memory, 0.0, q, dq)
    fault = fault_in(controller, first, 0.0, q, dq)
    if fault:
        raise InputError(f"{fault}: the walk cannot begin")
    _step_on(controller, memory, q, dq)
    changed = [key for key, value in _attributes(controller).items() if before.get(key, before) is not value]
    if changed:
        raise InputError(f"{name} sets its attribute {', '.join(changed)} while it walks; {_KEPT}")
    again, joints = _asked(controller, memory, 0.0, q, dq), len(controller.joints)
    if repr(again) != repr(first):  # a rate may be no number
        raise InputError(
            f"{name}.torque gives {first[:joints]} and then {again[:joints]} for the same arguments; {_KEPT}, "
            "and neither chance nor the clock has a part in it"
        )


def _check_law(controller: Controller) -> None:
    """Refuse laws for compilation that cannot be had.

    Raises:
        InputError: They cannot.
    """
    if not gives_its_law(controller):
        return
    try:
        law = controller.law()
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise _failing(controller, "law", error) from error
    if law is not None and not isinstance(getattr(law, "functions", None), dict):
        raise InputError(f"{type(controller).__name__}.law() gives {shown(law)}; expected a Law, or None")


def _failing(controller: Controller, method: str, error: BaseException) -> InputError:
    kind = type(controller)
    return InputError(f"{kind.__name__}.{method} fails: {explained(error)}{place_of(error, kind)}")


def fault_in(controller: Controller, values: Sequence[float], t: float, q: State, dq: State) -> str:
    """Which of the numbers that `torque` gave is no finite one, and when, in words; empty where all are.

    Args:
        controller: The law.
        values: Ankle and hip torque, and the rates of states, if they are known.
        t: Time since the support transfer, s.
        q: The robot's angles, rad.
        dq: Their rates, rad/s.
    """
    named = (*(f"{joint} torque" for joint in controller.joints), *(f"rate of {state}" for state in controller.states))
    faults = [
        f"{shown(value)} for the {name}" for name, value in zip(named, values, strict=False) if not _finite(value)
    ]
    if not faults:
        return ""
    return (
        f"{type(controller).__name__}.torque gives {' and '.join(faults)} at t = {t:.4g} s of the step, "
        f"q = ({_listed(q)}) rad, dq = ({_listed(dq)}) rad/s"
    )


def _listed(values: State) -> str:
    return ", ".join(f"{value:.4g}" for value in values)


def fault_at(controller: Controller, memory: Sequence[float], t: float, q: State, dq: State) -> str:
    """As `fault_in`, in a state that a walk could not go beyond.

    The law is also asked a little later, for the walk ends just before what it fails of.

    Args:
        controller: The law.
        memory: As it is there.
        t: Time since the support transfer, s.
        q: The robot's angles, rad.
        dq: Their rates, rad/s.
    """
    for later in (0.0, 1e-11, 1e-9):
        there = tuple(angle + later * rate for angle, rate in zip(q, dq, strict=True))
        try:
            values = values_of(controller, controller.torque(list(memory), t + later, there, dq))
        except Exception:
            return ""
        found = fault_in(controller, values, t + later, there, dq)
        if found:
            return found
    return ""


def _finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number that no float can hold
        return False


def _stand_in(controller: Controller) -> Controller:
    """A copy of a controller, which may keep something of the calls in its attributes: in a list that it fills.

    What is a frozen dataclass with compiled laws keeps nothing, and costs nothing here.
    """
    if gives_its_law(controller):
        return controller
    try:
        return copy.deepcopy(controller)
    except Exception:  # whatever its parts raise
        return controller


@lru_cache(maxsize=64)
def _check_parameters(kind: type) -> None:
    """Refuse methods that do not take what they are called with."""
    for method, parameters in _PARAMETERS.items():
        try:
            signature = inspect.signature(getattr(kind, method))
        except (TypeError, ValueError, AttributeError):  # of compiled extensions; of an object, not of its class
            continue
        bound = isinstance(inspect.getattr_static(kind, method), staticmethod | classmethod)
        try:
            signature.bind(*(() if bound else ("self",)), *parameters)
        except TypeError as error:
            raise InputError(
                f"{kind.__name__}.{method}{signature} does not take what it is given: {error}; expected is "
                f"def {method}(self, {', '.join(parameters)})"
            ) from error


def _check_memory(name: str, method: str, size: int, memory: list[Any]) -> None:
    if len(memory) != size:
        raise InputError(
            f"{name}.{method} leaves a memory of {len(memory)} floats where memory_size = {size}: change its entries, "
            "never its length"
        )
    for index, value in enumerate(memory):
        if not isinstance(value, Real):
            raise InputError(f"{name}.{method} writes {shown(value)} into memory[{index}]; expected a number")


def _asked(controller: Controller, memory: list[float], t: float, q: State, dq: State) -> tuple[float, ...]:
    """What `torque` returns; it must not have written into the memory.

    Raises:
        InputError: It has, or its values are not as they must be.
    """
    given = list(memory)
    values = values_of(controller, controller.torque(given, t, q, dq))
    if len(given) != len(memory) or any(a is not b and a != b for a, b in zip(given, memory, strict=True)):
        index = next((i for i, (a, b) in enumerate(zip(given, memory, strict=False)) if a != b), len(memory))
        raise InputError(
            f"{type(controller).__name__}.torque writes into memory[{index}]: torque must leave the memory as it is, "
            "for engines ask it more than once at a time; name the number in `states` and return its rate, or change "
            "it in on_touchdown"
        )
    return values


def _step_on(controller: Controller, memory: list[float], q: State, dq: State) -> None:
    """Ask for what a walk asks for, on a copy of the memory: whatever stays behind is in the object."""
    kept = list(memory)
    try:
        _asked(controller, kept, _LATER, tuple(0.5 * angle for angle in q), dq)
        controller.slope_estimate(kept)
        if len(q) > 2:
            controller.on_knee_strike(kept, _LATER, q, dq)
        shank = len(q) - 2  # as a passive gait's
        before, after = (0.2, -0.2) + (-0.2,) * shank, (-0.2, 0.2) + (0.2,) * shank
        controller.on_touchdown(kept, before, after, (1.1, 0.8) + (0.8,) * shank)
    except (InputError, FrozenInstanceError):
        raise
    except Exception:  # in a state that the walk may never come to
        return
    _check_memory(type(controller).__name__, "on_touchdown", controller.memory_size, kept)


def _attributes(controller: Controller) -> dict[str, Any]:
    """What the object holds, apart from what it computes once."""
    computed = _computed_once(type(controller))
    return {key: value for key, value in getattr(controller, "__dict__", {}).items() if key not in computed}


@lru_cache(maxsize=64)
def _computed_once(kind: type) -> frozenset[str]:
    return frozenset(
        key for each in kind.__mro__ for key, value in vars(each).items() if isinstance(value, cached_property)
    )
