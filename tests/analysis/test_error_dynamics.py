"""Equation (22) derived with SymPy and checked against the law as coded; transition matrix, excitation, limit cycle."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec, solve_ivp

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.error_dynamics import (
    evolve,
    impact_gain,
    impact_matrix,
    regressor,
    system_matrix,
)
from mjbiped.robots import compass
from mjbiped.robots.compass import Array
from scripts.paper.theorem_1 import envelope

gains = st.floats(0.05, 60.0)
angles = st.floats(-1.0, 1.0)


# --- the paper's (22) -------------------------------------------------------------------------------------------------


@given(gains, gains, gains, st.lists(angles, min_size=12, max_size=12))
@settings(deadline=None, derandomize=True)
def test_system_matrix_is_the_closed_loop_as_coded(k1: float, k2: float, gamma: float, values: list[float]) -> None:
    """Rates of z1, z2 and the estimates' errors from the robot's acceleration under the controller's own torque."""
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, math.radians(2))
    controller = AdaptiveController(robot, gait, position_gain=k1, velocity_gain=k2, adaptation_gain=gamma)
    q1, q2, dq1, dq2, slope, sine, cosine, a, b, da, db, t = values
    memory = [0.0] * controller.memory_size
    controller.start(memory, (a, b), (da, db))  # off the cycle: the reference is a planned one
    memory[:2] = [sine, cosine]
    r = np.array(controller.reference(memory, abs(t)))
    ankle, hip, rate_s, rate_c = controller.torque(memory, abs(t), (q1, q2), (dq1, dq2))
    ddq = compass.acceleration(robot.constants, q1, q2, dq1, dq2, math.sin(slope), math.cos(slope), ankle - hip, hip)
    z1, dz1 = r[0:2] - [q1, q2], r[2:4] - [dq1, dq2]
    eta = np.array([*z1, *(dz1 + k1 * z1), math.sin(slope) - sine, math.cos(slope) - cosine])
    rates = np.array([*dz1, *(r[4:6] - ddq + k1 * dz1), -rate_s, -rate_c])
    matrix = system_matrix(controller, regressor(robot.constants, np.array([[q1, q2]])))[0]
    # rounding of terms of the size of the gains' products, and of Bezier accelerations of some 1e3 rad/s^2
    np.testing.assert_allclose(matrix @ eta, rates, rtol=0, atol=1e-12 * (1 + k1) * (1 + k2 + gamma) * 1e3)


# --- evolution --------------------------------------------------------------------------------------------------------


def _on_the_cycle(controller: AdaptiveController, intervals: int) -> tuple[Array, Array, Array]:
    time = np.linspace(0.0, controller.gait.period, intervals + 1)
    q, dq, _ = controller.gait.reference(time)
    return time, q, dq


def _matrix_at(controller: AdaptiveController, t: float) -> Array:
    """The matrix of (22) on the limit cycle, from the robot's matrices."""
    robot, gamma = controller.robot, controller.adaptation_gain
    q = controller.gait.reference(t)[0]
    w = np.column_stack([robot.gravity_vector(q, math.pi / 2), robot.gravity_vector(q, 0.0)]).T
    w = w @ np.linalg.inv(robot.mass_matrix(q))
    eye, none = np.eye(2), np.zeros((2, 2))
    return np.block(
        [
            [-controller.position_gain * eye, eye, none],
            [-eye, -controller.velocity_gain * eye, w.T],
            [none, -gamma * w, none],
        ]
    )


@pytest.mark.parametrize("gamma", [0.3, 30.0])
def test_transition_and_gramian_against_scipy(controller: AdaptiveController, gamma: float) -> None:
    controller = replace(controller, adaptation_gain=gamma)
    solution = solve_ivp(
        lambda t, y: (_matrix_at(controller, t) @ y.reshape(6, 6)).ravel(),
        (0.0, controller.gait.period),
        np.eye(6).ravel(),
        "DOP853",
        rtol=1e-11,
        atol=1e-12,
    )
    expected = solution.y[:, -1].reshape(6, 6)
    errors = []
    for intervals in (50, 100):
        transitions = evolve(controller, *_on_the_cycle(controller, intervals)).transitions
        assert np.array_equal(transitions[0], np.eye(6))
        errors.append(np.abs(transitions[-1] - expected).max())
    assert errors[1] < 2e-5  # of the size that the order leaves at 7.6 ms
    assert 3.7 < math.log2(errors[0] / errors[1]) < 4.5

    def integrand(t: float) -> Array:
        w = -_matrix_at(controller, t)[4:, 2:4] / gamma
        return w @ w.T

    gramian, _ = quad_vec(integrand, 0.0, controller.gait.period, epsabs=1e-11)
    errors = [np.abs(evolve(controller, *_on_the_cycle(controller, n)).gramian - gramian).max() for n in (50, 100)]
    assert errors[1] < 1e-5
    assert 3.7 < math.log2(errors[0] / errors[1]) < 4.5


def test_envelope_bounds_the_norm_and_is_sharp_at_the_end(controller: AdaptiveController) -> None:
    time, q, dq = _on_the_cycle(controller, 100)
    transitions = evolve(controller, time, q, dq).transitions
    bound = envelope(time, transitions)
    norms = np.linalg.norm(transitions, 2, axis=(1, 2))
    curve = bound.gain * np.exp(-bound.rate * time)
    assert (curve > norms * (1 - 1e-12)).all()  # rounding
    assert curve[-1] == pytest.approx(norms[-1], rel=1e-12)
    assert np.isclose(curve[:-1], norms[:-1], rtol=1e-12).any()  # a smaller k_C would cut the norm there


# --- touchdown on the limit cycle -------------------------------------------------------------------------------------


def test_impact_matrix_is_the_impact_map(robot: mjbiped.Compass) -> None:
    q, dq = np.array([0.2, -0.17]), np.array([1.3, 1.5])
    np.testing.assert_allclose(impact_matrix(robot.constants, q) @ dq, robot.impact(q, dq)[1], rtol=1e-14)


def test_constant_of_20_by_hand() -> None:
    assert impact_gain(5.0, 0.0, 0.0) == math.sqrt(51)
    assert impact_gain(5.0, 2.0, 3.0) == math.sqrt(2 * 25 + 8 * 9 * 25 + 4 * 4 + 1)
    assert impact_gain(0.1, 0.0, 3.0) == math.sqrt(72)
