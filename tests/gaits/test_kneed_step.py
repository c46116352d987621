"""The kneed step on arrays against the robot's impact maps, MuJoCo's inverse dynamics, and differences."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.gaits.optimisation import evaluate
from mjbiped.gaits.steps import KNEE_STRIKE, Goal, KneedStep, Motion
from mjbiped.robots.kneed import KneedBiped

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


@given(st.floats(0.05, 0.5), _three(3.0))
@settings(deadline=None, derandomize=True, max_examples=50)
def test_heel_strike_is_the_robots_own(half: float, dq: np.ndarray) -> None:
    start, end = MODEL.postures(np.array(half))
    q, after = ROBOT.heel_impact(end, dq[:2])
    np.testing.assert_array_equal(q, start)
    np.testing.assert_allclose(MODEL.rates_after_impact(np.array(half), dq[:2]), after, rtol=0, atol=1e-12)  # rounding
    assert MODEL.step_length(np.array(half)) == pytest.approx(ROBOT.swing_foot(end)[0], rel=1e-14)


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
