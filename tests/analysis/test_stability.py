"""Theorem 1: (22) against the law as coded and against SciPy, and recorded walks against (15)-(26)."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec, solve_ivp

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.analysis.error_dynamics import evolve, impact_gain, impact_matrix, regressor, system_matrix
from mjbiped.analysis.stability import Stability, stability
from mjbiped.robots import compass
from mjbiped.robots.compass import Array

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


def _regressor_at(controller: AdaptiveController, t: float) -> Array:
    return regressor(controller.robot.constants, controller.gait.reference(t)[0][None])


@pytest.mark.parametrize("gamma", [0.3, 30.0])
def test_transition_and_gramian_against_scipy(controller: AdaptiveController, gamma: float) -> None:
    controller = replace(controller, adaptation_gain=gamma)

    def rates(t: float, y: Array) -> Any:
        return (system_matrix(controller, _regressor_at(controller, t))[0] @ y.reshape(6, 6)).ravel()

    terms: Any = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
    solution = solve_ivp(rates, (0.0, controller.gait.period), np.eye(6).ravel(), **terms)
    expected = solution.y[:, -1].reshape(6, 6)
    errors = []
    for intervals in (50, 100):
        transitions = evolve(controller, *_on_the_cycle(controller, intervals)).transitions
        assert np.array_equal(transitions[0], np.eye(6))
        errors.append(np.abs(transitions[-1] - expected).max())
    assert errors[1] < 2e-5  # of the size that the order leaves at 7.6 ms
    assert 3.7 < math.log2(errors[0] / errors[1]) < 4.5

    def integrand(t: float) -> Any:
        w = _regressor_at(controller, t)[0]
        return w @ w.T

    gramian, _ = quad_vec(integrand, 0.0, controller.gait.period, epsabs=1e-11)
    errors = [np.abs(evolve(controller, *_on_the_cycle(controller, n)).gramian - gramian).max() for n in (50, 100)]
    assert errors[1] < 1e-5
    assert 3.7 < math.log2(errors[0] / errors[1]) < 4.5


# --- touchdown on the limit cycle -------------------------------------------------------------------------------------


def test_impact_matrix_is_the_impact_map(robot: mjbiped.Compass) -> None:
    q, dq = np.array([0.2, -0.17]), np.array([1.3, 1.5])
    np.testing.assert_allclose(impact_matrix(robot.constants, q) @ dq, robot.impact(q, dq)[1], rtol=1e-14)


def test_constant_of_20_by_hand() -> None:
    assert impact_gain(5.0, 0.0, 0.0) == math.sqrt(51)
    assert impact_gain(5.0, 2.0, 3.0) == math.sqrt(2 * 25 + 8 * 9 * 25 + 4 * 4 + 1)
    assert impact_gain(0.1, 0.0, 3.0) == math.sqrt(72)


# error of a step's end in the hybrid engine: some 20 integration steps of tolerance 1e-10 (1 + |y|), and the dense
# output between them
INTEGRATION = 1e-8


def walked(controller: AdaptiveController, terrain: mjbiped.Terrain, **arguments: object) -> mjbiped.Walk:
    given = {"engine": "hybrid", "steps": 6, "sample_period": 2e-3, **arguments}
    return mjbiped.walk(controller, terrain, **given)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def wrong(controller: AdaptiveController) -> AdaptiveController:
    """Starts with an estimate 3 degrees wrong, is never re-planned, never updated: all that (22) has in it moves."""
    return replace(controller, initial_slope_estimate=math.radians(3), replanning_delay=None, estimate_update=False)


@pytest.fixture(scope="module")
def uneven() -> mjbiped.Terrain:
    return mjbiped.Terrain.from_segments([(1.0, 0.0, 0.0), (10.0, 1.0, 0.0)])


@pytest.fixture(scope="module")
def walk(wrong: AdaptiveController, uneven: mjbiped.Terrain) -> mjbiped.Walk:
    return walked(wrong, uneven)


@pytest.fixture(scope="module")
def found(walk: mjbiped.Walk) -> Stability:
    return stability(walk)


def test_recorded_errors_obey_22(found: Stability) -> None:
    """The transition matrix, made of the angles alone, carries the errors from a step's start to its end."""
    assert found.residual.max() < INTEGRATION
    assert np.linalg.norm(found.start[0]) > 0.05  # there was something to carry
    assert (np.linalg.norm(found.start - found.end, axis=1) > 1e5 * found.residual).all()


def test_16_and_17(found: Stability, wrong: AdaptiveController) -> None:
    """The Lyapunov function falls as they say."""
    weight = 1 / wrong.adaptation_gain
    assert np.abs(found.balance).max() < INTEGRATION * weight
    z1, z2, theta = found.errors[:, 0:2], found.errors[:, 2:4], found.errors[:, 4:6]
    expected = 0.5 * (z1**2).sum(1) + 0.5 * (z2**2).sum(1) + 0.5 * weight * (theta**2).sum(1)
    np.testing.assert_allclose(found.lyapunov, expected, rtol=1e-13)
    within = np.diff(found.step) == 0
    assert np.diff(found.lyapunov)[within].max() < 0.0


