"""Measures against what they are by definition, computed from the samples or by hand."""

import json
import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.records import measures


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    terrain = mjbiped.Terrain.from_segments([(0.6, 0.0), (0.9, 2.0, -0.02), (5.0, -1.0)])
    return mjbiped.walk(controller, terrain, steps=5, sample_period=1e-5)


def test_work_is_the_integral_of_power(walk: mjbiped.Walk) -> None:
    """∫ |τ₁ q̇₁| + |τ₂ (q̇₂ - q̇₁)| dt from samples of every step, against the engine's sums of torque times way."""
    time = walk.samples["time"]
    torque, dq = (0.5 * (walk.samples[name][:-1] + walk.samples[name][1:]) for name in ("torque", "dq"))
    span = np.diff(time)
    moved = ~np.isin(time[1:], walk.touchdowns["time"])  # a contact step counts for no work
    ankle, hip = torque[:, 0] * dq[:, 0], torque[:, 1] * (dq[:, 1] - dq[:, 0])
    power = {
        "absolute": np.abs(ankle) + np.abs(hip),
        "net": ankle + hip,
        "positive": np.maximum(ankle, 0) + np.maximum(hip, 0),
    }
    for kind, values in power.items():
        expected = float(np.sum((values * span)[moved]))
        # what differs are steps of less than 1e-5 s, between two samples: some per touchdown, at up to 30 W
        assert measures.work(walk, kind) == pytest.approx(expected, abs=5 * 1e-5 * 30)


def test_cost_of_transport_by_hand(walk: mjbiped.Walk) -> None:
    cost = measures.work(walk) / (10.0 * 9.81 * walk.distance)
    assert walk.cost_of_transport == pytest.approx(cost, rel=1e-14)
    assert measures.cost_of_transport(walk, "net") <= measures.cost_of_transport(walk, "positive") <= cost


def test_distance_and_steps(walk: mjbiped.Walk) -> None:
    assert walk.distance == walk.touchdowns["x"][-1]
    lengths = measures.step_lengths(walk)
    assert lengths.shape == (5,)
    feet = np.column_stack([np.append(0, walk.touchdowns["x"]), np.append(0, walk.touchdowns["z"])])
    assert lengths == pytest.approx(np.linalg.norm(np.diff(feet, axis=0), axis=1), rel=1e-14)
    assert measures.step_periods(walk).sum() == pytest.approx(walk.touchdowns["time"][-1], rel=1e-14)
    assert measures.speed(walk) == walk.distance / walk.touchdowns["time"][-1]


def test_estimate_errors(walk: mjbiped.Walk) -> None:
    started, ended = measures.estimate_errors(walk)
    slopes = np.radians([0.0, 0.0, 2.0, 2.0, -1.0, -1.0])  # under the stance foot of each step, the first included
    assert walk.terrain.slope(np.append(0.0, walk.touchdowns["x"])) == pytest.approx(slopes, abs=1e-15)
    assert walk.touchdowns["slope"] == pytest.approx(slopes[1:], abs=1e-6)  # as the contacts show it
    assert started == pytest.approx(walk.touchdowns["slope_estimate"] - slopes[1:], abs=1e-6)
    assert ended == pytest.approx(walk.touchdowns["slope_estimate_before"] - slopes[:-1], abs=1e-6)


def test_samples_at_a_touchdown_are_in_the_new_roles(walk: mjbiped.Walk) -> None:
    """The sample taken at the support transfer shows what the touchdown's row does."""
    at = np.searchsorted(walk.samples["time"], walk.touchdowns["time"] - 1e-9)
    for name in ("time", "q", "dq", "slope", "stance", "qpos"):
        assert np.array_equal(walk.samples[name][at], walk.touchdowns[name]), name


def test_summary_is_plain_and_complete(walk: mjbiped.Walk) -> None:
    summary = measures.summary(walk)
    assert json.loads(json.dumps(summary)) == summary
    assert summary["outcome"] == "finished"
    assert summary["cost_of_transport"] == walk.cost_of_transport
    assert summary["peak_ankle_torque_Nm"] == walk.peak_torque[0]


