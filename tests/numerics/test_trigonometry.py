"""Sine and cosine: against mpmath to the last place."""

import math

import mpmath  # type: ignore[import-untyped]
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mjbiped.numerics.trigonometry import EIGHTH_TURN, sine_cosine

EPSILON = float(np.finfo(np.float64).eps)


@given(st.floats(-EIGHTH_TURN, EIGHTH_TURN))
@example(EIGHTH_TURN)
@settings(deadline=None, derandomize=True, max_examples=500)
def test_both_are_exact_to_one_unit_in_the_last_place(x: float) -> None:
    for found, exact in zip(sine_cosine(x), (mpmath.sin(x), mpmath.cos(x)), strict=True):
        assert abs(mpmath.mpf(found) - exact) <= math.ulp(float(exact))


@given(st.floats(-1e6, 1e6))
@example(0.0)
@settings(deadline=None, derandomize=True)
def test_every_angle_has_them(x: float) -> None:
    """Beyond the eighth turn those of the mathematical library; on it the two ways meet."""
    assert sine_cosine(x) == pytest.approx((math.sin(x), math.cos(x)), rel=0, abs=EPSILON)
    assert all(map(math.isnan, sine_cosine(math.nan)))
