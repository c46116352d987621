"""Measures against what they are by definition, computed from the samples or by hand, and how a walk shows them."""

import base64
import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.control.registry import make_controller
from mjbiped.records import measures
from mjbiped.records.columns import Recorder


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
    positive = np.maximum(ankle, 0) + np.maximum(hip, 0)
    power = {"absolute": np.abs(ankle) + np.abs(hip), "net": ankle + hip, "positive": positive}
    summary = measures.summary(walk)
    for kind, values in power.items():
        expected = float(np.sum((values * span)[moved]))
        # what differs are steps of less than 1e-5 s, between two samples: some per touchdown, at up to 30 W
        assert measures.work(walk, kind) == pytest.approx(expected, abs=5 * 1e-5 * 30)
        cost = measures.work(walk, kind) / (10.0 * 9.81 * walk.distance)
        assert measures.cost_of_transport(walk, kind) == pytest.approx(cost, rel=1e-14)
        key = "cost_of_transport" + {"absolute": ""}.get(kind, f"_{kind}")
        assert summary[key] == pytest.approx(cost, rel=1e-14)
    torque, dq = walk.samples["torque"], walk.samples["dq"]
    assert np.array_equal(measures.powers(walk), torque * np.column_stack([dq[:, 0], dq[:, 1] - dq[:, 0]]))
    with pytest.raises(mjbiped.InputError, match="absolute, net, positive"):
        measures.work(walk, "gross")


def test_steps_by_hand(walk: mjbiped.Walk) -> None:
    touchdowns, summary = walk.touchdowns, measures.summary(walk)
    assert walk.distance == touchdowns["x"][-1] == summary["distance_m"]
    feet = np.column_stack([np.append(0, touchdowns["x"]), np.append(0, touchdowns["z"])])
    lengths = np.linalg.norm(np.diff(feet, axis=0), axis=1)
    assert measures.step_lengths(walk) == pytest.approx(lengths, rel=1e-14)
    assert summary["mean_step_length_m"] == pytest.approx(lengths.mean(), rel=1e-14)
    assert measures.step_periods(walk) == pytest.approx(np.diff(np.append(0.0, touchdowns["time"])), rel=1e-14)
    assert summary["mean_step_period_s"] == pytest.approx(touchdowns["time"][-1] / 5, rel=1e-14)
    assert measures.speed(walk) == summary["speed_m_per_s"] == walk.distance / touchdowns["time"][-1]
    at_once = replace(walk, touchdowns={**touchdowns, "time": touchdowns["time"] * 0.0})
    assert math.isnan(measures.speed(at_once))
    assert measures.summary(at_once)["speed_m_per_s"] is None


def test_errors_by_hand(walk: mjbiped.Walk) -> None:
    touchdowns, summary = walk.touchdowns, measures.summary(walk)
    slopes = np.radians([0.0, 0.0, 2.0, 2.0, -1.0, -1.0])  # under the stance foot of each step, the first included
    assert touchdowns["slope"] == pytest.approx(slopes[1:], abs=1e-6)  # as the contacts show it
    started, ended = measures.estimate_errors(walk)
    assert started == pytest.approx(touchdowns["slope_estimate"] - slopes[1:], abs=1e-6)
    assert ended == pytest.approx(touchdowns["slope_estimate_before"] - slopes[:-1], abs=1e-6)
    errors = measures.impact_errors(walk)
    assert errors.shape == (5, 2)
    _, after = mjbiped.Compass().impact(touchdowns["q_before"][2], touchdowns["dq_before"][2])
    assert errors[2] == pytest.approx(touchdowns["dq"][2] / after - 1, abs=2e-14)  # some ten roundings each
    for name, expected in {
        "estimate_error_at_touchdown_deg": np.degrees(np.abs(started)).max(),
        "estimate_error_at_step_end_deg": np.degrees(np.abs(ended)).max(),
        "final_estimate_error_deg": np.degrees(ended[-1]),
        "largest_impact_error": np.abs(errors).max(),
        "largest_slip_m": touchdowns["slip"].max(),
        "largest_penetration_m": touchdowns["penetration"].max(),
        "largest_stance_friction": touchdowns["friction"].max(),
        "least_normal_force_weights": touchdowns["normal_force"].min() / walk.robot.weight,
        "peak_ankle_torque_Nm": walk.peak_torque[0],
        "peak_hip_torque_Nm": walk.peak_torque[1],
    }.items():
        assert summary[name] == pytest.approx(expected, rel=1e-14), name
    assert walk.peak_torque == pytest.approx(np.abs(walk.samples["torque"]).max(axis=0), rel=1e-14)


def test_a_contact_that_the_ground_cannot_give_is_told(walk: mjbiped.Walk) -> None:
    """Of five steps one pulls, and two need more friction than 0.8, of which one pulls as well."""
    force, friction = np.array([50.0, -1.0, 50.0, 50.0, 50.0]), np.array([0.5, 0.2, 0.9, 0.7, 0.5])
    odd = replace(walk, touchdowns={**walk.touchdowns, "normal_force": force, "friction": friction})
    assert odd.ground_pulls.tolist() == [False, True, False, False, False]
    assert odd.contact_violations.tolist() == [False, True, True, False, False]
    summary = measures.summary(odd)
    assert (summary["steps_that_pull"], summary["steps_violating_contact"]) == (1, 2)
    assert summary["largest_stance_friction"] == math.inf
    assert "unbounded" in told_by(odd).values()
    assert odd.verdict == summary["verdict"] == "finished, contact violated"
    assert walk.verdict == measures.summary(walk)["verdict"] == walk.outcome == "finished"
    assert replace(odd, outcome="fell").verdict == "fell"
    unknown = replace(walk, touchdowns={**walk.touchdowns, "normal_force": np.full(5, math.nan)})
    assert measures.summary(unknown)["steps_that_pull"] is None


