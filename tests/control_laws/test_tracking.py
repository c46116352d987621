"""The tracking law (5)-(14) against the equations of motion written with matrices."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from law_rooms import aimed, parameters_of, tracking_torque
from scipy.integrate import solve_ivp

from mjbiped.controllers.room import ERROR, MOTION
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.compass import Array, Compass

TABLE_ONE = Compass()
ROBOTS = [
    TABLE_ONE,
    Compass(hip_mass=10.0, leg_inertia=0.0),
    Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62),
]

# rounding of a few dozen operations on terms of the size that `scale` measures
RELATIVE = 1e-13

pairs = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)).map(np.array)
rates = st.tuples(st.floats(-8, 8), st.floats(-8, 8)).map(np.array)
accelerations = st.tuples(st.floats(-60, 60), st.floats(-60, 60)).map(np.array)
gains = st.floats(0.1, 50)
slopes = st.floats(-0.5, 0.5)
robots = st.sampled_from(ROBOTS)
six = st.tuples(pairs, rates, accelerations)


@pytest.fixture(scope="module")
def gait() -> Gait:
    return find_passive_gait(TABLE_ONE, math.radians(2))


def torque(
    robot: Compass, k1: float, k2: float, reference: tuple[Array, Array, Array], q: Array, dq: Array, slope: float
) -> Array:
    return tracking_torque(parameters_of(robot, k1, k2), reference, q, dq, (math.sin(slope), math.cos(slope)))


def acceleration(robot: Compass, q: Array, dq: Array, slope: float, tau: Array) -> Array:
    """Eq. (1) solved for the accelerations, with matrices."""
    force = robot.input_matrix @ tau - robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
    result: Array = np.linalg.inv(robot.mass_matrix(q)) @ force
    return result


def scale(
    robot: Compass, k1: float, k2: float, reference: tuple[Array, Array, Array], q: Array, dq: Array, slope: float
) -> float:
    """Size of the greatest torque's terms, N m: what rounding errors are relative to."""
    wanted = (
        np.abs(reference[2]).max()
        + (k1 * k2 + 1) * np.abs(reference[0] - q).max()
        + (k1 + k2) * (np.abs(reference[1]).max() + np.abs(dq).max())
    )
    mass = float(np.abs(robot.mass_matrix(q)).sum())
    return mass * float(wanted) + mass * float(dq @ dq) + float(np.abs(robot.gravity_vector(q, slope)).sum()) + 1.0


@given(six, pairs, rates, gains, gains)
@settings(deadline=None, derandomize=True)
def test_errors_and_accelerations_are_those_of_equations_5_6_9_and_12(
    reference: tuple[Array, Array, Array], q: Array, dq: Array, k1: float, k2: float
) -> None:
    room = aimed(parameters_of(TABLE_ONE, k1, k2), reference, q, dq)
    z1, dz1 = reference[0] - q, reference[1] - dq
    K1, K2 = np.diag([k1, k1]), np.diag([k2, k2])
    # one product and one sum; the terms are at most 50 * 3 + 16
    np.testing.assert_allclose(room[ERROR : ERROR + 2], dz1 + K1 @ z1, rtol=0, atol=1e-13)
    wanted = reference[2] + (K1 @ K2 + np.eye(2)) @ z1 + (K1 + K2) @ dz1
    np.testing.assert_allclose(room[MOTION : MOTION + 2], wanted, rtol=1e-13, atol=1e-11)


@given(robots, gains, gains, six, pairs, rates, slopes)
@settings(deadline=None, derandomize=True)
def test_torque_solves_equation_12(
    robot: Compass,
    k1: float,
    k2: float,
    reference: tuple[Array, Array, Array],
    q: Array,
    dq: Array,
    slope: float,
) -> None:
    tau = torque(robot, k1, k2, reference, q, dq, slope)
    K1, K2 = np.diag([k1, k1]), np.diag([k2, k2])
    z1, dz1 = reference[0] - q, reference[1] - dq
    wanted = reference[2] + (K1 @ K2 + np.eye(2)) @ z1 + (K1 + K2) @ dz1
    force = robot.mass_matrix(q) @ wanted + robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, slope)
    expected = np.linalg.inv(robot.input_matrix) @ force
    np.testing.assert_allclose(tau, expected, rtol=0, atol=RELATIVE * scale(robot, k1, k2, reference, q, dq, slope))


@given(robots, gains, gains, six, pairs, rates, slopes)
@settings(deadline=None, derandomize=True)
def test_with_the_true_slope_the_error_obeys_a_linear_equation(
    robot: Compass,
    k1: float,
    k2: float,
    reference: tuple[Array, Array, Array],
    q: Array,
    dq: Array,
    slope: float,
) -> None:
    tau = torque(robot, k1, k2, reference, q, dq, slope)
    z1, dz1 = reference[0] - q, reference[1] - dq
    ddz1 = reference[2] - acceleration(robot, q, dq, slope, tau)
    expected = -(k1 * k2 + 1) * z1 - (k1 + k2) * dz1
    # rounding of the torque, carried through M^-1
    inverse = float(np.linalg.norm(np.linalg.inv(robot.mass_matrix(q)), 2))
    tolerance = RELATIVE * scale(robot, k1, k2, reference, q, dq, slope) * inverse
    np.testing.assert_allclose(ddz1, expected, rtol=0, atol=tolerance)


