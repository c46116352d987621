"""Steps on arrays against impact maps, the robot's equations, and differences; curves, their pieces, the hold."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from mjbiped import Compass, KneedBiped
from mjbiped.gaits import reference
from mjbiped.gaits.optimisation import evaluate
from mjbiped.gaits.reference import DEGREE
from mjbiped.gaits.steps import KNEE_STRIKE, CompassStep, Goal, KneedStep, Motion

ROBOT = KneedBiped(3.0, 1.2, 4.0, 0.45, 0.4, 0.2, 0.15, 0.05, 0.02)
MODEL = KneedStep(ROBOT)
GOAL = Goal(speed=0.5, clearance=0.05, retraction=True, torque_limit=40.0, friction=0.6)


def _three(bound: float) -> st.SearchStrategy[np.ndarray]:
    return st.tuples(*[st.floats(-bound, bound)] * 3).map(np.array)


@pytest.mark.parametrize("straight", [False, True])
@given(q=_three(0.8), dq=_three(3.0), ddq=_three(20.0))
@settings(deadline=None, derandomize=True, max_examples=50)
def test_torques_and_ground_force_are_those_of_the_robots_equations(straight: bool, q: Any, dq: Any, ddq: Any) -> None:
    """Of eq. (1), and of Newton for the centre of mass; `tests/robots` checks the robot by free bodies."""
    if straight:
        q, dq, ddq = (each[[0, 1, 1]] for each in (q, dq, ddq))
    course = MODEL.course(*(each[None, :2] if straight else each[None] for each in (q, dq, ddq)))
    force = ROBOT.mass_matrix(q) @ ddq + ROBOT.coriolis_matrix(q, dq) @ dq + ROBOT.gravity_vector(q, 0.0)
    expected = np.linalg.solve(ROBOT.input_matrix, force)
    if straight:
        expected[2] = 0.0  # the lock's
    # rounding of some 100 N m
    np.testing.assert_allclose(course.torques[0], expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(course.powers[0], expected * np.diff(dq, prepend=0.0), rtol=0, atol=1e-10)

    def centre(t: float) -> np.ndarray:
        return ROBOT.centre_of_mass(ROBOT.posture((0.0, 0.0), 0, q + t * dq + t * t / 2 * ddq))

    step = 1e-3
    # differences of fourth order: their error is some 1e3 / s^4 times step^4 / 90, rounding 1e-16 / step^2
    far, near = centre(2 * step) + centre(-2 * step), centre(step) + centre(-step)
    acceleration = (16 * near - far - 30 * centre(0.0)) / (12 * step**2)
    pressed = ROBOT.total_mass * (acceleration + np.array([0.0, ROBOT.gravity]))
    np.testing.assert_allclose([course.tangential_force[0], course.normal_force[0]], pressed, rtol=0, atol=1e-4)
    np.testing.assert_allclose([course.ahead[0], course.height[0]], ROBOT.swing_foot(q), rtol=0, atol=1e-14)
    later = (ROBOT.swing_foot(q + 1e-6 * dq) - ROBOT.swing_foot(q - 1e-6 * dq)) / 2e-6
    # central differences: the third derivative is below 100, rounding 1e-16 / step
    np.testing.assert_allclose([course.ahead_rate[0], course.height_rate[0]], later, rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", [MODEL, CompassStep(Compass(leg_mass=4.0, lower_length=0.45, leg_inertia=0.2))])
@given(half=st.floats(0.05, 0.5), dq=_three(3.0))
@settings(deadline=None, derandomize=True, max_examples=50)
def test_heel_strike_is_the_robots_own(model: CompassStep, half: float, dq: np.ndarray) -> None:
    start, end = model.postures(np.array(half))
    impact = model.robot.heel_impact if len(model.robot.angles) == 3 else model.robot.impact
    q, after = impact(end, dq[:2])
    np.testing.assert_array_equal(q, start)
    np.testing.assert_allclose(model.rates_after_impact(np.array(half), dq[:2]), after, rtol=0, atol=1e-12)  # rounding
    assert model.step_length(np.array(half)) == pytest.approx(model.robot.swing_foot(end)[0], rel=1e-14)


def _guessed() -> Motion:
    points, own = MODEL.guess(0.2)
    return Motion(np.array(0.2), points, own, np.array(0.7))


def test_knee_strike_leads_from_branch_to_branch() -> None:
    motion, phase = _guessed(), np.array([KNEE_STRIKE])
    before, after = MODEL.bent(motion, phase), MODEL.straight(motion, phase)
    assert before[0][0, 2] == pytest.approx(before[0][0, 1], abs=1e-15)
    q, dq = ROBOT.knee_impact(before[0][0], before[1][0])
    np.testing.assert_allclose(after[0][0], q, rtol=0, atol=1e-15)
    np.testing.assert_allclose(after[1][0], dq, rtol=0, atol=1e-12)
    assert abs(before[1][0, 2] - before[1][0, 1]) > 0.1


@pytest.mark.parametrize("kind", ["bent", "straight"])
def test_rates_and_accelerations_are_derivatives(kind: str) -> None:
    motion, step = _guessed(), 1e-6
    moved, phases = getattr(MODEL, kind), np.array([0.9, 0.95]) * (1.0 if kind == "straight" else KNEE_STRIKE)
    now, (later, sooner) = moved(motion, phases), (moved(motion, phases + sign * step) for sign in (1, -1))
    time = 2 * step * float(motion.period)
    # central differences: third derivatives of some 1e4 / s^3 times step^2, rounding 1e-16 / step
    np.testing.assert_allclose((later[0] - sooner[0]) / time, now[1], rtol=0, atol=1e-7)
    np.testing.assert_allclose((later[1] - sooner[1]) / time, now[2], rtol=0, atol=1e-5)


def test_derivatives_of_cost_and_constraints() -> None:
    """Complex steps go through impact maps, both branches and the grid; central differences see the same slopes."""
    points, own = MODEL.guess(0.2)
    x = np.concatenate([[0.8, 0.2], points[2:-1].ravel(), own])
    step = 1e-6
    _, gradient, _, jacobian = evaluate(MODEL, GOAL, 1e-2, x)
    for k, direction in enumerate(np.eye(len(x))):
        ahead, behind = (evaluate(MODEL, GOAL, 1e-2, x + sign * step * direction) for sign in (1, -1))
        # third derivatives times step^2 / 6, and rounding 1e-16 / step of numbers up to 10
        assert (ahead[0] - behind[0]) / (2 * step) == pytest.approx(gradient[k], abs=1e-6)
        difference = (ahead[2] - behind[2]) / (2 * step)
        np.testing.assert_allclose(difference, jacobian[:, k], rtol=1e-6, atol=1e-6)


# ---- curves, their pieces, and the hold after a period ---------------------------------------------------------------


points = st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=DEGREE + 1, max_size=DEGREE + 1)
durations = st.floats(0.1, 3.0)


@given(points, durations, st.integers(1, 20), st.floats(0, 1, exclude_max=True))
@settings(deadline=None, derandomize=True)
def test_curve_and_its_table_in_pieces_are_scipys(points: Any, duration: float, count: int, s: float) -> None:
    expected = BPoly(np.array(points)[:, None, :], [0.0, duration])
    found = reference.curve(np.array(points), np.array([s]), duration)
    table = reference.table_of(count / duration, reference.curve_in_pieces(np.array(points), count))
    in_pieces = np.reshape(reference.motion_at(table, s * duration), (3, 2))
    for order, (values, piece) in enumerate(zip(found, in_pieces, strict=True)):
        wanted = expected.derivative(order)(s * duration)
        # rounding: each derivative multiplies differences of numbers near 1 by at most 7 / T
        np.testing.assert_allclose(values[0], wanted, rtol=0, atol=1e-13 * (4 * DEGREE / duration) ** order)
        # a piece's coefficients carry rounding of the solution of ten equations, whose condition number is 1e6; each
        # derivative multiplies it by the pieces per second and by at most 9
        np.testing.assert_allclose(piece, values[0], rtol=0, atol=1e-11 * (9 * max(1.0, count / duration)) ** order)


WIDTH = 0.05
ranges = ((0.05, 0.3), (-0.3, -0.05), (0.3, 2.0), (-2.0, 2.0), (-9.0, 9.0), (-20.0, 20.0))
ends = st.tuples(*(st.floats(low, high) for low, high in ranges))


def trajectory(end: tuple[float, ...], most: int = 16) -> list[list[float]]:
    """Angles, rates and accelerations at the hold's beginning, its marks, and its end."""
    q, dq, ddq = np.reshape(end, (3, 2))
    table = reference.table_of(1 / WIDTH, reference.hold(q, dq, ddq, WIDTH, most))
    return [list(reference.motion_at(table, t)) for t in (0.0, WIDTH, 2 * WIDTH, 3 * WIDTH)]


