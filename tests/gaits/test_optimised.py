"""Optimised references: each demand checked by the robot's own functions, and the cost as walked in both engines."""

import io
import json
import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import stored_references

import mjbiped
from controllers import AdaptiveController, KineticEnergyController, LimitCycleController
from mjbiped.errors import GaitError, InputError
from mjbiped.gaits import optimised, passive, store
from mjbiped.gaits.described import gait_from
from mjbiped.gaits.optimisation import TOLERANCE, motion_of, optimise, tell
from mjbiped.gaits.optimised import OptimisedGait, find_reference
from mjbiped.gaits.steps import CompassStep, Goal

# clearance (m); period (s), half angle (rad) and c_mt of an independent prototype, whose retraction began at a fixed
# phase: ours, which chooses the phase, must not cost more
PROTOTYPE = ((0.04, 0.755, 0.188, 0.0349), (0.06, 0.801, 0.199, 0.042), (0.10, 0.872, 0.217, 0.055))


USUAL = {"robot": mjbiped.Compass().to_dict(), "goal": asdict(Goal(0.494, 0.06, True, None, 0.6))}


@pytest.fixture(scope="module")
def high(robot: mjbiped.Compass) -> OptimisedGait:
    return find_reference(robot, clearance=0.06)


@pytest.mark.slow
@pytest.mark.parametrize(("clearance", "period", "half", "cost"), PROTOTYPE)
def test_a_prototypes_values(robot: mjbiped.Compass, clearance: float, period: float, half: float, cost: float) -> None:
    gait = find_reference(robot, clearance=clearance)
    assert gait.cost_of_transport < cost
    assert gait.cost_of_transport == pytest.approx(cost, rel=0.06)
    assert (gait.period, gait.end[0]) == pytest.approx((period, half), rel=0.04)


@pytest.mark.slow
def test_without_clearance_walking_costs_less_than_passive_walking(robot: mjbiped.Compass) -> None:
    gait = find_reference(robot, clearance=0.0)
    assert gait.cost_of_transport < 0.022  # what was asked for; the paper's controller needs sin 2° = 0.0349
    assert gait.speed == pytest.approx(0.494, rel=1e-12)


@pytest.mark.parametrize(
    "each",
    [
        pytest.param(each, marks=[] if each["asked"] == USUAL else pytest.mark.slow)
        for each in stored_references.stored()
    ],
)
def test_searches_end_where_the_stored_ones_did(each: dict[str, Any]) -> None:
    """Other processors round otherwise, and the optimiser ends elsewhere on the floor of a flat valley."""
    model, goal = stored_references.request(each["asked"])
    here, there = (tell(model, goal, np.array(x)) for x in (optimise(model, goal), each["x"]))
    assert max(there.broken.values()) < TOLERANCE
    # SLSQP stops where a step gains less than 1e-9; by other ways it ended within 1.4e-6 of the cost
    assert here.cost_of_transport == pytest.approx(there.cost_of_transport, rel=1e-5)


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


@pytest.mark.slow
def test_a_robot_of_four_times_the_size_walks_the_same_gait() -> None:
    """On a sole of four times the length: the optimiser sees no units, and a power of two is not even rounded."""
    small, large = (
        find_reference(
            mjbiped.Compass(lower_length=0.5 * size, upper_length=0.5 * size, sole=(0.005 * size, 0.005 * size)),
            speed=0.494 * math.sqrt(size),
            clearance=0.06 * size,
        )
        for size in (1.0, 4.0)
    )
    np.testing.assert_allclose(large.start[:2], small.start[:2], rtol=1e-12)
    assert large.period == pytest.approx(2.0 * small.period, rel=1e-12)