@given(robots, gains, gains, six, pairs, rates, slopes)
@settings(deadline=None, derandomize=True)
def test_second_lyapunov_function_falls_as_the_text_after_equation_12_says(
    robot: Compass,
    k1: float,
    k2: float,
    reference: tuple[Array, Array, Array],
    q: Array,
    dq: Array,
    slope: float,
) -> None:
    K1, K2 = np.diag([k1, k1]), np.diag([k2, k2])
    z1, dz1 = reference[0] - q, reference[1] - dq
    z2 = dz1 + K1 @ z1
    ddq = acceleration(robot, q, dq, slope, torque(robot, k1, k2, reference, q, dq, slope))
    derivative = z1 @ dz1 + z2 @ (reference[2] - ddq + K1 @ dz1)  # of (z1'z1 + z2'z2) / 2 along the motion
    inverse = float(np.linalg.norm(np.linalg.inv(robot.mass_matrix(q)), 2))
    size = scale(robot, k1, k2, reference, q, dq, slope) * inverse
    tolerance = RELATIVE * (size * np.abs(z2).sum() + z2 @ z2 * k2 + z1 @ z1 * k1)  # error of ddq times z2
    assert derivative == pytest.approx(-z1 @ K1 @ z1 - z2 @ K2 @ z2, rel=0, abs=tolerance)


def test_equation_11_wants_the_reference_acceleration_where_the_paper_prints_the_rate() -> None:
    # any state, reference, torque; V2 is differentiated by central differences along the motion
    robot, slope, k1 = TABLE_ONE, 0.07, 5.0
    q, dq, tau = np.array([0.2, -0.3]), np.array([1.1, -0.4]), np.array([3.0, -2.0])
    qr, dqr, ddqr = np.array([0.15, -0.1]), np.array([0.9, 0.6]), np.array([-1.7, 2.3])
    ddq = acceleration(robot, q, dq, slope, tau)

    def v2(t: float) -> float:
        z1 = (qr + t * dqr + t * t / 2 * ddqr) - (q + t * dq + t * t / 2 * ddq)
        z2 = (dqr + t * ddqr) - (dq + t * ddq) + k1 * z1
        return float(z1 @ z1 + z2 @ z2) / 2

    step = 1e-5
    measured = (v2(step) - v2(-step)) / (2 * step)
    z1, dz1 = qr - q, dqr - dq
    z2 = dz1 + k1 * z1
    solved = np.linalg.solve(
        robot.mass_matrix(q),
        robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, slope) - robot.input_matrix @ tau,
    )
    settled = -k1 * z1 @ z1 + z2 @ (z1 + ddqr + k1 * dz1 + solved)
    printed = -k1 * z1 @ z1 + z2 @ (z1 + dqr + k1 * dz1 + solved)
    # central differences: h^2 times the third derivative (~1e3) is 1e-7, rounding 1e-16 * V2 / h some 1e-10
    assert measured == pytest.approx(settled, abs=1e-6)
    assert abs(measured - printed) > 1.0


def test_on_the_limit_cycle_and_the_gaits_own_slope_no_torque_is_needed(gait: Gait) -> None:
    for t in np.linspace(0.0, gait.period, 41).tolist():
        reference = gait.reference(t)
        tau = torque(TABLE_ONE, 5.0, 12.0, reference, reference[0], reference[1], gait.slope)
        # the reference table meets the equation of motion to some 1e-10 g/l = 1e-9 rad/s^2; M's entries are below 7
        np.testing.assert_allclose(tau, 0.0, atol=1e-8)


def test_on_level_ground_the_torque_replaces_gravitys_work(gait: Gait) -> None:
    """Exact tracking of the gait on 2 degrees, one step from impact to impact, integrated with its work."""
    robot = TABLE_ONE

    def motion(t: float, y: Array) -> Array:
        q, dq = y[:2], y[2:4]
        now = motion_at(gait.tables[0], t)
        tau = torque(robot, 5.0, 12.0, (np.array(now[:2]), np.array(now[2:4]), np.array(now[4:])), q, dq, 0.0)
        power = tau[0] * dq[0] + tau[1] * (dq[1] - dq[0])
        return np.concatenate([dq, acceleration(robot, q, dq, 0.0, tau), [power]])

    solution = solve_ivp(motion, (0.0, gait.period), [*gait.start, 0.0], "DOP853", rtol=1e-10, atol=1e-12)
    state, work = solution.y[:4, -1], float(solution.y[4, -1])
    # the integrator's 1e-10 per step and the table's 1e-9 rad/s^2
    np.testing.assert_allclose(state, gait.end, rtol=0, atol=1e-8)
    # what the impact takes is what gravity gives the passive walker on the slope; same error sources, times ~50 N m
    assert work == pytest.approx(robot.weight * gait.step_length * math.sin(gait.slope), abs=1e-6)
    # the cost of transport, sin 2 degrees, with the paper's four digits
    assert round(work / (robot.weight * gait.step_length), 4) == 0.0349
