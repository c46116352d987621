"""Reference trajectories: pieces of polynomials in a flat table, which control laws evaluate at every tick.

A table is `HEADER` numbers (pieces per second, horizon in s, number of pieces, number of angles n), then the pieces. A
piece is 27 coefficients for each angle: of three polynomials in the piece's own coordinate, which runs from 0 to 1,
lowest power first, of degree 9 for the angle (rad), 8 for its rate (rad/s) and 7 for its acceleration (rad/s²). The
functions read a table that begins at an index of a sequence, so that it can stand among a law's parameters.

Where a touchdown is late, a reference comes to rest without a jerk. The swing leg's rate decays to zero, and the
posture is held: a foot that is carried on would run away from the ground. The stance leg's acceleration decays to zero,
and the leg goes on falling evenly, as an inverted pendulum does. Angle, rate and acceleration are continuous.

Control points of Bézier curves stand along the last axis but one; the last axis are the joints.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, MutableSequence, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.robots.robot import Array

Table: TypeAlias = list[float]
"""A table as a list, which plain Python reads faster than an array."""

HEADER = 4
"""Numbers before the first piece of a table."""

RATE, HORIZON, PIECES, WIDTH = range(HEADER)
"""Indices in a table of pieces per second, horizon (s), number of pieces, and number of angles."""

MOST = 3
"""Greatest number of angles: rates and accelerations are written so far behind the angles."""

_RATES, _ACCELERATIONS, _COEFFICIENTS = 10, 19, 27  # of one angle in a piece

DEGREE = 7
"""Degree of a reference's Bézier curves: angle, rate and acceleration are free at both ends, and two points more."""

HOLD = 0.05 * math.sqrt(9.81)
"""Time in which the stance leg's acceleration decays, in sqrt(l/g): 0.05 s for legs of 1 m; twice that for the swing
leg's rate. It is rounded so that the period is a whole number of them."""

FALLEN = math.radians(60)
"""A reference ends where the stance leg has fallen this far from the normal."""

Numbers = NDArray[Any]
"""Real numbers, or complex ones, whose imaginary parts carry derivatives (complex step)."""

NODES: Array = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 10))
"""Chebyshev's ten points of the second kind on 0 to 1, ends included."""

_MATRIX = np.vander(NODES, increasing=True)


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
    """Return the n angles of a trajectory at a time, their rates and their accelerations; see `reference_at`.

    It takes tables of any number of angles.
    """
    rate, horizon, width = table[0], table[HORIZON], int(table[WIDTH])
    s = min(t, horizon) * rate
    k = min(int(s), int(table[PIECES]) - 1)
    s -= k
    s2 = s * s
    powers = (s, s2, s2 * s2, s2 * s2 * (s2 * s2))
    first, out, found = HEADER + _COEFFICIENTS * width * k, [0.0] * (2 * MOST + 1), list[tuple[float, ...]]()
    for angle in range(width):
        _angle_at(table, first + _COEFFICIENTS * angle, powers, t > horizon, out, 0)
        found.append((out[0], out[MOST], out[2 * MOST]))
    angles, rates, accelerations = zip(*found, strict=True)
    return (*angles, *rates, *accelerations)


def table_of(rate: float, coefficients: Array) -> Table:
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


def beside(table: Table, more: Array) -> Table:
    """Return a table with one angle more, behind the others.

    Args:
        table: A trajectory.
        more: Coefficients of the angle in each of the table's pieces, rad, shape (pieces, 10).
    """
    rows = np.reshape(table[HEADER:], (int(table[PIECES]), int(table[WIDTH]), _COEFFICIENTS))
    return table_of(table[RATE], np.concatenate([rows[:, :, :10].transpose(0, 2, 1), more[:, :, None]], axis=2))


def reference_discontinuity(table: Sequence[float], first: int, t: float) -> float:
    """Return the first time after t at which a trajectory has a kink, s: its horizon; infinity after it."""
    horizon = table[first + HORIZON]
    return horizon if t < horizon else math.inf


def _degree_7(c: Sequence[float], first: int, s: float, s2: float, s4: float) -> float:
    """Evaluate a polynomial by Estrin's scheme, whose sums do not wait for each other; c0 stands at `first`."""
    low = (c[first] + c[first + 1] * s) + (c[first + 2] + c[first + 3] * s) * s2
    high = (c[first + 4] + c[first + 5] * s) + (c[first + 6] + c[first + 7] * s) * s2
    return low + high * s4


def bernstein(degree: int, s: Numbers) -> Numbers:
    """Bernstein's polynomials of a degree at s, shape s.shape + (degree + 1,)."""
    return np.stack([math.comb(degree, k) * s**k * (1 - s) ** (degree - k) for k in range(degree + 1)], axis=-1)


