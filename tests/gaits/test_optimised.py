"""Optimised references: each demand checked by the robot's own functions, and the cost as walked in both engines."""

import json
import math
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import stored_references

import mjbiped
from controllers import AdaptiveController
from mjbiped import InputError, OptimisedGait, find_reference
from mjbiped.gaits import optimised, store
from mjbiped.gaits.described import gait_from
from mjbiped.gaits.optimisation import TOLERANCE, motion_of, optimise, tell
from mjbiped.gaits.steps import CompassStep, Goal

# clearance (m); period (s), half angle (rad) and c_mt of an independent prototype, whose retraction began at a fixed
# phase: ours, which chooses the phase, must not cost more
PROTOTYPE = ((0.04, 0.755, 0.188, 0.0349), (0.06, 0.801, 0.199, 0.042), (0.10, 0.872, 0.217, 0.055))
KNEED_PROTOTYPE = 0.0424  # c_mt of one with light shanks
HIGH = 0.08  # clearance with knees, m
LIGHT, HALVED = mjbiped.KneedBiped(), mjbiped.KneedBiped.halved_rods()

USUAL = {"robot": mjbiped.Compass().to_dict(), "goal": asdict(Goal(0.494, 0.06, True, None, 0.6))}
STORED = stored_references.stored()


@pytest.fixture(scope="module")
def high(robot: mjbiped.Compass) -> OptimisedGait:
    return find_reference(robot, clearance=0.06)


@pytest.fixture(scope="module")
def kneed(request: pytest.FixtureRequest) -> OptimisedGait:
    return find_reference(request.param, clearance=HIGH)


with_knees = pytest.mark.parametrize("kneed", [LIGHT, pytest.param(HALVED, marks=pytest.mark.slow)], indirect=True)


@pytest.mark.slow
@pytest.mark.parametrize(("clearance", "period", "half", "cost"), PROTOTYPE)
def test_a_prototypes_values(robot: mjbiped.Compass, clearance: float, period: float, half: float, cost: float) -> None:
    gait = find_reference(robot, clearance=clearance)
    assert gait.cost_of_transport < cost
    assert gait.cost_of_transport == pytest.approx(cost, rel=0.06)
    assert (gait.period, gait.end[0]) == pytest.approx((period, half), rel=0.04)


@pytest.mark.parametrize(
    "each", [pytest.param(each, marks=[] if each["asked"] == USUAL else pytest.mark.slow) for each in STORED]
)
def test_searches_end_where_the_stored_ones_did(each: dict[str, Any]) -> None:
    """Other processors round otherwise, and the optimiser ends elsewhere on the floor of a flat valley."""
    model, goal = stored_references.request(each["asked"])
    here, there = (tell(model, goal, np.array(x)) for x in (optimise(model, goal), each["x"]))
    assert max(there.broken.values()) < TOLERANCE
    # SLSQP stops where a step gains less than 1e-9; by other ways it ended within 1.4e-6 of the cost
    assert here.cost_of_transport == pytest.approx(there.cost_of_transport, rel=1e-5)


# ---- demands ---------------------------------------------------------------------------------------------------------


@with_knees
def test_it_repeats_itself_through_both_strikes(kneed: OptimisedGait) -> None:
    robot, strike = kneed.robot, float(kneed.knee_strike or 0.0)
    knee = np.concatenate(kneed.branch(strike, bent=True)[:2])
    q, dq = robot.heel_impact(kneed.end[:2], kneed.end[3:5])
    np.testing.assert_allclose(np.concatenate([q[[0, 1, 1]], dq[[0, 1, 1]]]), kneed.start, rtol=0, atol=1e-10)
    assert knee[1] == pytest.approx(knee[2], abs=1e-10)
    struck = np.concatenate(robot.knee_impact(knee[:3], knee[3:]))
    # rounding of the branches' pieces, some 1e-12, times 25 of them in a period
    ends = ((0.0, True, kneed.start), (strike, False, struck), (kneed.period, False, kneed.end[[0, 1, 3, 4]]))
    for time, bent, expected in ends:
        np.testing.assert_allclose(np.concatenate(kneed.branch(time, bent=bent)[:2]), expected, rtol=0, atol=1e-10)
    assert strike <= 0.88 * kneed.period + 1e-12


def assert_bearable(gait: OptimisedGait, *branches: tuple[Any, Any, Any]) -> float:
    """The ground pushes, and friction holds; returns the greatest torque, N m. `test_steps.py` checks the dynamics."""
    greatest = 0.0
    for branch in branches:
        course = gait.model.course(*branch)
        assert course.normal_force.min() > 0.05 * gait.robot.weight - 0.05
        assert np.abs(course.tangential_force / course.normal_force).max() < 0.6 + 1e-3
        greatest = max(greatest, float(np.abs(course.torques).max()))
    return greatest