@given(ends)
@settings(deadline=None, derandomize=True)
def test_it_begins_where_the_step_ends_and_comes_to_rest(end: tuple[float, ...]) -> None:
    begin, one, two, _ = trajectory(end)
    # rounding of coefficients (1e-13 of numbers near 1), times the squared pieces per second and 9 * 8
    np.testing.assert_allclose(begin, end, rtol=0, atol=1e-8)
    assert one[4] == pytest.approx(0.0, abs=1e-8)  # the stance leg's acceleration, within 0.05 s
    assert two[3] == pytest.approx(0.0, abs=1e-9)  # the swing leg's rate, within 0.1 s, and its acceleration
    assert two[5] == pytest.approx(0.0, abs=1e-8)


def test_it_ends_before_the_stance_leg_has_fallen() -> None:
    pieces = reference.hold(np.array([0.3, -0.3]), np.array([3.0, 0.0]), np.zeros(2), WIDTH, 40)
    assert len(pieces) == math.floor((reference.FALLEN - 0.3) / (3.0 * WIDTH))


def test_pieces_scale_with_the_leg_and_gravity() -> None:
    for period, length, pieces in ((0.8, 1.0, 16), (1.6, 4.0, 16), (0.801, 1.0, 17)):
        assert reference.count_of_pieces(period, length, 9.81) == pieces


def test_a_table_rests_beyond_its_horizon() -> None:
    table = reference.table_of(2.0, np.random.default_rng(0).normal(0.0, 1.0, (3, 10, 2)))
    last, late = reference.motion_at(table, 1.5), reference.motion_at(table, 1.6)
    assert late == (*last[:2], 0.0, 0.0, 0.0, 0.0)
    assert last[4:] != (0.0, 0.0)
