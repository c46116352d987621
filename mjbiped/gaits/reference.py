"""A reference trajectory as control laws read it: pieces of polynomials in a flat table, evaluated at every tick.

A table is `HEADER` numbers (pieces per second, horizon in s, number of pieces, number of angles n), then the pieces. A
piece is 27 coefficients for each angle: of three polynomials in the piece's own coordinate, which runs from 0 to 1,
lowest power first, of degree 9 for the angle (rad), 8 for its rate (rad/s) and 7 for its acceleration (rad/s²). The
functions read a table that begins at an index of a sequence, so that it can stand among a law's parameters.
"""

import math
from collections.abc import MutableSequence, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Table: TypeAlias = list[float]
"""A table as a list, which plain Python reads faster than an array."""

HEADER = 4
"""Numbers before the first piece of a table."""

RATE, HORIZON, PIECES, WIDTH = range(HEADER)
"""Indices in a table of pieces per second, horizon (s), number of pieces, and number of angles."""

MOST = 3
"""Greatest number of angles: rates and accelerations are written so far behind the angles."""

_RATES, _ACCELERATIONS, _COEFFICIENTS = 10, 19, 27  # of one angle in a piece


def reference_at(table: Sequence[float], first: int, t: float, out: MutableSequence[float], place: int) -> None:
    """Write angles, rates and accelerations of a trajectory at a time; beyond the horizon its last posture rests.

    Args:
        table: Numbers among which the table stands.
        first: Index at which the table begins.
        t: Time since the touchdown, s, not less than 0 (not checked).
        out: Receives the n angles (rad) from the index `place` on, their rates (rad/s) from `place + MOST` on, and
            their accelerations (rad/s²) from `place + 2 * MOST` on.
        place: That index.
    """
    rate, horizon, width = table[first], table[first + HORIZON], int(table[first + WIDTH])
    late = t > horizon
    s = horizon * rate if late else t * rate
    k = min(int(s), int(table[first + PIECES]) - 1)
    c = first + HEADER + _COEFFICIENTS * width * k
    s -= k
    s2 = s * s
    s4 = s2 * s2
    s8 = s4 * s4
    _angle_at(table, c, (s, s2, s4, s8), late, out, place)
    if width > 1:  # written out: a loop is slower, interpreted and compiled
        _angle_at(table, c + _COEFFICIENTS, (s, s2, s4, s8), late, out, place + 1)
    if width > 2:
        _angle_at(table, c + 2 * _COEFFICIENTS, (s, s2, s4, s8), late, out, place + 2)


def _angle_at(
    table: Sequence[float],
    c: int,
    powers: tuple[float, float, float, float],
    late: bool,
    out: MutableSequence[float],
    at: int,
) -> None:
    """Write angle, rate and acceleration of one angle, whose coefficients begin at the index c."""
    s, s2, s4, s8 = powers
    out[at] = _degree_7(table, c, s, s2, s4) + (table[c + 8] + table[c + 9] * s) * s8
    if late:
        out[at + MOST] = out[at + 2 * MOST] = 0.0
        return
    out[at + MOST] = _degree_7(table, c + _RATES, s, s2, s4) + table[c + _RATES + 8] * s8
    out[at + 2 * MOST] = _degree_7(table, c + _ACCELERATIONS, s, s2, s4)


def motion_at(table: Sequence[float], t: float) -> tuple[float, ...]:
    """Return the n angles of a trajectory at a time, their rates and their accelerations; see `reference_at`."""
    width, out = int(table[WIDTH]), [0.0] * (3 * MOST)
    reference_at(table, 0, t, out, 0)
    return (*out[:width], *out[MOST : MOST + width], *out[2 * MOST : 2 * MOST + width])


def table_of(rate: float, coefficients: NDArray[np.float64]) -> Table:
    """Return the table of a trajectory in pieces.

    Args:
        rate: Pieces per second.
        coefficients: Of the n angles in each piece, rad, shape (pieces, 10, n), lowest power first.
    """
    powers = np.arange(1, 10)[:, None]
    rates = rate * powers * coefficients[:, 1:]
    accelerations = rate * powers[:-1] * rates[:, 1:]
    rows = np.concatenate([coefficients, rates, accelerations], axis=1)
    pieces, width = len(coefficients), coefficients.shape[2]
    return [rate, pieces / rate, float(pieces), float(width), *rows.transpose(0, 2, 1).ravel().tolist()]


def reference_discontinuity(table: Sequence[float], first: int, t: float) -> float:
    """Return the first time after t at which a trajectory has a kink, s: its horizon; infinity after it."""
    horizon = table[first + HORIZON]
    return horizon if t < horizon else math.inf


def _degree_7(c: Sequence[float], first: int, s: float, s2: float, s4: float) -> float:
    """Evaluate a polynomial by Estrin's scheme, whose sums do not wait for each other; c0 stands at `first`."""
    low = (c[first] + c[first + 1] * s) + (c[first + 2] + c[first + 3] * s) * s2
    high = (c[first + 4] + c[first + 5] * s) + (c[first + 6] + c[first + 7] * s) * s2
    return low + high * s4