def test_summary_says_none_where_there_is_nothing() -> None:
    fallen = mjbiped.walk(PassiveController(), mjbiped.Terrain.level(), initial=(-0.3, 0.3, 0.0, 0.0))
    summary = measures.summary(fallen)
    assert summary["cost_of_transport"] is None
    assert summary["final_estimate_error_deg"] is None
    assert summary["steps"] == 0


def test_unknown_kind_of_work_is_refused(walk: mjbiped.Walk) -> None:
    with pytest.raises(mjbiped.InputError, match="absolute, net, positive"):
        measures.work(walk, "gross")


def test_peak_torque_covers_the_samples(walk: mjbiped.Walk) -> None:
    assert walk.peak_torque == pytest.approx(np.abs(walk.samples["torque"]).max(axis=0), rel=1e-14)


def test_impact_errors_by_hand(walk: mjbiped.Walk) -> None:
    errors = measures.impact_errors(walk)
    assert errors.shape == (5, 2)
    robot = mjbiped.Compass()
    _, after = robot.impact(walk.touchdowns["q_before"][2], walk.touchdowns["dq_before"][2])
    assert errors[2] == pytest.approx(walk.touchdowns["dq"][2] / after - 1, abs=2e-14)  # some ten roundings each


def test_touchdown_posture_is_one_posture_in_two_roles(walk: mjbiped.Walk) -> None:
    """q1⁻ - q2⁺ of (27) is the change of slope, to rounding: the same legs, against two normals."""
    touchdowns = walk.touchdowns
    before = np.append(walk.terrain.slope(0.0), touchdowns["slope"])[:-1]
    change = touchdowns["q_before"][:, 0] - touchdowns["q"][:, 1]
    assert change == pytest.approx(touchdowns["slope"] - before, abs=1e-15)
    assert touchdowns["z"] == pytest.approx(walk.terrain.height(touchdowns["x"]), abs=3e-4)  # penetration
    assert not math.isnan(touchdowns["friction"].sum())


@pytest.mark.parametrize("parts", [[1] * 500, [200, 0, 300], [499, 1]])
def test_summary_in_parts_is_the_same_to_the_last_bit(walk: mjbiped.Walk, parts: list[int]) -> None:
    rows = {name: np.concatenate([column] * 100) for name, column in walk.touchdowns.items()}
    gathered, whole = (measures.Summary(walk.robot, walk.terrain) for _ in range(2))
    first = 0
    for count in parts:
        gathered.take({name: column[first : first + count] for name, column in rows.items()})
        first += count
        assert gathered.steps == first
    whole.take(rows)
    assert gathered.to_dict(walk) == whole.to_dict(walk)


def test_summary_holds_the_measures(walk: mjbiped.Walk) -> None:
    """Each figure against the function or the column that it is of."""
    found = measures.summary(walk)
    started, ended = np.degrees(np.abs(measures.estimate_errors(walk)))
    for name, expected in {
        "mean_step_length_m": measures.step_lengths(walk).mean(),
        "mean_step_period_s": measures.step_periods(walk).mean(),
        "cost_of_transport": measures.cost_of_transport(walk),
        "cost_of_transport_net": measures.cost_of_transport(walk, "net"),
        "cost_of_transport_positive": measures.cost_of_transport(walk, "positive"),
        "estimate_error_at_touchdown_deg": started.max(),
        "estimate_error_at_step_end_deg": ended.max(),
        "largest_impact_error": np.abs(measures.impact_errors(walk)).max(),
        "largest_slip_m": walk.touchdowns["slip"].max(),
        "largest_penetration_m": walk.touchdowns["penetration"].max(),
        "largest_stance_friction": walk.touchdowns["friction"].max(),
        "peak_hip_torque_Nm": walk.peak_torque[1],
        "speed_m_per_s": measures.speed(walk),
    }.items():
        assert found[name] == pytest.approx(expected, rel=1e-14), name  # sums in another order
    assert abs(found["final_estimate_error_deg"]) == pytest.approx(ended[-1], rel=1e-14)
