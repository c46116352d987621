"""Bézier curves against SciPy's Bernstein polynomials, and their pieces against the curves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from mjbiped.gaits.bezier import DEGREE, bernstein, curve, in_pieces
from mjbiped.gaits.reference import reference_at, table_of

control_points = st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=DEGREE + 1, max_size=DEGREE + 1).map(
    np.array
)
durations = st.floats(0.1, 3.0)


@given(control_points, durations, st.floats(0, 1))
@settings(deadline=None, derandomize=True)
def test_curve_and_derivatives_are_scipys(points: np.ndarray, duration: float, s: float) -> None:
    expected = BPoly(points[:, None, :], [0.0, duration])
    found = curve(points, np.array([s]), duration)
    for order, values in enumerate(found):
        # rounding: each derivative multiplies differences of numbers near 1 by at most 7 / T
        tolerance = 1e-13 * (4 * DEGREE / duration) ** order
        np.testing.assert_allclose(values[0], expected.derivative(order)(s * duration), rtol=0, atol=tolerance)


@given(control_points, durations, st.integers(1, 20), st.floats(0, 1, exclude_max=True))
@settings(deadline=None, derandomize=True)
def test_the_table_in_pieces_is_the_curve(points: np.ndarray, duration: float, count: int, s: float) -> None:
    table = table_of(count / duration, in_pieces(points, count))
    q, dq, ddq = (values[0] for values in curve(points, np.array([s]), duration))
    found = reference_at(table, s * duration)
    # a piece's coefficients carry rounding of the solution of ten equations, whose condition number is 1e6; each
    # derivative multiplies it by the pieces per second and by at most 9
    for order, (values, expected) in enumerate(zip(np.reshape(found, (3, 2)), (q, dq, ddq), strict=True)):
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-11 * (9 * max(1.0, count / duration)) ** order)


def test_bernsteins_polynomials_add_up_to_one() -> None:
    s = np.linspace(0, 1, 11)
    np.testing.assert_allclose(bernstein(DEGREE, s).sum(axis=-1), 1.0, rtol=1e-14)
    assert bernstein(DEGREE, s).shape == (11, DEGREE + 1)


def test_complex_steps_give_derivatives() -> None:
    points = np.linspace(0, 1, DEGREE + 1)[:, None] ** 2
    step = 1e-30
    q, dq, _ = curve(points, np.array([0.3 + 1j * step]), 1.0)
    assert q.imag[0, 0] / step == pytest.approx(dq.real[0, 0], rel=1e-13)
