"""Passive gaits against integrations written independently; published numbers: `tests/scripts/test_published.py`."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mjbiped import GaitError, InputError, KneedBiped, PassiveGait, find_kneed_gait, find_passive_gait
from mjbiped.gaits.reference import PIECES, RATE, motion_at
from mjbiped.robots.compass import Array, Compass
from scripts.validation.published import GOSWAMI_ROBOT

TABLE_ONE = Compass()
MOON = Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62)


@pytest.fixture(scope="module")
def gait() -> PassiveGait:
    return find_passive_gait(TABLE_ONE, math.radians(2))


def rates(robot: Compass, slope: float, state: Array) -> Array:
    """Eq. (1) without torques, from the matrices."""
    q, dq = state[:2], state[2:]
    force = -robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
    return np.concatenate([dq, np.linalg.solve(robot.mass_matrix(q), force)])


def solved(robot: Compass, slope: float, start: Array, duration: float, **given: Any) -> Any:
    """The passive motion; short steps keep DOP853's interpolant as good as its steps."""
    terms = {"rtol": 1e-13, "atol": 1e-14, "max_step": duration / 100, **given}
    return solve_ivp(lambda _, state: rates(robot, slope, state), (0.0, duration), start, method="DOP853", **terms)


def step(robot: Compass, slope: float, start: Array) -> tuple[float, Array]:
    """(time, state after the impact) of one passive step, by event detection: an independent return map."""

    def touchdown(_: float, state: Array) -> float:
        along, height = robot.swing_foot(state[:2])
        return float(height) if along > 0.1 * robot.leg_length * abs(math.sin(start[0])) else robot.leg_length

    touchdown.terminal = True  # type: ignore[attr-defined]
    touchdown.direction = -1  # type: ignore[attr-defined]
    frequency = math.sqrt(robot.gravity / robot.leg_length)
    terms = {"rtol": 1e-12, "atol": 1e-13, "max_step": 0.05 / frequency}
    solution = solved(robot, slope, start, 10 / frequency, events=touchdown, **terms)
    before = solution.y_events[0][0]
    return float(solution.t_events[0][0]), np.concatenate(robot.impact(before[:2], before[2:]))


EACH = [(TABLE_ONE, 0.1), (TABLE_ONE, 2.0), (TABLE_ONE, 4.0), (TABLE_ONE, 5.0), (GOSWAMI_ROBOT, 3.0), (MOON, 1.3)]
MARKED = [pytest.param(*each, marks=() if each[1] in (0.1, 5.0, 1.3) else pytest.mark.slow) for each in EACH]


