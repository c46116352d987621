"""Transition curves of section IV-B: conditions at both ends, SciPy's Bernstein polynomials, any quintic."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from scipy.interpolate import BPoly

from mjbiped.controllers.replanning import transition, transition_at

durations = st.floats(0.02, 3.0)
ends = st.tuples(
    st.floats(-1.5, 1.5),
    st.floats(-8, 8),
    st.floats(-60, 60),
    st.floats(-1.5, 1.5),
    st.floats(-8, 8),
    st.floats(-60, 60),
)

RELATIVE = 1e-14  # rounding of a few dozen operations, relative to the control points


def tolerances(points: tuple[float, ...], duration: float) -> tuple[float, float, float]:
    """Rounding of angle, rate and acceleration: the second difference of control points is divided by t_c^2 / 20."""
    size = max(map(abs, points)) + 1e-300
    return RELATIVE * size, RELATIVE * 10 * size / duration, RELATIVE * 80 * size / duration**2


@given(durations, ends)
@settings(deadline=None, derandomize=True)
def test_curve_has_the_given_position_rate_and_acceleration_at_both_ends(
    duration: float, conditions: tuple[float, float, float, float, float, float]
) -> None:
    points = transition(duration, conditions[:3], conditions[3:])
    found = [*transition_at(points, 0, duration, 0.0), *transition_at(points, 0, duration, duration)]
    for value, expected, tolerance in zip(found, conditions, tolerances(points, duration) * 2, strict=True):
        assert value == pytest.approx(expected, rel=0, abs=tolerance)
    assert (points[0], points[5]) == (conditions[0], conditions[3])


@given(durations, st.tuples(*[st.floats(-3, 3)] * 6), st.floats(0, 1))
@settings(deadline=None, derandomize=True)
def test_curve_and_derivatives_are_scipys_bernstein_polynomials(
    duration: float, points: tuple[float, ...], part: float
) -> None:
    t = part * duration
    curve = BPoly(np.array(points)[:, None], [0.0, duration])
    expected = [float(curve(t)), float(curve.derivative(1)(t)), float(curve.derivative(2)(t))]
    for value, other, tolerance in zip(
        transition_at(points, 0, duration, t), expected, tolerances(points, duration), strict=True
    ):
        assert value == pytest.approx(other, rel=0, abs=tolerance)


@given(durations, st.tuples(*[st.floats(-3, 3)] * 6), st.floats(0, 1))
@settings(deadline=None, derandomize=True)
def test_any_polynomial_of_degree_five_is_reproduced(
    duration: float, coefficients: tuple[float, ...], part: float
) -> None:
    motion = Polynomial(np.array(coefficients), domain=[0.0, duration], window=[0.0, 1.0])
    rate, acceleration = motion.deriv(1), motion.deriv(2)
    start, end = ((float(motion(t)), float(rate(t)), float(acceleration(t))) for t in (0.0, duration))
    points = transition(duration, start, end)
    t = part * duration
    # the conditions at the ends carry rounding of their own: of the sum of coefficients, times up to 20
    size = 20 * sum(map(abs, coefficients)) + 1e-300
    for value, f, power in zip(
        transition_at(points, 0, duration, t), (motion, rate, acceleration), range(3), strict=True
    ):
        assert value == pytest.approx(float(f(t)), rel=0, abs=RELATIVE * 4**power * size / duration**power)


def test_control_points_are_found_at_any_place() -> None:
    points = transition(0.6, (0.1, 1.0, -2.0), (-0.3, 0.5, 4.0))
    memory = [7.0] * 4 + list(points) + [9.0] * 3
    assert transition_at(memory, 4, 0.6, 0.25) == transition_at(points, 0, 0.6, 0.25)  # the same operations


def test_uniform_motion_is_a_straight_line() -> None:
    """Uniform motion to an end that it reaches anyway: equidistant control points."""
    points = transition(0.5, (0.2, 3.0, 0.0), (0.2 + 3.0 * 0.5, 3.0, 0.0))
    np.testing.assert_allclose(np.diff(points), 0.3, rtol=0, atol=1e-15)  # rounding of numbers near 1