def test_it_repeats_itself_exactly(robot: mjbiped.Compass, high: OptimisedGait) -> None:
    q, dq = robot.impact(high.end[:2], high.end[2:])
    np.testing.assert_array_equal(q, high.start[:2])
    np.testing.assert_allclose(dq, high.start[2:], rtol=0, atol=1e-13)  # rounding
    first, last = (np.concatenate([each[0] for each in high.reference([t])[:2]]) for t in (0.0, high.period))
    # rounding of the table's pieces, some 1e-12, times 16 of them in a period
    np.testing.assert_allclose(first, high.start, rtol=0, atol=1e-10)
    np.testing.assert_allclose(last, high.end, rtol=0, atol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("limit", [pytest.param(None, marks=pytest.mark.slow), 12.0])
def test_every_demand_is_kept_between_the_optimisers_points(robot: mjbiped.Compass, limit: float | None) -> None:
    gait = find_reference(robot, clearance=0.05, torque_limit=limit)
    s = np.linspace(0.0, 1.0, 5001)
    q, dq, ddq = gait.reference(s * gait.period)
    foot = np.array([robot.swing_foot(each) for each in q])
    back = s >= gait.clearance_phase
    # what the optimiser allows itself between its points, of leg lengths and of sqrt(g l) times the time of a step
    assert foot[np.argmax(back), 1] == pytest.approx(0.05, abs=5e-4)
    assert np.diff(foot[back, 0]).max() < 5e-4 * math.sqrt(9.81) * gait.period / 5000
    assert foot[(foot[:, 0] > 0.2) & (s < 0.999), 1].min() > 0.0
    assert foot[-1, 1] < foot[-2, 1]
    course = CompassStep(robot).course(q, dq, ddq)  # checked against MuJoCo and the matrices in test_compass_step.py
    assert course.normal_force.min() > 0.05 * robot.weight - 0.05
    assert np.abs(course.tangential_force / course.normal_force).max() < 0.6 + 1e-3
    if limit is not None:
        assert np.abs(course.torques).max() < limit + 0.05
        assert gait.cost_of_transport > find_reference(robot, clearance=0.05).cost_of_transport


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "tolerance"), [("hybrid", 1e-4), ("mujoco", 2e-3)])
def test_cost_as_walked(high: OptimisedGait, engine: str, tolerance: float) -> None:
    """The hybrid engine finds the power's changes of sign only where they lie apart, MuJoCo's contacts err by 0.1 %."""
    walk = mjbiped.walk(AdaptiveController(high.robot, high), mjbiped.Terrain.level(), engine=engine, steps=12)
    assert walk.outcome == "finished"
    assert walk.cost_of_transport == pytest.approx(high.cost_of_transport, rel=tolerance)
    assert walk.peak_torque.max() == pytest.approx(max(high.measures.peak_torque), rel=10 * tolerance)


def test_no_small_change_makes_it_cheaper(robot: mjbiped.Compass) -> None:
    goal = Goal(0.494, 0.0, True, None, 0.6)
    gait, model = find_reference(robot, clearance=0.0), CompassStep(robot)
    random = np.random.default_rng(0)
    best = np.concatenate([[gait.clearance_phase, gait.end[0]], gait.control_points[2:-1].ravel()])
    for _ in range(100):
        told = tell(model, goal, best + 2e-3 * np.append(0.0, random.standard_normal(len(best) - 1)))
        if max(told.broken.values()) <= 0.0:
            # the cost that is minimised has the torques' squares in it, too, and corners rounded by 2e-4
            assert told.cost_of_transport > gait.cost_of_transport - 1e-4


@pytest.mark.slow
def test_what_cannot_be_says_why(robot: mjbiped.Compass) -> None:
    with pytest.raises(GaitError, match=r"torque limit of 0.5 N m: without .* needs 24.8 N m; raise the limit"):
        find_reference(robot, clearance=0.06, torque_limit=0.5)
    with pytest.raises(
        GaitError, match=r"2 m/s, a clearance of 0.05 m: with a clearance of 0\S* m there is one; ask for"
    ):
        find_reference(robot, speed=2.0, clearance=0.05)
    with pytest.raises(GaitError, match=r"a speed of 9 m/s without clearance: the best one breaks the constraint '.*'"):
        find_reference(robot, speed=9.0, clearance=0.0)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"speed": 0.0}, "speed = 0.0"),
        ({"clearance": -0.01}, "clearance = -0.01"),
        ({"torque_limit": math.inf}, "torque_limit = inf"),
        ({"friction": "much"}, "friction = 'much'"),
        ({"retraction": 1}, "retraction = 1: must be True or False"),
    ],
)
def test_bad_numbers_are_refused(robot: mjbiped.Compass, wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        find_reference(robot, **wrong)
    with pytest.raises(InputError, match=r"robot must be a mjbiped\.Compass"):
        find_reference("compass")  # type: ignore[arg-type]


def test_a_description_is_the_gait_bit_by_bit(high: OptimisedGait) -> None:
    again = gait_from(json.loads(json.dumps(high.describe())))
    assert isinstance(again, OptimisedGait)
    assert again == high
    assert again.tables[0] == high.tables[0]
    assert hash(again) == hash(high)
    assert again != replace(high, clearance_phase=0.5)


def test_a_record_tells_what_was_tracked(high: OptimisedGait, tmp_path: Path) -> None:
    from mjbiped.analysis.replay import recorded_controller

    controller = AdaptiveController(high.robot, high, replanning="additive")
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=2)
    walk.save(tmp_path / "walk.npz")
    loaded = mjbiped.Walk.load(tmp_path / "walk.npz")
    assert recorded_controller(loaded) == controller


