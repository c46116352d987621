"""The compass's step on arrays against the robot's own matrices and impact map, and MuJoCo's inverse dynamics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.gaits.steps import CompassStep
from mjbiped.robots.compass import Compass

ROBOT = Compass(leg_mass=4.0, hip_mass=3.0, lower_length=0.45, upper_length=0.4, leg_inertia=0.2)
MODEL = CompassStep(ROBOT)
angles, rates, accelerations = (st.tuples(st.floats(-r, r), st.floats(-r, r)).map(np.array) for r in (0.6, 3.0, 20.0))


@given(angles, rates, accelerations)
@settings(deadline=None, derandomize=True)
def test_course_is_the_robots_own_equations(q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> None:
    course = MODEL.course(q[None], dq[None], ddq[None])
    force = ROBOT.mass_matrix(q) @ ddq + ROBOT.coriolis_matrix(q, dq) @ dq + ROBOT.gravity_vector(q, 0.0)
    torque = np.linalg.solve(ROBOT.input_matrix, force)
    np.testing.assert_allclose(course.torques[0], torque, rtol=0, atol=1e-11)  # rounding of forces of some 100 N m
    expected = [torque[0] * dq[0], torque[1] * (dq[1] - dq[0])]
    np.testing.assert_allclose(course.powers[0], expected, rtol=0, atol=1e-10)
    ahead, height = ROBOT.swing_foot(q)
    assert (course.ahead[0], course.height[0]) == pytest.approx((ahead, height), abs=1e-15)
    step = 1e-6
    later = ROBOT.swing_foot(q + step * dq) - ROBOT.swing_foot(q - step * dq)
    # central differences: the third derivative is below 30, rounding 1e-16 / step
    np.testing.assert_allclose([course.ahead_rate[0], course.height_rate[0]], later / (2 * step), rtol=0, atol=1e-9)


@given(st.floats(0.05, 0.5), rates)
@settings(deadline=None, derandomize=True)
def test_impact_is_the_robots_own(half: float, dq: np.ndarray) -> None:
    start, end = MODEL.postures(np.array(half))
    q, after = ROBOT.impact(end, dq)
    np.testing.assert_array_equal(q, start)
    np.testing.assert_allclose(MODEL.rates_after_impact(np.array(half), dq), after, rtol=0, atol=1e-13)  # rounding
    assert MODEL.step_length(np.array(half)) == pytest.approx(ROBOT.swing_foot(end)[0], rel=1e-14)
