"""Laws of scalars, the form of `Law` until this release: they work for one release more, in plain Python.

Their `torque` takes angles and rates one by one, and returns torques and rates of the states as a tuple.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, MutableSequence, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mjbiped.control.controller import Law

_ON_ARRAYS = 6  # parameters, memory, t, q, dq, out


def on_arrays(law: Law) -> Law:
    """Return a law of arrays; one of scalars is wrapped, with a `DeprecationWarning`, and becomes the parameters."""
    if not takes_scalars(law.torque):
        return law
    _warn(law.torque)
    given: Any = law
    made = type(law)(given, _torque, _touchdown, _slope_estimate, _next_discontinuity)
    return made if law.knee_strike is made.knee_strike else made._replace(knee_strike=_knee_strike)


def _torque(
    law: Any, memory: Any, t: float, q: Sequence[float], dq: Sequence[float], out: MutableSequence[float]
) -> None:
    values = law.torque(law.parameters, memory, t, *q, *dq)
    out[: len(values)] = values


def _touchdown(law: Any, memory: Any, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
    law.touchdown(law.parameters, memory, *q_before, *q, *dq)


def _knee_strike(law: Any, memory: Any, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
    law.knee_strike(law.parameters, memory, t, *q, *dq)


def _slope_estimate(law: Any, memory: Any) -> Any:
    return law.slope_estimate(law.parameters, memory)


def _next_discontinuity(law: Any, memory: Any, t: float) -> Any:
    return law.next_discontinuity(law.parameters, memory, t)


@lru_cache(maxsize=256)
def takes_scalars(torque: Callable[..., Any]) -> bool:
    """Whether a law's `torque` takes each angle and each rate by itself."""
    given = inspect.signature(torque).parameters.values()
    return any(each.kind is each.VAR_POSITIONAL for each in given) or (len(given) > 4 and len(given) != _ON_ARRAYS)


@lru_cache(maxsize=256)
def _warn(torque: Callable[..., Any]) -> None:
    """Warn, once for a law."""
    warnings.warn(
        f"{torque.__module__}.{torque.__name__} is a law of scalars: it is interpreted, and the next release does "
        "not accept it. Write it on arrays, with all parameters as floats in one flat list: "
        "def torque(parameters, memory, t, q, dq, out): out[0], out[1] = ankle, hip; "
        "def touchdown(parameters, memory, q_before, q, dq)",
        DeprecationWarning,
        stacklevel=4,
    )