def test_controllers_that_follow_in_time_track_it(high: OptimisedGait) -> None:
    follower = LimitCycleController(high.robot, high)
    walk = mjbiped.walk(follower, mjbiped.Terrain.level(), engine="hybrid", steps=5)
    assert walk.cost_of_transport == pytest.approx(high.cost_of_transport, rel=1e-4)  # as above
    with pytest.raises(InputError, match=r"KineticEnergyController .*needs a passive gait .*AdaptiveController"):
        KineticEnergyController(high.robot, high)


@pytest.mark.slow
@pytest.mark.parametrize("replanning", ["paper", "additive"])
def test_it_climbs_what_the_passive_gait_does_not(gait: mjbiped.Gait, replanning: str) -> None:
    """A step of 0.06 m at twelve places of its edge, at the paper's cost; under 50 N m down a step of 0.1 m, too."""
    cheap = find_reference(gait.robot, clearance=0.04)
    assert cheap.cost_of_transport < 0.036
    for imitated, rise, climbed in ((cheap, 0.06, 12), (cheap, -0.1, 12), (gait, 0.06, 0)):
        controller = AdaptiveController(gait.robot, imitated, replanning=replanning)
        walks = [
            mjbiped.walk(
                controller,
                mjbiped.Terrain.from_segments([((2 + k / 12) * imitated.step_length, 0, 0), (50, 0, rise)]),
                engine="hybrid", steps=12, sample_period=None,
            )
            for k in range(12)
        ]  # fmt: skip
        assert sum(walk.outcome == "finished" for walk in walks) == climbed
        if climbed:
            assert max(walk.peak_torque.max() for walk in walks) < 50.0


@pytest.mark.slow
def test_without_retraction_the_same_height_costs_less(robot: mjbiped.Compass, high: OptimisedGait) -> None:
    height = high.measures.greatest_clearance
    free = find_reference(robot, clearance=height, retraction=False)
    assert free.cost_of_transport < 0.95 * high.cost_of_transport
    assert free.measures.greatest_clearance == pytest.approx(height, abs=1e-4)  # the constraint is active


# --- on disk ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for references, and nothing remembered."""
    monkeypatch.setenv("MJBIPED_CACHE_DIR", str(tmp_path / "kept"))
    optimised._find.cache_clear()
    return tmp_path / "kept"


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "text", "array"])
def test_a_damaged_file_counts_as_none(folder: Path, damage: str) -> None:
    numbers = np.linspace(0.0, 1.0, 50) / 3.0
    store.save({"a": 1}, {"numbers": numbers, "one": 1.0 / 3.0})
    (file,) = folder.iterdir()
    kept = store.load({"a": 1})
    assert kept is not None
    np.testing.assert_array_equal(kept["numbers"], numbers)
    assert (kept["one"], type(kept["one"])) == (1.0 / 3.0, float)
    whole = file.read_bytes()
    at = whole.index(numbers.tobytes()) + 8
    array = io.BytesIO()
    np.save(array, numbers)
    file.write_bytes(
        {
            "cut": whole[:-30],
            "flipped": whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :],
            "empty": b"",
            "text": b'{"numbers": [1.0]}',
            "array": array.getvalue(),
        }[damage]
    )
    assert store.load({"a": 1}) is None


@pytest.mark.slow
def test_a_passive_gait_is_kept(robot: mjbiped.Compass, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same bit by bit."""
    slope = math.radians(1.7)
    store.passive.cache_clear()
    first = mjbiped.find_passive_gait(robot, slope)
    store.passive.cache_clear()
    with monkeypatch.context() as patched:
        patched.setattr(passive, "_search", None)  # not called
        again = mjbiped.find_passive_gait(robot, slope)
    assert again is not first
    assert again.tables[0] == first.tables[0]
    for name in ("start", "end", "multipliers"):
        assert getattr(again, name).tobytes() == getattr(first, name).tobytes()
    assert (again.period, again.step_length) == (first.period, first.step_length)


def test_the_users_own_cache_is_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MJBIPED_CACHE_DIR", raising=False)
    assert store.folder().parts[-2:] == ("mjbiped", "references")


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