@pytest.mark.parametrize(("robot", "degrees"), MARKED)
def test_gait_is_a_fixed_point_and_multipliers_are_the_return_maps(robot: Compass, degrees: float) -> None:
    slope = math.radians(degrees)
    gait = find_passive_gait(robot, slope)
    period, after = step(robot, slope, gait.start)
    # event location and rtol 1e-12, magnified by the instability within the step
    assert period == pytest.approx(gait.period, rel=1e-10)
    np.testing.assert_allclose(after, gait.start, rtol=0, atol=1e-10 * np.abs(gait.start).max())
    np.testing.assert_allclose(np.concatenate(robot.impact(gait.end[:2], gait.end[2:])), gait.start, atol=1e-11)

    h = 1e-4 * abs(gait.start[0])
    columns = []
    for direction in np.array([[1, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]):
        ahead, behind = (step(robot, slope, gait.start + sign * h * direction)[1] for sign in (1, -1))
        columns.append((ahead - behind)[[0, 2, 3]] / (2 * h))
    expected = np.linalg.eigvals(np.column_stack(columns)).astype(complex)
    expected = expected[np.argsort(-np.abs(expected), kind="stable")]
    # second-order differences err by h^2 times a third derivative, about 1e-6 here
    for mine, other in zip(gait.multipliers, expected, strict=True):
        assert (mine.real, abs(mine.imag)) == pytest.approx((other.real, abs(other.imag)), abs=3e-6)


@pytest.mark.parametrize(("robot", "degrees"), [each for each in EACH if each[1] < 5.0])
def test_reference_follows_the_passive_motion_to_the_horizon(robot: Compass, degrees: float) -> None:
    gait = find_passive_gait(robot, math.radians(degrees))
    times = np.linspace(0, gait.horizon, 501)
    states = solved(robot, gait.slope, gait.start, gait.horizon, t_eval=times).y.T
    q, dq, ddq = gait.reference(times)
    acceleration = np.array([rates(robot, gait.slope, state)[2:] for state in states])
    # what a controller is promised: far below its own errors, and continuous enough for integrators at 1e-10
    np.testing.assert_allclose(q, states[:, :2], rtol=0, atol=1e-12)
    np.testing.assert_allclose(dq, states[:, 2:], rtol=0, atol=1e-10)
    np.testing.assert_allclose(ddq, acceleration, rtol=0, atol=1e-8)
    assert gait.horizon > 1.2 * gait.period
    assert gait.horizon <= 2 * gait.period * (1 + 1e-12)
    assert abs(q[-1, 0]) < math.radians(60)


def test_reference_at_start_touchdown_and_beyond_the_horizon(gait: PassiveGait) -> None:
    q, dq, ddq = gait.reference(0.0)
    assert q.shape == dq.shape == ddq.shape == (2,)
    np.testing.assert_allclose(np.concatenate(gait.reference(gait.period)[:2]), gait.end, atol=1e-12)  # integration
    assert gait.horizon == pytest.approx(1.375 * gait.period, rel=1e-12)  # rounding
    last, _, _ = gait.reference(gait.horizon)
    for late in (gait.horizon * (1 + 1e-12), gait.horizon + 1, 1e6):
        q, dq, ddq = gait.reference(late)
        np.testing.assert_array_equal(q, last)
        np.testing.assert_array_equal([dq, ddq], np.zeros((2, 2)))


@pytest.mark.parametrize("kneed", [False, True])
def test_a_late_reference_comes_to_rest_without_a_jerk(gait: PassiveGait, kneed: bool) -> None:
    """Angles, rates and accelerations on both sides of the joints of pieces from the period on."""
    late = find_kneed_gait(KneedBiped(), math.radians(2.5)) if kneed else gait
    table = late.tables[-1]
    for joint in np.arange(round(late.period * table[RATE]), table[PIECES]) / table[RATE]:
        before, after = (np.reshape(motion_at(table, joint + side * 1e-10), (3, -1)) for side in (-1.0, 1.0))
        np.testing.assert_allclose(after, before, rtol=0, atol=1e-6, err_msg=f"{joint}")  # a jerk of 1e2 rad/s^3


@pytest.mark.parametrize("t", [-1e-9, [0.1, -0.1], math.nan, math.inf])
def test_times_outside_the_domain_are_refused(gait: PassiveGait, t: float) -> None:
    with pytest.raises(InputError, match=r"^t.*must be .*from 0 to 1e.09 s"):
        gait.reference(t)


@pytest.mark.parametrize(
    ("robot", "degrees", "reason"),
    [
        (TABLE_ONE, 0.0, "walks only downhill; give a slope above 0"),
        (TABLE_ONE, 28.0, "the trailing foot already stays down; choose a gentler slope"),
        pytest.param(Compass(leg_inertia=50.0), 2.0, "check the robot's", marks=pytest.mark.slow),
    ],
)
def test_no_gait_says_where_why_and_what_to_do(robot: Compass, degrees: float, reason: str) -> None:
    with pytest.raises(GaitError, match=rf"on a slope of {degrees:g} degrees: .*{reason}"):
        find_passive_gait(robot, math.radians(degrees))


@pytest.mark.slow
def test_the_branch_is_followed_without_slipping_onto_the_short_gaits() -> None:
    """Robots whose two families lie close together; periods from a continuation in 200 equal steps of slope^(2/3)."""
    robot = Compass(17.861791343329855, 10.013768995882199, 0.727497428185425, 0.7511974661092197, 0.0, 1.62)
    gait = find_passive_gait(robot, math.radians(3.38))
    assert gait.period * math.sqrt(robot.gravity / robot.leg_length) == pytest.approx(2.0166, abs=5e-5)
    robot = Compass(4.0476068818755735, 0.0, 0.5108529850266377, 0.8295473162746847, 0.10485215480397275)
    gait = find_passive_gait(robot, math.radians(2.37))
    assert gait.period * math.sqrt(robot.gravity / robot.leg_length) == pytest.approx(1.6860, abs=5e-5)


def test_guard_as_printed_ends_the_step_where_the_foot_scuffs(gait: PassiveGait) -> None:
    """Eq. (4) on 2 degrees holds first at 38 % of the step, 8.7 cm behind the stance foot: docs/model.md."""
    when = brentq(lambda t: gait.robot.swing_foot(gait.reference(t)[0])[1], 0.3 * gait.period, 0.42 * gait.period)
    assert when / gait.period == pytest.approx(0.38208, abs=5e-6)
    assert gait.robot.swing_foot(gait.reference(when)[0])[0] == pytest.approx(-0.086507, abs=5e-7)
