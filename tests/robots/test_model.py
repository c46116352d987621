"""The equations for people's own laws against the robots' methods."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL

import mjbiped
from mjbiped.robots.model import (
    Numbers,
    coriolis_matrix,
    gravity_vector,
    mass_matrix,
    rates_after_knee_strike,
    rates_after_touchdown,
)
from mjbiped.robots.robot import Robot

ROBOTS = [
    mjbiped.Compass(),
    mjbiped.Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62),
    mjbiped.KneedBiped(),
    mjbiped.KneedBiped.halved_rods(),
    UNEQUAL,
    mjbiped.RimlessWheel(),
    mjbiped.RimlessWheel(mass=3.0, inertia=0.4, length=0.7, spokes=6, gravity=1.62),
]

# rounding of a few dozen operations; the terms differ by at most a factor of about 1e2
RELATIVE = 1e-12

angle = st.floats(-1.5, 1.5)
rate = st.floats(-8.0, 8.0)
triple = st.tuples(angle, angle, angle)
rates = st.tuples(rate, rate, rate)


@given(st.sampled_from(ROBOTS), triple, rates, angle)
@settings(deadline=None, derandomize=True)
def test_they_are_the_robots_methods(robot: Robot, angles: Numbers, speeds: Numbers, slope: float) -> None:
    model, n = robot.model, len(robot.angles)
    q, dq = angles[:n], speeds[:n]
    size, weight = np.abs(model.weights).max(), np.abs(model.moments).max()
    np.testing.assert_allclose(mass_matrix(model, q), robot.mass_matrix(q), rtol=0, atol=RELATIVE * size)
    np.testing.assert_allclose(
        coriolis_matrix(model, q, dq), robot.coriolis_matrix(q, dq), rtol=0, atol=RELATIVE * 8.0 * size
    )
    np.testing.assert_allclose(
        gravity_vector(model, q, slope), robot.gravity_vector(q, slope), rtol=0, atol=RELATIVE * weight
    )
    np.testing.assert_allclose(
        rates_after_touchdown(model, q, dq),
        robot.rates_after_touchdown(q, dq),
        rtol=0,
        atol=RELATIVE * 100 * 8.0,  # of M^-1 as well, whose condition number is up to 1e2
    )


@given(st.sampled_from([robot for robot in ROBOTS if isinstance(robot, mjbiped.KneedBiped)]), angle, angle, rates)
@settings(deadline=None, derandomize=True)
def test_the_knee_strike_is_the_robots(robot: mjbiped.KneedBiped, stance: float, swing: float, dq: Numbers) -> None:
    q = stance, swing, swing
    _, after = robot.knee_impact(q, dq)
    got = rates_after_knee_strike(robot.model, q, dq)
    np.testing.assert_allclose(got, after[[0, 1, 1]], rtol=0, atol=RELATIVE * 100 * 8.0)  # as above
