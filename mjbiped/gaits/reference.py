"""A reference trajectory as controllers read it: pieces of polynomials, evaluated in plain floats.

`mjbiped.gaits.passive` makes the table of a passive gait; a control law evaluates it at every tick, wherever it runs.
"""

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Table: TypeAlias = tuple[float, float, Sequence[Sequence[float]] | NDArray[np.float64]]
"""(pieces per second, horizon in s, pieces): a piece is 20 floats, the coefficients c0..c9 of q1 and then of q2, lowest
power first, in the piece's own coordinate, which runs from 0 to 1."""


def reference_at(table: Table, t: float) -> tuple[float, float, float, float, float, float]:
    """(q1, q2, dq1, dq2, ddq1, ddq2) at time t >= 0 (not checked) in plain floats; see `Gait.reference` and `Table`."""
    rate, horizon, pieces = table
    late = t > horizon
    s = horizon * rate if late else t * rate
    k = min(int(s), len(pieces) - 1)
    q1, dq1, ddq1 = polynomial_at(pieces[k], 0, s - k)
    q2, dq2, ddq2 = polynomial_at(pieces[k], 10, s - k)
    if late:
        return q1, q2, 0.0, 0.0, 0.0, 0.0
    return q1, q2, rate * dq1, rate * dq2, rate * rate * ddq1, rate * rate * ddq2


def reference_discontinuity(table: Table, t: float) -> float:
    """The first time after t at which the trajectory has a kink, s: its end; infinity after it."""
    horizon = table[1]
    return horizon if t < horizon else math.inf


def in_arrays(table: Table) -> Table:
    """The same table for compiled code, which reads pieces from an array."""
    rate, horizon, pieces = table
    return rate, horizon, np.array(pieces, dtype=np.float64)


def polynomial_at(
    coefficients: Sequence[float] | NDArray[np.float64], first: int, s: float
) -> tuple[float, float, float]:
    """Value, first and second derivative at s, by Horner's rule, of ten coefficients from `first` on."""
    value = derivative = half = 0.0
    for k in range(first + 9, first - 1, -1):
        half = half * s + derivative
        derivative = derivative * s + value
        value = value * s + coefficients[k]
    return value, derivative, 2 * half
