"""Sine and cosine: against mpmath to the last place, and their polynomials fitted again."""

import math
from collections.abc import Callable

import mpmath  # type: ignore[import-untyped]
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.numerics import trigonometry
from mjbiped.numerics.trigonometry import EIGHTH_TURN, sine_cosine

EPSILON = float(np.finfo(np.float64).eps)


@pytest.mark.slow
@given(st.floats(-EIGHTH_TURN, EIGHTH_TURN))
@settings(deadline=None, derandomize=True, max_examples=2000)
def test_both_are_exact_to_one_unit_in_the_last_place(x: float) -> None:
    for found, exact in zip(sine_cosine(x), (mpmath.sin(x), mpmath.cos(x)), strict=True):
        assert abs(mpmath.mpf(found) - exact) <= math.ulp(float(exact))


@given(st.floats(-1e6, 1e6))
@settings(deadline=None, derandomize=True)
def test_every_angle_has_them(x: float) -> None:
    """Beyond the eighth turn those of the mathematical library; on it the two ways meet."""
    assert sine_cosine(x) == pytest.approx((math.sin(x), math.cos(x)), rel=0, abs=EPSILON)


def test_what_is_no_number_stays_so() -> None:
    assert all(map(math.isnan, sine_cosine(math.nan)))
    assert sine_cosine(0.0) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("letter", "rest", "power"),
    [
        ("S", lambda x: (mpmath.sin(x) - x) / x**3, 2),  # relative to x
        ("C", lambda x: (mpmath.cos(x) - 1 + x**2 / 2) / x**4, 4),
    ],
)
def test_polynomials_are_the_interpolants_that_they_are_said_to_be(
    letter: str, rest: Callable[[mpmath.mpf], mpmath.mpf], power: int
) -> None:
    mpmath.mp.dps = 40
    count, top = 6, mpmath.mpf(EIGHTH_TURN) ** 2
    nodes = [top / 2 * (1 + mpmath.cos((2 * k + 1) * mpmath.pi / (2 * count))) for k in range(count)]
    matrix = mpmath.matrix(count, count)
    for row, z in enumerate(nodes):
        for column in range(count):
            matrix[row, column] = z**column
    fitted = mpmath.lu_solve(matrix, mpmath.matrix([rest(mpmath.sqrt(z)) for z in nodes]))
    coefficients = [getattr(trigonometry, f"_{letter}{k}") for k in range(count)]
    np.testing.assert_allclose(coefficients, [float(value) for value in fitted], rtol=1e-12)
    for k in range(1, 400):
        x = mpmath.mpf(EIGHTH_TURN) * k / 400
        polynomial = sum(c * x ** (2 * n) for n, c in enumerate(coefficients))
        assert abs(polynomial - rest(x)) * x**power < 0.2 * EPSILON  # a fifth of what rounding adds