@pytest.mark.slow
@pytest.mark.parametrize("limit", [None, 12.0])
def test_every_demand_is_kept_between_the_optimisers_points(robot: mjbiped.Compass, limit: float | None) -> None:
    gait = find_reference(robot, clearance=0.05, torque_limit=limit)
    s = np.linspace(0.0, 1.0, 5001)
    q, dq, ddq = gait.reference(s * gait.period)
    foot, back = robot.swing_foot(q), s >= gait.clearance_phase
    # what the optimiser allows itself between its points, of leg lengths and of sqrt(g l) times the time of a step
    assert foot[np.argmax(back), 1] == pytest.approx(0.05, abs=5e-4)
    assert np.diff(foot[back, 0]).max() < 5e-4 * math.sqrt(9.81) * gait.period / 5000
    assert foot[(foot[:, 0] > 0.2) & (s < 0.999), 1].min() > 0.0
    assert foot[-1, 1] < foot[-2, 1]
    assert assert_bearable(gait, (q, dq, ddq)) < (math.inf if limit is None else limit + 0.05)
    assert limit is None or gait.cost_of_transport > find_reference(robot, clearance=0.05).cost_of_transport


@with_knees
def test_every_demand_is_kept_with_knees(kneed: OptimisedGait) -> None:
    s = np.linspace(0.0, 1.0, 4001)
    times, strike = s * kneed.period, float(kneed.knee_strike or 0.0)
    q, bent = kneed.reference(times)[0], times < strike
    foot, flexion = kneed.robot.swing_foot(q), q[:, 2] - q[:, 1]
    assert foot[1:-1, 1].min() > 0.0  # no ghost foot: above the ground at all times of the swing
    until = (s > 0.25) & (s <= kneed.clearance_phase)
    # what the optimiser allows itself between its points, of leg lengths and of sqrt(g l) times the time of a step
    assert foot[until, 1].min() > HIGH - 5e-4
    assert np.diff(foot[s > kneed.clearance_phase, 0]).max() < 5e-4 * math.sqrt(9.81) * kneed.period / 4000
    assert foot[-1, 1] < foot[-2, 1]
    assert flexion[bent][1:].min() > 0.0
    assert np.abs(flexion[~bent]).max() == 0.0
    _, rates, _ = kneed.branch(strike, bent=True)
    assert 0.31 < rates[1] - rates[2] < 0.95  # rad/s: 0.1 to 0.3 of sqrt(g / l)
    assert_bearable(kneed, *(kneed.branch(times[bent == free], bent=free) for free in (True, False)))
    assert kneed.speed == pytest.approx(0.494, rel=1e-12)
    late = np.linspace(strike + 1e-3, kneed.horizon, 500)
    q, _, _ = kneed.branch(late, bent=True)
    assert (q[:, 2] < q[:, 1]).all()  # it drives on past the stop
    assert kneed.branch(kneed.horizon, bent=False)[0][0] > 0.8  # the stance leg has fallen


@with_knees
def test_cost_by_another_quadrature(kneed: OptimisedGait) -> None:
    """The trapezoidal rule over the branches' pieces, with the robot's own matrices."""
    robot, work, strike = kneed.robot, 0.0, float(kneed.knee_strike or 0.0)
    for bent, first, last in ((True, 0.0, strike), (False, strike, kneed.period)):
        times = np.linspace(first, last, 1500)
        power = []
        for q, dq, ddq in zip(*kneed.branch(times, bent=bent), strict=True):
            force = robot.mass_matrix(q) @ ddq + robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, 0.0)
            torque = np.cumsum(force[::-1])[::-1]
            power.append(np.abs(torque * np.diff(dq, prepend=0.0)).sum())
        work += float(np.trapezoid(power, times))
    # corners of |power| and the rule's error, both of some (1 / 1500)^2 of curvatures up to 1e2
    assert kneed.cost_of_transport == pytest.approx(work / (robot.weight * kneed.step_length), rel=1e-4)
    assert robot != LIGHT or kneed.cost_of_transport < KNEED_PROTOTYPE


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "tolerance"), [("hybrid", 1e-4), ("mujoco", 2e-3)])
def test_cost_as_walked(high: OptimisedGait, engine: str, tolerance: float) -> None:
    """The hybrid engine finds the power's changes of sign only where they lie apart, MuJoCo's contacts err by 0.1 %."""
    walk = mjbiped.walk(AdaptiveController(high.robot, high), mjbiped.Terrain.level(), engine=engine, steps=12)
    assert walk.outcome == "finished"
    assert walk.cost_of_transport == pytest.approx(high.cost_of_transport, rel=tolerance)
    assert walk.peak_torque.max() == pytest.approx(max(high.measures.peak_torque), rel=10 * tolerance)


