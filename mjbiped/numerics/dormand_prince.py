"""The Runge-Kutta scheme of the hybrid engine: Dormand and Prince's pair of order 8 with dense output of order 7.

Source: Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, sections II.5, II.6 and II.10 (DOP853); the
coefficients are those of `scipy.integrate.DOP853`.

A state here is a handful of numbers, for which loops over stages and components cost more than the sums in them. So
`unrolled` writes the step out, for a number of components, as Python source without loops: a function like any other,
which Numba turns into straight machine code. The rates of stage s stand at indices s n to s n + n - 1 of `k`.
"""

from __future__ import annotations

import linecache
import math
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import scipy

STAGES = 12  # of a step; the rates at its end are stage 12, the next step's stage 0
STAGES_WITH_DENSE = 16
POWERS = 7  # of the dense output
_UNTESTED_STAGES = range(1, 5)  # neither error estimate nor dense output uses them
TESTED_STAGES = (5, 6, 7, 8, 9, 10, STAGES)
"""Stages after the first whose rates stay in `k`; one more, 11, is at the same place as the last."""
STAGE_PLACES = (
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    0.3333333333333333,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
    1.0,
)
"""Where the stages lie, in shares of the step: SciPy's numbers, which are not asked for, since that takes 0.4 s."""
IN_ORDER = tuple(sorted((0, *TESTED_STAGES), key=lambda stage: STAGE_PLACES[stage]))
"""Stages in the order of their places, without those whose states lie beside the motion: up to 2e-3 of the torque."""
PLACES = tuple(STAGE_PLACES[stage] for stage in IN_ORDER)


class Integrator(NamedTuple):
    """A step and its dense output for states of one size.

    Attributes:
        begin: (rates, ..., t, y, k) -> None. The rates of the state `y`, the first of `k`.
        step: (rates, ..., t, h, y, k, out, tolerance, tested) -> error. One step of length h from the state `y`, whose
            rates stand in `k` already, to `out`. The estimated error is the mean over `tested` components of that of
            all but the last `untested`, over tolerance (1 + |y|): at most 1 for a good step. Components that rest
            have no error; `tested` leaves them out of the mean.
        dense: (rates, ..., t, h, y, k, out, dense) -> None. The coefficients of the step's dense output, n per power.

    The dots stand for arguments that are handed on to `rates`: (..., t, state) -> n rates, both tuples.
    """

    begin: Callable[..., None]
    step: Callable[..., float]
    dense: Callable[..., None]


@lru_cache(maxsize=64)
def unrolled(size: int, untested: int, arguments: tuple[str, ...]) -> Integrator:
    """The scheme for states of `size` components.

    Args:
        size: Number of components.
        untested: How many of them, at the end, the error estimate leaves out.
        arguments: Names of what `rates` takes before the time and the state.
    """
    given = "".join(f"{argument}, " for argument in arguments)
    name = f"<unrolled Dormand-Prince step, {size} components, {untested} untested, rates({given}t, state)>"
    source = "\n".join([*_begin(size, given), *_step(size, untested, given), *_dense(size, given), ""])
    linecache.cache[name] = (len(source), None, source.splitlines(keepends=True), name)  # for tracebacks
    space: dict[str, Any] = {"__name__": __name__, "math": math}
    exec(compile(source, name, "exec"), space)
    return Integrator(space["begin"], space["step"], space["dense"])


def _begin(n: int, given: str) -> Iterable[str]:
    """Source of `Integrator.begin`."""
    yield f"def begin(rates, {given}t, y, k):"
    yield from _unpacked("y", n, "y", 0)
    yield f"    {_all('k0', n)}, = rates({given}t, ({_all('y', n)},))"
    yield from (f"    k[{c}] = k0_{c}" for c in range(n))


