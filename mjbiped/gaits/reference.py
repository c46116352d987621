"""A reference trajectory as control laws read it: pieces of polynomials, evaluated in plain floats at every tick."""

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Table: TypeAlias = tuple[float, float, Sequence[Sequence[float]] | NDArray[np.float64]]
"""(pieces per second, horizon in s, pieces): a piece is 54 floats, the coefficients of three polynomials in the piece's
own coordinate, which runs from 0 to 1, lowest power first: of degree 9 for the angles (rad), 8 for their rates (rad/s),
and 7 for their accelerations (rad/s²). Of each power stands q1's, then q2's."""

_RATES, _ACCELERATIONS = 20, 38  # where their coefficients begin


def reference_at(table: Table, t: float) -> tuple[float, float, float, float, float, float]:
    """(q1, q2, dq1, dq2, ddq1, ddq2) at time t >= 0 (not checked) in plain floats; see `Gait.reference` and `Table`."""
    rate, horizon, pieces = table
    late = t > horizon
    s = horizon * rate if late else t * rate
    k = min(int(s), len(pieces) - 1)
    piece = pieces[k]
    s -= k
    s2 = s * s
    s4 = s2 * s2
    s8 = s4 * s4
    q1, q2 = _degree_9(piece, 0, s, s2, s4, s8), _degree_9(piece, 1, s, s2, s4, s8)
    if late:
        return q1, q2, 0.0, 0.0, 0.0, 0.0
    return (
        q1,
        q2,
        _degree_8(piece, _RATES, s, s2, s4, s8),
        _degree_8(piece, _RATES + 1, s, s2, s4, s8),
        _degree_7(piece, _ACCELERATIONS, s, s2, s4),
        _degree_7(piece, _ACCELERATIONS + 1, s, s2, s4),
    )


def table_of(rate: float, coefficients: NDArray[np.float64]) -> Table:
    """The table of a trajectory in pieces.

    Args:
        rate: Pieces per second.
        coefficients: Of both angles in each piece, rad, shape (pieces, 10, 2), lowest power first.
    """
    powers = np.arange(1, 10)[:, None]
    rates = rate * powers * coefficients[:, 1:]
    accelerations = rate * powers[:-1] * rates[:, 1:]
    rows = np.concatenate([coefficients, rates, accelerations], axis=1).reshape(len(coefficients), -1)
    return rate, len(coefficients) / rate, tuple(map(tuple, rows.tolist()))


def reference_discontinuity(table: Table, t: float) -> float:
    """The first time after t at which the trajectory has a kink, s: its end; infinity after it."""
    horizon = table[1]
    return horizon if t < horizon else math.inf


def in_arrays(values: Any) -> Any:
    """A table, or a law's parameters with tables in them, for compiled code, which reads pieces from an array."""
    if not isinstance(values, tuple):
        return values
    if type(values) is tuple and _are_pieces(values):
        return np.array(values, dtype=np.float64)
    return getattr(values, "_make", tuple)(map(in_arrays, values))


def _are_pieces(values: tuple[Any, ...]) -> bool:
    """Whether a tuple holds rows of numbers, all of one length, as those of `table_of`; parameters may begin so."""
    rows = [each for each in values if type(each) is tuple and each and isinstance(each[0], float)]
    return bool(values) and len(rows) == len(values) and len(set(map(len, rows))) == 1


def _degree_7(c: Sequence[float] | NDArray[np.float64], first: int, s: float, s2: float, s4: float) -> float:
    """A polynomial by Estrin's scheme, whose sums do not wait for each other; every other number from `first` on."""
    low = (c[first] + c[first + 2] * s) + (c[first + 4] + c[first + 6] * s) * s2
    high = (c[first + 8] + c[first + 10] * s) + (c[first + 12] + c[first + 14] * s) * s2
    return low + high * s4


def _degree_8(c: Sequence[float] | NDArray[np.float64], first: int, s: float, s2: float, s4: float, s8: float) -> float:
    return _degree_7(c, first, s, s2, s4) + c[first + 16] * s8


def _degree_9(c: Sequence[float] | NDArray[np.float64], first: int, s: float, s2: float, s4: float, s8: float) -> float:
    return _degree_7(c, first, s, s2, s4) + (c[first + 16] + c[first + 18] * s) * s8
