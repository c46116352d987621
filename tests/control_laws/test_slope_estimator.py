"""The slope estimator: adaptive law (17), Lyapunov function (15)-(16), update at touchdown (27)."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from law_rooms import parameters_of, rates_of, tracking_torque
from scipy.integrate import solve_ivp

from mjbiped.controllers import layout
from mjbiped.controllers.slope_estimator import slope_of, update_estimate
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.compass import Array, Compass

TABLE_ONE = Compass()
ROBOTS = [
    TABLE_ONE,
    Compass(hip_mass=10.0, leg_inertia=0.0),
    Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62),
]
RELATIVE = 1e-13  # rounding of a few dozen operations, relative to the terms added up

pairs = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)).map(np.array)
rates = st.tuples(st.floats(-8, 8), st.floats(-8, 8)).map(np.array)
gains = st.floats(0.1, 50)
slopes = st.floats(-0.5, 0.5)
robots = st.sampled_from(ROBOTS)


def gravity_parts(robot: Compass, q: Array) -> tuple[Array, Array]:
    """g_c and g_s of (13), from the whole vector on a wall and on level ground."""
    return robot.gravity_vector(q, math.pi / 2), robot.gravity_vector(q, 0.0)


def motion(
    robot: Compass,
    gain: tuple[float, float, float],
    reference: tuple[float, ...],
    q: Array,
    dq: Array,
    slope: float,
    estimate: Array,
) -> tuple[Array, Array, Array, Array]:
    """Real accelerations and estimate rates of the closed loop (1), (14), (17); and z1, z2 from their definitions."""
    k1, k2, gamma = gain
    parameters = parameters_of(robot, k1, k2)
    parts = np.array(reference[:2]), np.array(reference[2:4]), np.array(reference[4:6])
    tau = tracking_torque(parameters, parts, q, dq, (float(estimate[0]), float(estimate[1])))
    force = robot.input_matrix @ tau - robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
    ddq: Array = np.linalg.inv(robot.mass_matrix(q)) @ force
    z1: Array = np.array(reference[:2]) - q
    z2: Array = np.array(reference[2:4]) - dq + k1 * z1
    return ddq, np.array(rates_of(parameters, gamma, q, z2), dtype=np.float64), z1, z2


@given(robots, gains, pairs, rates)
@settings(deadline=None, derandomize=True)
def test_rates_are_those_of_equation_17(robot: Compass, gamma: float, q: Array, z2: Array) -> None:
    gc, gs = gravity_parts(robot, q)
    inverse = np.linalg.inv(robot.mass_matrix(q))
    expected = [gamma * z2 @ inverse @ gc, gamma * z2 @ inverse @ gs]
    # rounding, and the cosine of the wall's angle, which is 6e-17 in place of 0; 1e-300 is where floats run out
    size = gamma * float(np.abs(z2).max() * np.linalg.norm(inverse, 2) * (np.abs(gc).sum() + np.abs(gs).sum()))
    found = rates_of(parameters_of(robot), gamma, q, z2)
    np.testing.assert_allclose(found, expected, rtol=0, atol=RELATIVE * size + 1e-300)


@given(
    robots,
    st.tuples(gains, gains, gains),
    pairs,
    rates,
    st.tuples(*[st.floats(-2, 2)] * 2, *[st.floats(-8, 8)] * 2, *[st.floats(-60, 60)] * 2),
    slopes,
    st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)).map(np.array),
)
@settings(deadline=None, derandomize=True)
def test_adaptive_law_takes_the_slope_error_out_of_the_lyapunov_derivative(
    robot: Compass,
    gain: tuple[float, float, float],
    q: Array,
    dq: Array,
    reference: tuple[float, ...],
    slope: float,
    estimate: Array,
) -> None:
    k1, k2, gamma = gain
    ddq, estimate_rate, z1, z2 = motion(robot, gain, reference, q, dq, slope, estimate)
    dz1 = np.array(reference[2:4]) - dq
    dz2 = np.array(reference[4:6]) - ddq + k1 * dz1
    error = np.array([math.sin(slope), math.cos(slope)]) - estimate  # the slope stands still: its rate is the law's
    without = z1 @ dz1 + z2 @ dz2  # of V2, (11)
    derivative = without - error @ estimate_rate / gamma  # of Va, (15)
    expected = -k1 * z1 @ z1 - k2 * z2 @ z2
    # each term's rounding is relative to its largest part, the acceleration's to the forces that M^-1 brings together
    inverse = np.linalg.inv(robot.mass_matrix(q))
    gc, gs = gravity_parts(robot, q)
    wanted = np.abs(reference[4:6]).max() + (k1 * k2 + 1) * np.abs(z1).max() + (k1 + k2) * np.abs(dz1).max()
    mass = np.abs(robot.mass_matrix(q)).sum()
    forces = mass * (wanted + dq @ dq) + 3 * (np.abs(gc).sum() + np.abs(gs).sum()) + 1.0
    size = float(np.abs(z2).sum() * np.linalg.norm(inverse, 2) * forces + k1 * z1 @ z1 + k2 * z2 @ z2)
    tolerance = RELATIVE * size + 1e-300
    assert derivative == pytest.approx(expected, rel=0, abs=tolerance)
    # (16) before the law: the slope's errors are what is left over, with g_c and g_s through M^-1
    left_over = z2 @ inverse @ gc * error[0] + z2 @ inverse @ gs * error[1]
    assert without == pytest.approx(expected + left_over, rel=0, abs=tolerance)


@pytest.mark.parametrize("degrees", [-3.0, 2.0, 8.0])
def test_lyapunov_function_never_rises_within_a_step_and_falls_by_what_the_errors_cost(degrees: float) -> None:
    """Single support of the real closed loop from a wrong estimate and a disturbed state; (16) integrated."""
    robot, gain, slope = TABLE_ONE, (5.0, 12.0, 0.3), math.radians(degrees)
    gait = find_passive_gait(robot, math.radians(2))
    true = np.array([math.sin(slope), math.cos(slope)])

    def lyapunov(t: float, y: Array) -> float:
        _, _, z1, z2 = motion(robot, gain, motion_at(gait.tables[0], t), y[:2], y[2:4], slope, y[4:6])
        error = true - y[4:6]
        return float(z1 @ z1 + z2 @ z2 + error @ error / gain[2]) / 2

    def rhs(t: float, y: Array) -> Array:
        ddq, estimate_rate, z1, z2 = motion(robot, gain, motion_at(gait.tables[0], t), y[:2], y[2:4], slope, y[4:6])
        return np.concatenate([y[2:4], ddq, estimate_rate, [gain[0] * z1 @ z1 + gain[1] * z2 @ z2]])

    disturbed = gait.start + np.array([0.02, -0.01, 0.1, -0.15])
    wrong = math.radians(5.0)
    start = [*disturbed, math.sin(wrong), math.cos(wrong), 0.0]
    solution = solve_ivp(rhs, (0.0, gait.period), start, "DOP853", rtol=1e-10, atol=1e-12, max_step=0.02)
    values = np.array([lyapunov(t, y) for t, y in zip(solution.t, solution.y.T, strict=True)])
    # 1e-9: some 40 steps of the integrator's 1e-10, on values of the order of 0.01 to 1
    assert (np.diff(values) <= 1e-9).all()
    assert values[-1] < 0.1 * values[0]  # a step is long enough to find the slope out: observed 0.003 to 0.02
    np.testing.assert_allclose(values[0] - values, solution.y[6], rtol=0, atol=1e-9)


def updated_estimate(
    sine: float, cosine: float, threshold: float, stance_before: float, swing_after: float
) -> tuple[float, float]:
    """Estimates of sine and cosine after the update (27)."""
    parameters = parameters_of(TABLE_ONE, more={layout.ESTIMATE_UPDATE: 1.0, layout.UPDATE_THRESHOLD: threshold})
    memory = [sine, cosine]
    update_estimate(parameters, memory, stance_before, swing_after)
    return memory[0], memory[1]


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-1.0, 1.0))
@settings(deadline=None, derandomize=True)
def test_update_finds_the_new_slope_exactly_from_the_old_one(before: float, after: float, leg: float) -> None:
    """The leg that leaves the ground has one angle from the vertical; both normals are told from it."""
    sine, cosine = updated_estimate(math.sin(before), math.cos(before), 0.0, leg - before, leg - after)
    # arcsin magnifies rounding by 1 / cos(1.2) < 3
    assert sine == pytest.approx(math.sin(after), abs=3e-15)
    assert cosine == pytest.approx(math.cos(after), abs=3e-15)
    assert math.hypot(sine, cosine) == pytest.approx(1.0, abs=3e-16)  # two ulp of 1


@given(st.floats(-0.5, 0.5), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5), st.floats(-1.0, 1.0))
@settings(deadline=None, derandomize=True)
def test_update_keeps_the_error_of_the_estimate(before: float, error: float, after: float, leg: float) -> None:
    estimate = before + error
    sine, _ = updated_estimate(math.sin(estimate), math.cos(estimate), 0.0, leg - before, leg - after)
    assert slope_of(sine) - after == pytest.approx(error, abs=5e-15)  # arcsin's rounding times 1 / cos(1.1) = 2.2


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_changes_up_to_the_threshold_leave_the_estimate_untouched(sign: float) -> None:
    threshold, swing = 0.125, 0.25  # powers of two: differences are exact
    sine, cosine = 0.3, 0.8  # off the unit circle, as the adaptive law may have left them
    assert updated_estimate(sine, cosine, threshold, swing + sign * threshold, swing) == (sine, cosine)
    assert updated_estimate(sine, cosine, threshold, swing, swing) == (sine, cosine)
    above = math.nextafter(threshold, 1.0)
    updated = updated_estimate(sine, cosine, threshold, sign * above, 0.0)
    assert updated[0] == math.sin(math.asin(sine) + sign * above)
    assert math.hypot(*updated) == pytest.approx(1.0, abs=3e-16)  # two ulp of 1


@pytest.mark.parametrize(("sine", "slope"), [(1.0, 90), (1.7, 90), (-1.0, -90), (-1e9, -90), (0.0, 0), (0.5, 30)])
def test_sines_beyond_one_mean_a_right_angle(sine: float, slope: float) -> None:
    assert slope_of(sine) == pytest.approx(math.radians(slope), abs=2e-16)  # an ulp of arcsin
    # the update starts from there: no error is raised, and it ends on the circle
    assert math.hypot(*updated_estimate(sine, 0.0, 0.0, 0.1, 0.0)) == pytest.approx(1.0, abs=3e-16)  # two ulp of 1


@given(st.floats(-1.5, 1.5))
@settings(deadline=None, derandomize=True)
def test_slope_of_undoes_the_sine(slope: float) -> None:
    # arcsin's rounding, magnified by 1 / cos(1.5) = 14
    assert slope_of(math.sin(slope)) == pytest.approx(slope, abs=5e-15)