def _step(n: int, untested: int, given: str) -> Iterable[str]:
    """Source of `Integrator.step`."""
    scheme = scipy.integrate.DOP853
    yield f"def step(rates, {given}t, h, y, k, out, tolerance, tested):"
    yield from _unpacked("y", n, "y", 0)
    yield from _unpacked("k0", n, "k", 0)
    for stage in range(1, STAGES):
        yield from _stage(stage, scheme.A[stage], scheme.C[stage], n, given)
    for c in range(n):
        yield f"    z_{c} = y_{c} + h * ({_sum(scheme.B, c)})"
    yield f"    {_all(f'k{STAGES}', n)}, = rates({given}t + h, ({_all('z', n)},))"
    for c in range(n):
        yield f"    out[{c}] = z_{c}"
    for stage in range(1, STAGES + 1):
        if stage not in _UNTESTED_STAGES:
            for c in range(n):
                yield f"    k[{stage * n + c}] = k{stage}_{c}"
    yield "    norm3 = norm5 = 0.0"
    for c in range(n - untested):
        yield f"    scale = 1.0 / (tolerance * (1.0 + max(abs(y_{c}), abs(z_{c}))))"
        yield f"    error3, error5 = scale * ({_sum(scheme.E3, c)}), scale * ({_sum(scheme.E5, c)})"
        yield "    norm3, norm5 = norm3 + error3 * error3, norm5 + error5 * error5"
    yield "    if norm5 == 0.0 and norm3 == 0.0:"
    yield "        return 0.0"
    yield "    return h * norm5 / math.sqrt((norm5 + 0.01 * norm3) * tested)"


def _dense(n: int, given: str) -> Iterable[str]:
    """Source of `Integrator.dense`."""
    scheme = scipy.integrate.DOP853
    yield f"def dense(rates, {given}t, h, y, k, out, dense):"
    yield from _unpacked("y", n, "y", 0)
    yield from _unpacked("z", n, "out", 0)
    for stage in range(STAGES + 1):
        if stage not in _UNTESTED_STAGES:
            yield from _unpacked(f"k{stage}", n, "k", stage * n)
    for extra in range(STAGES_WITH_DENSE - STAGES - 1):
        yield from _stage(STAGES + 1 + extra, scheme.A_EXTRA[extra], scheme.C_EXTRA[extra], n, given)
    for c in range(n):
        yield f"    change = z_{c} - y_{c}"
        yield f"    dense[{c}] = change"
        yield f"    dense[{n + c}] = h * k0_{c} - change"
        yield f"    dense[{2 * n + c}] = 2.0 * change - h * (k{STAGES}_{c} + k0_{c})"
        for power in range(3, POWERS):
            yield f"    dense[{power * n + c}] = h * ({_sum(scheme.D[power - 3], c)})"


def _stage(stage: int, weights: Iterable[float], place: float, n: int, given: str) -> Iterable[str]:
    """Rates of a stage, from those before it."""
    state = ", ".join(f"y_{c} + h * ({_sum(weights, c)})" for c in range(n))
    yield f"    {_all(f'k{stage}', n)}, = rates({given}t + {float(place)!r} * h, ({state},))"


def _sum(weights: Iterable[float], c: int) -> str:
    return " + ".join(f"{float(w)!r} * k{stage}_{c}" for stage, w in enumerate(weights) if w != 0.0)


def _all(name: str, n: int) -> str:
    return ", ".join(f"{name}_{c}" for c in range(n))


def _unpacked(name: str, n: int, array: str, first: int) -> Iterable[str]:
    for c in range(n):
        yield f"    {name}_{c} = {array}[{first + c}]"


def dense_at(coefficients: Sequence[float], n: int, component: int, y: float, x: float) -> float:
    """One component at the share x of the step; y is its value at the step's start."""
    value = 0.0
    for power in range(POWERS - 1, -1, -1):
        value = (value + coefficients[power * n + component]) * (x if power % 2 == 0 else 1.0 - x)
    return y + value


def dense_rate_at(coefficients: Sequence[float], n: int, component: int, x: float) -> float:
    """Derivative of `dense_at` by x."""
    value = rate = 0.0
    for power in range(POWERS - 1, -1, -1):
        value += coefficients[power * n + component]
        if power % 2 == 0:
            rate = rate * x + value
            value *= x
        else:
            rate = rate * (1.0 - x) - value
            value *= 1.0 - x
    return rate
