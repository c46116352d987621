"""Bézier curves: Bernstein's polynomials, derivatives by differences of control points, and powers for tables.

Control points stand along the last axis but one; the last axis are the joints.
"""

from __future__ import annotations

from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

DEGREE = 7
"""Of a reference: angle, rate and acceleration are free at both ends, and two points more."""

Numbers = NDArray[Any]
"""Real numbers, or complex ones, whose imaginary parts carry derivatives (complex step)."""


def bernstein(degree: int, s: Numbers) -> Numbers:
    """Bernstein's polynomials of a degree at s, shape s.shape + (degree + 1,)."""
    return np.stack([comb(degree, k) * s**k * (1 - s) ** (degree - k) for k in range(degree + 1)], axis=-1)


def curve(points: Numbers, s: Numbers, duration: Numbers | float) -> tuple[Numbers, Numbers, Numbers]:
    """A curve and its first two derivatives with respect to time.

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


def in_pieces(points: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """A curve in equal pieces, each a polynomial of degree 9 in its own coordinate from 0 to 1, lowest power first.

    Args:
        points: Control points, shape (n + 1, joints), n at most 9.
        count: Of pieces.

    Returns:
        Coefficients, shape (count, 10, joints); exact but for rounding.
    """
    return np.stack([powers_through(bernstein(len(points) - 1, (k + NODES) / count) @ points) for k in range(count)])


def powers_through(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The polynomials of degree 9 through values at `NODES`: coefficients, lowest power first, shape (10, ...)."""
    return np.asarray(np.linalg.solve(_MATRIX, values), dtype=np.float64)


NODES: NDArray[np.float64] = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 10))
"""Chebyshev's ten points of the second kind on 0 to 1, ends included."""

_MATRIX = np.vander(NODES, increasing=True)
