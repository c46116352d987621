"""Optimised gaits with knees: each demand checked by the robot's own functions, on a grid of our own."""

import json
import math

import numpy as np
import pytest

import mjbiped
from mjbiped.errors import GaitError
from mjbiped.gaits.described import gait_from
from mjbiped.gaits.optimised import OptimisedKneedGait
from mjbiped.gaits.steps import KneedStep

LIGHT, HALVED = mjbiped.KneedBiped(), mjbiped.KneedBiped.halved_rods()
HIGH = 0.08  # m

# c_mt of an earlier prototype of light shanks: ours must not cost more
PROTOTYPE = 0.0424

robots = pytest.mark.parametrize("gait", [LIGHT, pytest.param(HALVED, marks=pytest.mark.slow)], indirect=True)


@pytest.fixture(scope="module")
def gait(request: pytest.FixtureRequest) -> OptimisedKneedGait:
    robot: mjbiped.KneedBiped = request.param
    found = mjbiped.find_reference(robot, clearance=HIGH)
    assert isinstance(found, OptimisedKneedGait)
    return found


@robots
def test_it_repeats_itself_through_both_strikes(gait: OptimisedKneedGait) -> None:
    robot, knee = gait.robot, np.concatenate(gait.branch(gait.knee_strike, bent=True)[:2])
    q, dq = robot.heel_impact(gait.end[:2], gait.end[3:5])
    np.testing.assert_allclose(np.concatenate([q[[0, 1, 1]], dq[[0, 1, 1]]]), gait.start, rtol=0, atol=1e-10)
    assert knee[1] == pytest.approx(knee[2], abs=1e-10)
    q, dq = robot.knee_impact(knee[:3], knee[3:])
    # rounding of the branches' pieces, some 1e-12, times 25 of them in a period
    for time, bent, expected in (
        (0.0, True, gait.start),
        (gait.knee_strike, False, np.concatenate([q, dq])),
        (gait.period, False, gait.end[[0, 1, 3, 4]]),
    ):
        np.testing.assert_allclose(
            np.concatenate(gait.branch(time, bent=bent)[:2]), expected, rtol=0, atol=1e-10, err_msg=str(time)
        )
    assert gait.knee_strike <= 0.88 * gait.period + 1e-12


@robots
def test_every_demand_is_kept_between_the_optimisers_points(gait: OptimisedKneedGait) -> None:
    robot, model = gait.robot, KneedStep(gait.robot)
    s = np.linspace(0.0, 1.0, 4001)
    times = s * gait.period
    q, _dq, _ = gait.reference(times)
    foot = np.array([robot.swing_foot(each) for each in q])
    flexion = q[:, 2] - q[:, 1]
    bent = times < gait.knee_strike
    assert foot[1:-1, 1].min() > 0.0  # no ghost foot: above the ground at all times of the swing
    until = (s > 0.25) & (s <= gait.clearance_phase)
    # what the optimiser allows itself between its points, of leg lengths and of sqrt(g l) times the time of a step
    assert foot[until, 1].min() > HIGH - 5e-4
    assert np.diff(foot[s > gait.clearance_phase, 0]).max() < 5e-4 * math.sqrt(9.81) * gait.period / 4000
    assert foot[-1, 1] < foot[-2, 1]
    assert flexion[bent][1:].min() > 0.0
    assert np.abs(flexion[~bent]).max() == 0.0
    _, rates, _ = gait.branch(gait.knee_strike, bent=True)
    closing = rates[1] - rates[2]
    assert 0.31 < closing < 0.95  # rad/s: 0.1 to 0.3 of sqrt(g / l)
    for straight, chosen in ((False, bent), (True, ~bent)):
        course = model.course(*gait.branch(times[chosen], bent=not straight))  # checked in test_kneed_step.py
        assert course.normal_force.min() > 0.05 * robot.weight - 0.05
        assert np.abs(course.tangential_force / course.normal_force).max() < 0.6 + 1e-3
    assert gait.speed == pytest.approx(0.494, rel=1e-12)


@robots
def test_cost_by_another_quadrature(gait: OptimisedKneedGait) -> None:
    """The trapezoidal rule over the branches' pieces, with the robot's own matrices."""
    robot, work = gait.robot, 0.0
    for bent, first, last in ((True, 0.0, gait.knee_strike), (False, gait.knee_strike, gait.period)):
        times = np.linspace(first, last, 1500)
        power = []
        for q, dq, ddq in zip(*gait.branch(times, bent=bent), strict=True):
            force = robot.mass_matrix(q) @ ddq + robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, 0.0)
            torque = np.cumsum(force[::-1])[::-1]
            power.append(np.abs(torque * np.diff(dq, prepend=0.0)).sum())
        work += float(np.trapezoid(power, times))
    # corners of |power| and the rule's error, both of some (1 / 1500)^2 of curvatures up to 1e2
    assert gait.cost_of_transport == pytest.approx(work / (robot.weight * gait.step_length), rel=1e-4)
    if robot == LIGHT:
        assert gait.cost_of_transport < PROTOTYPE


@pytest.mark.parametrize("gait", [LIGHT], indirect=True)
def test_branches_reach_over_the_whole_step_and_beyond(gait: OptimisedKneedGait) -> None:
    times = np.linspace(0.0, 0.999 * gait.horizon, 20001)
    for bent in (True, False):
        q, dq, ddq = gait.branch(times, bent=bent)
        # central differences of steps of 80 us: third derivatives of 1e4 / s^3 at most, times its square
        np.testing.assert_allclose(np.gradient(q, times, axis=0)[1:-1], dq[1:-1], rtol=0, atol=1e-4)
        smooth = np.abs(times - gait.knee_strike) > 2e-4  # there the straight branch's acceleration may jump
        np.testing.assert_allclose(np.gradient(dq, times, axis=0)[smooth][1:-1], ddq[smooth][1:-1], rtol=0, atol=0.1)
    late = times > gait.knee_strike
    q, dq, _ = gait.branch(times[late], bent=True)
    assert (q[1:, 2] < q[1:, 1]).all()  # it drives on past the stop
    q, dq, ddq = gait.branch(gait.horizon + 1.0, bent=False)
    assert not dq.any()
    assert not ddq.any()
    assert q[0] > 0.8  # the stance leg has fallen


@pytest.mark.parametrize("gait", [LIGHT], indirect=True)
def test_a_description_is_the_gait_bit_by_bit(gait: OptimisedKneedGait) -> None:
    again = gait_from(json.loads(json.dumps(gait.describe())))
    assert isinstance(again, OptimisedKneedGait)
    assert again == gait
    assert hash(again) == hash(gait)
    assert again.tables == gait.tables
    assert repr(gait).startswith("<OptimisedKneedGait at 0.494 m/s with 0.08 m of clearance: c_mt 0.04")


@pytest.mark.slow
def test_what_knees_save() -> None:
    """Without clearance and without retraction walking costs far less than straight legs ask for."""
    flat = mjbiped.find_reference(LIGHT, clearance=0.0)
    assert flat.cost_of_transport < 0.0102
    assert min(LIGHT.swing_foot(q)[1] for q in flat.reference(np.linspace(0.01, 0.99, 99) * flat.period)[0]) > 0.0
    assert mjbiped.find_reference(LIGHT, clearance=HIGH, retraction=False).cost_of_transport < 0.0204


@pytest.mark.slow
def test_what_cannot_be_says_why() -> None:
    with pytest.raises(GaitError, match=r"torque limit of 1 N m: without .* needs .* N m; raise the limit"):
        mjbiped.find_reference(LIGHT, clearance=0.02, torque_limit=1.0)
