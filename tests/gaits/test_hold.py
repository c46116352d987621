"""The hold after the period: continuous to the acceleration, and its ends are what they are said to be."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.gaits.hold import FALLEN, hold, pieces_of
from mjbiped.gaits.reference import reference_at, table_of

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
    return [list(reference_at(table, t)) for t in (0.0, WIDTH, 2 * WIDTH, 3 * WIDTH)]


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
    for joint in range(1, round(table[1] / WIDTH)):
        before, after = (reference_at(table, joint * WIDTH + side) for side in (-1e-9, 1e-9))
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
    assert pieces_of(0.8, 1.0, 9.81) == 16
    assert pieces_of(0.8 * 2, 4.0, 9.81) == 16
    assert pieces_of(0.801, 1.0, 9.81) == 17
