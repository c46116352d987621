"""The Runge-Kutta scheme of the hybrid engine: Dormand and Prince's pair of order 8 with dense output of order 7.

Source: Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, sections II.5, II.6 and II.10 (DOP853); the
coefficients are SciPy's. The functions work on flat sequences of floats, lists in plain Python and arrays where
compiled; the rates of stage s stand at places s n to s n + n - 1 of `k`.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import Any, NamedTuple

from scipy.integrate._ivp import dop853_coefficients  # type: ignore[import-untyped, unused-ignore]

STAGES = 12  # of a step; the rates at its end are stage 12, the next step's stage 0
STAGES_WITH_DENSE = 16
POWERS = 7  # of the dense output


class Scheme(NamedTuple):
    """The coefficients, flat: places of the stages, their weights, two error estimates, dense output."""

    c: Any
    a: Any
    e3: Any
    e5: Any
    d: Any


def scheme() -> Scheme:
    """The coefficients as lists of floats."""
    known = dop853_coefficients
    return Scheme(
        c=known.C.tolist(),
        a=known.A.ravel().tolist(),
        e3=known.E3.tolist(),
        e5=known.E5.tolist(),
        d=known.D.ravel().tolist(),
    )


def stage_state(
    a: Sequence[float], stage: int, h: float, y: Sequence[float], k: Sequence[float], out: MutableSequence[float]
) -> None:
    """The state at which a stage's rates are taken; that of stage 12 is the state at the step's end."""
    n = len(y)
    for c in range(n):
        out[c] = 0.0
    for earlier in range(stage):
        weight = a[stage * STAGES_WITH_DENSE + earlier]
        if weight != 0.0:
            for c in range(n):
                out[c] += weight * k[earlier * n + c]
    for c in range(n):
        out[c] = y[c] + h * out[c]


def error_of(
    e3: Sequence[float],
    e5: Sequence[float],
    h: float,
    y: Sequence[float],
    end: Sequence[float],
    k: Sequence[float],
    tolerance: float,
) -> float:
    """Estimated error of the step's first n - 2 components over tolerance (1 + |y|); at most 1 for a good step."""
    n = len(y)
    norm3 = norm5 = 0.0
    for c in range(n - 2):
        error3 = error5 = 0.0
        for stage in range(STAGES + 1):
            rate = k[stage * n + c]
            error3 += e3[stage] * rate
            error5 += e5[stage] * rate
        scale = tolerance * (1.0 + max(abs(y[c]), abs(end[c])))
        norm3 += (error3 / scale) * (error3 / scale)
        norm5 += (error5 / scale) * (error5 / scale)
    if norm5 == 0.0 and norm3 == 0.0:
        return 0.0
    return h * norm5 / math.sqrt((norm5 + 0.01 * norm3) * (n - 2))


def dense_coefficients(
    d: Sequence[float],
    h: float,
    y: Sequence[float],
    end: Sequence[float],
    k: Sequence[float],
    out: MutableSequence[float],
) -> None:
    """Coefficients of the dense output, n per power, from all 16 stages."""
    n = len(y)
    for c in range(n):
        change = end[c] - y[c]
        out[c] = change
        out[n + c] = h * k[c] - change
        out[2 * n + c] = 2.0 * change - h * (k[STAGES * n + c] + k[c])
    for power in range(3, POWERS):
        first = power * n
        for c in range(n):
            out[first + c] = 0.0
        for stage in range(STAGES_WITH_DENSE):
            weight = h * d[(power - 3) * STAGES_WITH_DENSE + stage]
            if weight != 0.0:
                for c in range(n):
                    out[first + c] += weight * k[stage * n + c]


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