def test_estimates_at_the_ends_are_the_recorded_ones(found: Stability, walk: mjbiped.Walk) -> None:
    slope = np.append(0.0, walk.touchdowns["slope"])
    before, after = walk.touchdowns["slope_estimate_before"], walk.touchdowns["slope_estimate"]
    np.testing.assert_allclose(np.sin(slope[:-1]) - found.end[:, 4], np.sin(before), rtol=0, atol=INTEGRATION)
    np.testing.assert_allclose(np.sin(slope[1:-1]) - found.start[1:, 4], np.sin(after[:-1]), rtol=0, atol=INTEGRATION)


def test_touchdowns_against_the_equations(found: Stability, walk: mjbiped.Walk) -> None:
    """(19)-(21) from the record's rows, and the jump of V_a."""
    z1 = np.linalg.norm(found.end[:-1, 0:2], axis=1)
    rates = [np.linalg.norm(eta[:, 2:4] - 5 * eta[:, 0:2], axis=1) for eta in (found.end[:-1], found.start[1:])]
    bound = found.alpha[1:] * z1 + found.beta[1:] * rates[0]
    assert (rates[1] <= bound * (1 + 1e-12)).all()
    sharp = found.alpha[1:] > 0
    np.testing.assert_allclose(rates[1][sharp], bound[sharp], rtol=1e-12)
    for step, q in enumerate(walk.touchdowns["q_before"][:-1], start=1):
        assert found.beta[step] == pytest.approx(np.linalg.norm(impact_matrix(found.controller.robot.constants, q), 2))
        assert found.impact_gain[step] == impact_gain(5.0, found.alpha[step], found.beta[step])
    assert np.isnan([found.alpha[0], found.beta[0], found.impact_gain[0], found.ratio[0], found.lyapunov_jump[0]]).all()
    first_of = np.flatnonzero(np.diff(found.step)) + 1
    np.testing.assert_allclose(found.lyapunov_jump[1:], found.lyapunov[first_of] - found.lyapunov[first_of - 1])
    assert np.flatnonzero(found.slope_change).tolist() == [int(np.argmax(found.lyapunov_jump[1:])) + 1]
    assert found.slope_change.sum() == pytest.approx(math.radians(1))


def test_ratios_and_bounds_are_those_of_21_to_26(found: Stability) -> None:
    before, after = (np.linalg.norm(eta, axis=1) for eta in (found.end, found.start))
    np.testing.assert_allclose(found.ratio[1:], before[1:] / before[:-1])
    np.testing.assert_allclose(found.impact_ratio[1:], after[1:] / before[:-1])
    contraction = np.linalg.norm(found.transition, 2, axis=(1, 2))
    np.testing.assert_allclose(found.condition[1:], found.impact_gain[1:] * contraction[1:])
    np.testing.assert_allclose(found.condition_floor, math.sqrt(51.0) * contraction)
    of_estimates = [np.linalg.norm(found.errors[found.step == step, 4:6], axis=1) for step in range(found.steps)]
    np.testing.assert_allclose(found.estimate_rise, [norms.max() - norms[0] for norms in of_estimates], atol=1e-15)
    assert found.estimate_rise.max() > 1e-3


def test_exact_estimate_stays_exact(controller: AdaptiveController, uneven: mjbiped.Terrain) -> None:
    """With (27) and re-planning another slope leaves V_a at zero; without (27) its change goes into V_a."""
    found = stability(walked(controller, uneven))
    assert found.lyapunov.max() < INTEGRATION
    blind = stability(walked(replace(controller, estimate_update=False), uneven))
    change = np.array([math.sin(math.radians(1)), math.cos(math.radians(1)) - 1])
    there = int(np.flatnonzero(blind.slope_change)[0])
    assert blind.lyapunov_jump[there] == pytest.approx((change**2).sum() / 0.6, rel=1e-6)


def test_excitation_and_its_directions(found: Stability) -> None:
    assert (found.excitation[:, 0] > 50.0).all()
    assert (found.excitation[:, 1] / found.excitation[:, 0] < 2.2).all()
    assert (found.weak_direction < math.radians(5)).all()  # the cosine's


def test_refusals(controller: AdaptiveController, walk: mjbiped.Walk) -> None:
    downhill = mjbiped.Terrain.incline(2.0)
    passive = replace(walk, settings={**walk.settings, "controller": PassiveController().describe()})
    short = walked(controller, downhill, steps=1, sample_period=0.2)
    none = replace(walk, touchdowns={name: column[:0] for name, column in walk.touchdowns.items()})
    for wrong, words in (
        ([passive], "this walk's is PassiveController"),
        ([passive, PassiveController()], r"controller must be a .*AdaptiveTracking, got PassiveController"),
        ([short], r"step 1 of 0\.764 s has only 3 samples"),
        ([none], "no touchdown"),
    ):
        with pytest.raises(mjbiped.InputError, match=words):
            stability(*wrong)