@pytest.mark.parametrize("ahead", [-1.0, 1.0])
def test_friction_is_bounded_whichever_way_the_foot_pushes(robot: mjbiped.Compass, ahead: float) -> None:
    """Of steps whose stance leg leans forwards early, or late: the ground pushes more forwards, or backwards."""
    model = CompassStep(robot)
    goal = Goal(speed=0.5, clearance=0.0, retraction=False, torque_limit=None, friction=1.0)
    points, own = model.guess(0.2)
    points[2:-1, 0] += 0.1 * ahead
    x = np.concatenate([[0.5, 0.2], points[2:-1].ravel(), own])
    course = model.along(motion_of(model, goal, x), [np.linspace(0.0, 1.0, 500)])
    forwards, backwards = (float((side * course.tangential_force / course.normal_force).max()) for side in (1, -1))
    assert (forwards - backwards) * ahead > 0.1
    enough = max(forwards, backwards)
    for friction, broken in ((0.5 * (forwards + backwards), True), (0.99 * enough, True), (1.01 * enough, False)):
        told = tell(model, replace(goal, friction=friction), x)
        assert (told.broken["friction"] > 0.0) == broken
        assert told.friction == pytest.approx(enough, rel=1e-3)


# ---- refusals --------------------------------------------------------------------------------------------------------


WRONG: tuple[dict[str, Any], ...] = (
    *({"speed": 0.0}, {"clearance": 1.0}, {"torque_limit": math.inf}, {"friction": "much"}, {"retraction": 1}),
    {"robot": "compass"},
)


@pytest.mark.parametrize("wrong", WRONG)
def test_bad_input_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        find_reference(**{"robot": mjbiped.Compass(), **wrong})


def test_a_torque_that_is_too_small_is_told_beside_the_one_that_is_enough() -> None:
    words = "a clearance of 0.05 m and a torque limit of 1 N m: without the torque limit .* needs 21.3 N m"
    with pytest.raises(mjbiped.GaitError, match=words):
        find_reference(mjbiped.Compass(), clearance=0.05, torque_limit=1.0)


# ---- on disk ---------------------------------------------------------------------------------------------------------


def test_a_description_is_the_gait_bit_by_bit(high: OptimisedGait) -> None:
    for gait in (high, find_reference(LIGHT, clearance=HIGH)):
        again = gait_from(json.loads(json.dumps(gait.describe())))
        assert isinstance(again, OptimisedGait)
        assert (again, again.tables, hash(again)) == (gait, gait.tables, hash(gait))
        assert again != replace(gait, clearance_phase=0.5)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for references, and nothing remembered."""
    monkeypatch.setenv("MJBIPED_CACHE_DIR", str(tmp_path / "kept"))
    optimised._find.cache_clear()
    store.passive.cache_clear()
    return tmp_path / "kept"


@pytest.mark.parametrize("damage", [lambda data: data[:-30], lambda _: b"", lambda _: b'{"numbers": [1.0]}'])
def test_a_damaged_file_counts_as_none(folder: Path, damage: Callable[[bytes], bytes]) -> None:
    numbers = np.linspace(0.0, 1.0, 50) / 3.0
    store.save({"a": 1}, {"numbers": numbers, "one": 1.0 / 3.0})
    (file,) = folder.iterdir()
    kept = store.load({"a": 1})
    assert kept is not None
    np.testing.assert_array_equal(kept["numbers"], numbers)
    assert (kept["one"], type(kept["one"])) == (1.0 / 3.0, float)
    file.write_bytes(damage(file.read_bytes()))
    assert store.load({"a": 1}) is None


def test_a_passive_gait_is_kept_bit_by_bit(robot: mjbiped.Compass, folder: Path) -> None:
    first = mjbiped.find_passive_gait(robot, math.radians(1.7))
    (file,) = folder.iterdir()
    written = file.stat().st_mtime_ns
    store.passive.cache_clear()
    again = mjbiped.find_passive_gait(robot, math.radians(1.7))
    assert again is not first
    assert file.stat().st_mtime_ns == written  # it was not searched for again
    assert again.tables == first.tables
    for name in ("start", "end", "multipliers", "period", "step_length"):
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name))


@pytest.mark.slow
def test_the_centre_of_pressure_stays_on_a_sole() -> None:
    """By the robot's own matrices; without the sole it lies up to 28 mm behind the ankle."""
    robot = mjbiped.Compass(sole=(0.005, 0.005))
    gait = find_reference(robot, clearance=0.06)
    places = []
    for q, dq, ddq in zip(*gait.reference(np.linspace(0.0, gait.period * (1.0 - 1e-6), 400)), strict=True):
        forces = robot.mass_matrix(q) @ ddq + robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, 0.0)
        torques = np.linalg.solve(robot.input_matrix, forces)
        places.append(-torques[0] / robot.ground_force(q, dq, torques, 0.0)[1])
    # 5e-4 leg lengths is what a constraint may be broken by between the optimiser's points; measured 1e-4
    assert np.abs(places).max() == pytest.approx(0.005, abs=5e-4)
    assert gait.cost_of_transport > 2.0 * find_reference(mjbiped.Compass(), clearance=0.06).cost_of_transport
