"""Steps on arrays against impact maps, MuJoCo's inverse dynamics, and differences; curves, their pieces, the hold."""

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from mjbiped import Compass, KneedBiped
from mjbiped.gaits.optimisation import evaluate
from mjbiped.gaits.reference import (
    DEGREE,
    FALLEN,
    count_of_pieces,
    curve,
    curve_in_pieces,
    hold,
    motion_at,
    table_of,
)
from mjbiped.gaits.steps import KNEE_STRIKE, CompassStep, Goal, KneedStep, Motion

ROBOT = KneedBiped(
    thigh_mass=3.0, shank_mass=1.2, hip_mass=4.0, thigh_length=0.45, shank_length=0.4, thigh_centre=0.2,
    shank_centre=0.15, thigh_inertia=0.05, shank_inertia=0.02,
)  # fmt: skip
MODEL = KneedStep(ROBOT)
GOAL = Goal(speed=0.5, clearance=0.05, retraction=True, torque_limit=40.0, friction=0.6)

PENDULUM = """
<mujoco>
  <option gravity="0 0 -{g}"/>
  <worldbody>
    <body name="stance">
      <joint name="ankle" type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 {shank_up}" mass="{ms}" diaginertia="{js} {js} {js}"/>
      <body name="stance_thigh" pos="0 0 {ls}">
        <inertial pos="0 0 {thigh_up}" mass="{mt}" diaginertia="{jt} {jt} {jt}"/>
        <body name="hip" pos="0 0 {lt}">
          <inertial pos="0 0 0" mass="{mh}" diaginertia="1e-12 1e-12 1e-12"/>
          <body name="thigh">
            <joint name="hip" type="hinge" axis="0 1 0"/>
            <inertial pos="0 0 -{ct}" mass="{mt}" diaginertia="{jt} {jt} {jt}"/>
            <body name="shank" pos="0 0 -{lt}">
              <joint name="knee" type="hinge" axis="0 1 0"/>
              <inertial pos="0 0 -{cs}" mass="{ms}" diaginertia="{js} {js} {js}"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def pendulum() -> mujoco.MjModel:
    """A triple pendulum of MuJoCo's own: its joints' angles are relative."""
    robot = ROBOT
    return mujoco.MjModel.from_xml_string(
        PENDULUM.format(
            g=robot.gravity, ms=robot.shank_mass, mt=robot.thigh_mass, mh=robot.hip_mass, js=robot.shank_inertia,
            jt=robot.thigh_inertia, ls=robot.shank_length, lt=robot.thigh_length, cs=robot.shank_centre,
            ct=robot.thigh_centre, shank_up=robot.shank_length - robot.shank_centre,
            thigh_up=robot.thigh_length - robot.thigh_centre,
        )
    )  # fmt: skip


def _three(bound: float) -> st.SearchStrategy[np.ndarray]:
    return st.tuples(*[st.floats(-bound, bound)] * 3).map(np.array)


@pytest.mark.parametrize("straight", [False, True])
@given(q=_three(0.8), dq=_three(3.0), ddq=_three(20.0))
@settings(deadline=None, derandomize=True, max_examples=50)
def test_torques_and_ground_force_are_mujocos(
    pendulum: mujoco.MjModel, straight: bool, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray
) -> None:
    if straight:
        q, dq, ddq = (each[[0, 1, 1]] for each in (q, dq, ddq))
    given = [each[:2] if straight else each for each in (q, dq, ddq)]
    course = MODEL.course(*(each[None] for each in given))
    data = mujoco.MjData(pendulum)
    for place, absolute in ((data.qpos, q), (data.qvel, dq), (data.qacc, ddq)):
        place[:] = np.diff(absolute, prepend=0.0)
    mujoco.mj_inverse(pendulum, data)
    expected = data.qfrc_inverse.copy()
    if straight:
        expected[2] = 0.0  # the lock's
    # the hip's inertia of 1e-12 and rounding of some 100 N m
    np.testing.assert_allclose(course.torques[0], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(course.powers[0], expected * data.qvel, rtol=0, atol=1e-8)

    def centre(t: float) -> np.ndarray:
        data.qpos[:] = np.diff(q + t * dq + t * t / 2 * ddq, prepend=0.0)
        mujoco.mj_forward(pendulum, data)
        return np.array(data.subtree_com[0, [0, 2]])

    step = 1e-3
    # differences of fourth order: their error is some 1e3 / s^4 times step^4 / 90, rounding 1e-16 / step^2
    far, near = centre(2 * step) + centre(-2 * step), centre(step) + centre(-step)
    acceleration = (16 * near - far - 30 * centre(0.0)) / (12 * step**2)
    force = ROBOT.total_mass * (acceleration + np.array([0.0, ROBOT.gravity]))
    np.testing.assert_allclose([course.tangential_force[0], course.normal_force[0]], force, rtol=0, atol=1e-4)
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


def test_it_ends_before_the_stance_leg_has_fallen() -> None:
    pieces = hold(np.array([0.3, -0.3]), np.array([3.0, 0.0]), np.zeros(2), WIDTH, 40)
    assert len(pieces) == math.floor((FALLEN - 0.3) / (3.0 * WIDTH))


def test_pieces_scale_with_the_leg_and_gravity() -> None:
    assert count_of_pieces(0.8, 1.0, 9.81) == 16
    assert count_of_pieces(0.8 * 2, 4.0, 9.81) == 16
    assert count_of_pieces(0.801, 1.0, 9.81) == 17
