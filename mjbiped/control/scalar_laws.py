"""Laws of scalars, the form of `Law` before this release: they are interpreted, and work until the next release.

Their `torque` takes angles and rates one by one, and returns torques and rates of the states as a tuple.
"""

from __future__ import annotations

import inspect
import warnings
from functools import lru_cache, partial
from itertools import chain
from typing import TYPE_CHECKING, Any

from mjbiped.numerics.cache import Function

if TYPE_CHECKING:
    from mjbiped.control.controller import Law, Numbers, Room

_ON_ARRAYS = 6  # parameters, memory, t, q, dq, out


def on_arrays(law: Law) -> Law:
    """Return a law whose functions take arrays; those of a law of scalars are wrapped, with a `DeprecationWarning`."""
    if not takes_scalars(law.torque):
        return law
    _warn(law.torque)
    given = [name for name in ("touchdown", "knee_strike") if getattr(law, name) is not law._field_defaults[name]]
    wrapped: dict[str, Any] = {name: partial(_event, getattr(law, name)) for name in given}
    return law._replace(torque=partial(_torque, law.torque), **wrapped)


def _torque(torque: Function, parameters: object, memory: object, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    values = torque(parameters, memory, t, *q, *dq)
    out[: len(values)] = values


def _event(event: Function, parameters: object, memory: object, first: float | Numbers, *state: Numbers) -> None:
    """Call a law's function of a touchdown, given angles and rates, or of a knee strike, given the time before them."""
    parts = ((first,) if isinstance(first, float) else first, *state)
    event(parameters, memory, *chain.from_iterable(parts))


@lru_cache(maxsize=256)
def takes_scalars(torque: Function) -> bool:
    """Whether a law's `torque` takes each angle and each rate by itself."""
    given = inspect.signature(torque).parameters.values()
    return any(each.kind is each.VAR_POSITIONAL for each in given) or (len(given) > 4 and len(given) != _ON_ARRAYS)


@lru_cache(maxsize=256)
def _warn(torque: Function) -> None:
    """Warn of a law of scalars, once for each law."""
    warnings.warn(
        f"{torque.__module__}.{torque.__name__} is a law of scalars: it is interpreted, and the next release does "
        "not accept it. Write it on arrays, with all parameters as floats in one flat list: "
        "def torque(parameters, memory, t, q, dq, out): out[0], out[1] = ankle, hip; "
        "def touchdown(parameters, memory, q_before, q, dq)",
        DeprecationWarning,
        stacklevel=4,
    )