@pytest.mark.parametrize("parts", [[1] * 500, [200, 0, 300]])
def test_a_summary_in_parts_is_the_same_to_the_last_bit(walk: mjbiped.Walk, parts: list[int]) -> None:
    rows = {name: np.concatenate([column] * 100) for name, column in walk.touchdowns.items()}
    gathered, whole = (measures.Summary(walk.robot, walk.terrain) for _ in range(2))
    first = 0
    for count in parts:
        gathered.take({name: column[first : first + count] for name, column in rows.items()})
        first += count
        assert gathered.steps == first
    whole.take(rows)
    assert gathered.to_dict(walk) == whole.to_dict(walk)


def test_what_does_not_exist_is_none() -> None:
    fallen = mjbiped.walk(PassiveController(), mjbiped.Terrain.level(), initial=(-0.3, 0.3, 0.0, 0.0))
    summary = fallen.summary()
    assert json.loads(json.dumps(summary)) == summary
    assert summary.items() >= measures.summary(fallen).items()
    assert "in step 1 with the hip" in summary["probable_cause"]
    assert (summary["cost_of_transport"], summary["final_estimate_error_deg"], summary["steps"]) == (None, None, 0)
    rows = {label: (value, unit) for label, value, unit in summary.rows}
    assert rows["final estimate error"] == ("-", "")
    assert Recorder(robot=mjbiped.Compass).end == (0.0, 0.0)
    assert rows["peak torque, ankle"] == ("0.00", "N m")


def told_by(walk: mjbiped.Walk) -> dict[str, str]:
    """What the walk's table says, by label."""
    return {label: value for label, value, _ in walk.summary().rows}


@pytest.mark.parametrize(("engine", "slip"), [("mujoco", 8.6), ("hybrid", 0.0)])
def test_a_fall_is_explained_and_its_last_step_measured(engine: str, slip: float) -> None:
    """Slips of finished steps are below 1 um; in the last one MuJoCo's foot slides as it warns, the other's cannot."""
    ground = mjbiped.Terrain.incline(5.0)
    walk = mjbiped.walk(PassiveController(), ground, engine=engine)
    told, step = told_by(walk), walk.steps + 1
    gap = walk.end[1] - walk.touchdowns["x"][-1]
    swing_foot = walk.robot.outline(walk.samples["qpos"][-1:])[0, 1 - walk.samples["stance"][-1], -1]
    behind, depth = walk.samples["qpos"][-1, 0] - swing_foot[0], ground.height_at(swing_foot[0]) - swing_foot[1]
    assert behind > 0.0
    fell = f"fell in step {step} with the hip {gap:.2f} m ahead"
    for words in (fell, f"{behind:.2f} m behind", f"{depth:.2f} m under"):
        assert words in told["probable cause"]
    assert told["probable cause"].endswith("a small disturbance grows 2.94 times in each step")
    felt = walk.settings["unfinished_step"]
    assert 1e3 * felt["slip"] == pytest.approx(slip, abs=0.1)
    assert felt["normal_force"] <= 0.0
    assert f"slip {1e3 * felt['slip']:.4f} mm" in told["last step, unfinished"]
    bare = mjbiped.walk(PassiveController(), ground, engine=engine, sample_period=None)
    assert f"{fell} of the stance foot;" in told_by(bare)["probable cause"]


def test_where_no_motor_acts_the_lack_of_a_gait_is_told() -> None:
    stuck = mjbiped.walk(PassiveController(), mjbiped.Terrain.level(), engine="hybrid", initial=(-0.3, 0.3, 0.0, 0.0))
    told = told_by(stuck)["probable cause"]
    assert told.startswith(f"{stuck.outcome} in step 1 with the hip")
    assert "no passive gait is found on a slope of 0°" in told


def test_the_cause_of_a_fall_for_a_wrong_slope_estimate_is_told() -> None:
    law = make_controller("passivity", mjbiped.Compass(), {})
    walk = mjbiped.walk(law, mjbiped.Terrain.incline(2.0), engine="hybrid", steps=5)
    assert "give --initial-slope-estimate-deg 2, " in " ".join(str(walk.summary()).split())
    steep = mjbiped.walk(law, mjbiped.Terrain.incline(5.0), engine="hybrid", steps=5)
    assert "passive gait" not in told_by(steep)["probable cause"]
    law = make_controller("passivity", mjbiped.Compass(), {"initial_slope_estimate_deg": 2.0})
    assert "cause" not in str(mjbiped.walk(law, walk.terrain, engine="hybrid", steps=5).summary())


def test_a_notebook_shows_measures_and_the_time_lapse(controller: AdaptiveController) -> None:
    terrain = mjbiped.Terrain.from_segments([(2.0, 0.0, 0.0)], name="<script>alert(1)</script>")
    walk = mjbiped.walk(controller, terrain, engine="hybrid", steps=1)
    page = walk._repr_html_()
    assert "cost of transport, absolute" in page
    assert "<script>" not in page  # texts of a record are not taken for HTML
    with Image.open(io.BytesIO(base64.b64decode(page.split("base64,")[1].split('"')[0]))) as image:
        assert image.size[0] == 768  # 9.6 inches at 80 dots
    bare = replace(walk, samples={name: column[:0] for name, column in walk.samples.items()})
    assert "<img" not in bare._repr_html_()  # without samples there is no picture, and no error