def curve(points: Numbers, s: Numbers, duration: Numbers | float) -> tuple[Numbers, Numbers, Numbers]:
    """A Bézier curve and its first two derivatives with respect to time.

    SciPy's `BPoly` takes one curve at a time; the optimiser needs a batch of complex ones.

    Args:
        points: Control points, shape (..., n + 1, joints).
        s: Phases from 0 to 1, shape (..., m).
        duration: Time that the curve takes, shape (...).

    Returns:
        Each of shape (..., m, joints).
    """
    degree = points.shape[-2] - 1
    time = np.asarray(duration)[..., None, None]
    first = degree * np.diff(points, axis=-2) / time
    second = (degree - 1) * np.diff(first, axis=-2) / time
    return bernstein(degree, s) @ points, bernstein(degree - 1, s) @ first, bernstein(degree - 2, s) @ second


def in_pieces(motion: Callable[[Array], Array], numbers: Iterable[int]) -> Array:
    """A motion in equal pieces, each a polynomial of degree 9 in its own coordinate from 0 to 1, lowest power first.

    Args:
        motion: Values at places along the pieces: the first piece reaches from 0 to 1, the second from 1 to 2.
        numbers: The pieces wanted, counted from 0.

    Returns:
        Coefficients, shape (pieces, 10, ...).
    """
    return np.stack([np.linalg.solve(_MATRIX, motion(number + NODES)) for number in numbers])


def curve_in_pieces(points: Array, count: int) -> Array:
    """A Bézier curve of degree 9 at most in equal pieces, exact but for rounding: shape (count, 10, joints)."""
    return in_pieces(lambda place: bernstein(len(points) - 1, place / count) @ points, range(count))


def count_of_pieces(period: float, length: float, gravity: float) -> int:
    """Return the number of pieces, each at most `HOLD` long, that make up a period.

    Args:
        period: s.
        length: Length of a leg, m.
        gravity: m/s².
    """
    return math.ceil(period / (HOLD * math.sqrt(length / gravity)))


def hold(angles: Array, rates: Array, accelerations: Array, width: float, most: int) -> Array:
    """The motion after the period.

    Args:
        angles: Angles at the period's end, rad, stance leg first.
        rates: Their rates there, rad/s.
        accelerations: Their accelerations there, rad/s².
        width: Duration of a piece, s.
        most: Greatest number of pieces.

    Returns:
        Coefficients as of `in_pieces`; the last piece is the one before the stance leg has fallen by `FALLEN`.
    """
    stance = _even(angles[0], rates[0], accelerations[0], width)

    def motion(place: Array) -> Array:
        swing = angles[1] + _rate_decays(width * place, rates[1], accelerations[1], 2.0 * width)
        return np.stack([stance(place), swing], axis=-1)

    fallen = (k for k in range(1, most) if abs(motion(k + NODES)[-1, 0]) > FALLEN)
    return in_pieces(motion, range(next(fallen, most)))


def closing_on(flexion: float, rate: float, acceleration: float, width: float, count: int) -> Array:
    """The flexion of a knee that is driven on past its stop at an even rate: coefficients, shape (count, 10).

    Args:
        flexion: Flexion at the beginning, rad.
        rate: Its rate there, rad/s.
        acceleration: Its acceleration there, rad/s², which decays within a piece.
        width: Duration of a piece, s.
        count: Number of pieces.
    """
    return in_pieces(_even(flexion, rate, acceleration, width), range(count))


def _even(angle: float, rate: float, acceleration: float, width: float) -> Callable[[Array], Array]:
    """A motion whose acceleration falls to zero as 1 - 3 u² + 2 u³ within a piece of a width, s; it then is even."""

    def motion(place: Array) -> Array:
        t = width * place
        u = np.minimum(t / width, 1.0)
        until = width * width * (u**2 / 2 - u**4 / 4 + u**5 / 10)
        return np.asarray(angle + rate * t + acceleration * (until + 0.5 * width * np.maximum(t - width, 0.0)))

    return motion


def _rate_decays(t: Array, rate: float, acceleration: float, end: float) -> Array:
    """Angle due to a rate and an acceleration that both decay to zero at the time `end`; the rate is a cubic."""
    u = np.minimum(t / end, 1.0)
    of_rate = end * (u - u**3 + u**4 / 2)
    of_acceleration = end * end * (u**2 / 2 - 2 * u**3 / 3 + u**4 / 4)
    return np.asarray(rate * of_rate + acceleration * of_acceleration)
