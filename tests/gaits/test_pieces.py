"""Bézier curves against SciPy's Bernstein polynomials, their pieces against the curves, and the hold after a period."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from mjbiped.gaits.reference import (
    DEGREE,
    FALLEN,
    HORIZON,
    count_of_pieces,
    curve,
    curve_in_pieces,
    hold,
    motion_at,
    table_of,
)

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
    table = table_of(count / duration, curve_in_pieces(points, count))
    q, dq, ddq = (values[0] for values in curve(points, np.array([s]), duration))
    found = motion_at(table, s * duration)
    # a piece's coefficients carry rounding of the solution of ten equations, whose condition number is 1e6; each
    # derivative multiplies it by the pieces per second and by at most 9
    for order, (values, expected) in enumerate(zip(np.reshape(found, (3, 2)), (q, dq, ddq), strict=True)):
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-11 * (9 * max(1.0, count / duration)) ** order)


WIDTH = 0.05
ends = st.tuples(
    st.floats(0.05, 0.3),
    st.floats(-0.3, -0.05),
    st.floats(0.3, 2),
    st.floats(-2, 2),
    st.floats(-9, 9),
    st.floats(-20, 20),
)


def trajectory(end: tuple[float, ...], most: int = 16) -> list[list[float]]:
    """Angles, rates and accelerations at the hold's beginning, its marks, and its end."""
    q, dq, ddq = np.reshape(end, (3, 2))
    table = table_of(1 / WIDTH, hold(q, dq, ddq, WIDTH, most))
    return [list(motion_at(table, t)) for t in (0.0, WIDTH, 2 * WIDTH, 3 * WIDTH)]


@given(ends)
@settings(deadline=None, derandomize=True)
def test_it_begins_where_the_step_ends_and_comes_to_rest(end: tuple[float, ...]) -> None:
    begin, one, two, _ = trajectory(end)
    # rounding of coefficients (1e-13 of numbers near 1), times the squared pieces per second and 9 * 8
    np.testing.assert_allclose(begin, end, rtol=0, atol=1e-8)
    assert one[4] == pytest.approx(0.0, abs=1e-8)  # the stance leg's acceleration, within 0.05 s
    assert two[3] == pytest.approx(0.0, abs=1e-9)  # the swing leg's rate, within 0.1 s, and its acceleration
    assert two[5] == pytest.approx(0.0, abs=1e-8)


@given(ends)
@settings(deadline=None, derandomize=True)
def test_it_is_twice_continuously_differentiable(end: tuple[float, ...]) -> None:
    q, dq, ddq = np.reshape(end, (3, 2))
    table = table_of(1 / WIDTH, hold(q, dq, ddq, WIDTH, 16))
    for joint in range(1, round(table[HORIZON] / WIDTH)):
        before, after = (motion_at(table, joint * WIDTH + side) for side in (-1e-9, 1e-9))
        # what changes within 2e-9 s: rates of 3 rad/s, accelerations of 30 rad/s², jerks of 2e3 rad/s³
        for k, tolerance in enumerate((1e-8, 1e-8, 1e-7, 1e-7, 1e-5, 1e-5)):
            assert after[k] == pytest.approx(before[k], abs=tolerance)


def test_the_swing_leg_rests_and_the_stance_leg_goes_on() -> None:
    *_, two, three = trajectory((0.2, -0.2, 1.0, 0.9, 5.0, -8.0))
    assert three[1] == pytest.approx(two[1], abs=1e-12)
    assert three[2] == pytest.approx(1.0 + 0.5 * WIDTH * 5.0, rel=1e-9)  # the integral of 5 (1 - 3u² + 2u³)
    assert three[0] - two[0] == pytest.approx(WIDTH * three[2], rel=1e-9)


def test_it_ends_before_the_stance_leg_has_fallen() -> None:
    pieces = hold(np.array([0.3, -0.3]), np.array([3.0, 0.0]), np.zeros(2), WIDTH, 40)
    assert len(pieces) == math.floor((FALLEN - 0.3) / (3.0 * WIDTH))


def test_pieces_scale_with_the_leg_and_gravity() -> None:
    assert count_of_pieces(0.8, 1.0, 9.81) == 16
    assert count_of_pieces(0.8 * 2, 4.0, 9.81) == 16
    assert count_of_pieces(0.801, 1.0, 9.81) == 17
