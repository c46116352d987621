"""What is measured of whole records: on records whose numbers are put in by hand, and on walks whose truth is known."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.errors import InputError
from mjbiped.studies.reproduction.cell import RESOLVED_SLOPE, TRACES, traced

GROUND = mjbiped.Terrain.from_segments([(1.0, 0.0, 0.0), (3.0, 2.0, -0.02)])


def walked(controller: AdaptiveController, **others: object) -> mjbiped.Walk:
    given: dict[str, object] = {"engine": "hybrid", "steps": 7, "initial": "rest", **others}
    return mjbiped.walk(controller, GROUND, **given)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    return walked(controller)


def test_known_model_and_slope_leave_no_error(walk: mjbiped.Walk) -> None:
    found = traced(walk)
    # the integration's tolerance, 1e-8, over some steps, in degrees
    for name in ("settled", "later", "error", "z1", "z2"):
        assert found[f"trace_{name}"] < 1e-5, name
    assert found["trace_travel"] < 1e-6 * len(walk.samples["time"])  # a sum over all samples
    assert found["trace_off_time"] == 0.0
    assert 0.0 < found["trace_straight"] < 0.2 < found["trace_bent"]  # N m


def with_error(walk: mjbiped.Walk, error: np.ndarray) -> mjbiped.Walk:
    """The record with another slope estimate, wrong by so many degrees."""
    samples = {**walk.samples, "slope_estimate": walk.samples["slope"] + np.radians(error)}
    return dataclasses.replace(walk, samples=samples)


def test_errors_of_the_estimate_by_hand(walk: mjbiped.Walk) -> None:
    """1° until a time, then -0.05°, which is below epsilon, and once 0.5° in between."""
    time = walk.samples["time"]
    on_other_ground = walk.touchdowns["time"][walk.touchdowns["x"] > 1.0][0]
    early = time < 1.0
    error = np.where(early, 1.0, -0.05)
    late = int(np.searchsorted(time, on_other_ground + 0.2))
    error[late] = 0.5
    found = traced(with_error(walk, error))
    wrong = np.diff(time)[: early.sum()].sum() + time[late + 1] - time[late]
    assert math.radians(0.05) < RESOLVED_SLOPE < math.radians(0.5)
    assert found["trace_off_time"] == pytest.approx(wrong, rel=1e-12)
    assert found["trace_settled"] == pytest.approx(0.05, rel=1e-9)
    assert found["trace_later"] == pytest.approx(0.5, rel=1e-9)
    assert found["trace_travel"] == pytest.approx(1.05 + 2 * 0.55, rel=1e-9)
    square = np.diff(time) @ error[:-1] ** 2 / (time[-1] - time[0])
    assert found["trace_error"] == pytest.approx(math.sqrt(square), rel=1e-9)


def test_straight_lines_and_bent_ones_by_hand(walk: mjbiped.Walk) -> None:
    """Torques that are linear in time have no distance from a line; one sample by d aside has nearly d."""
    samples = dict(walk.samples)
    samples["torque"] = np.outer(samples["time"], [3.0, -2.0]) + 1.0
    plain = traced(dataclasses.replace(walk, samples=samples))
    assert plain["trace_straight"] < 1e-10  # rounding of numbers of order 10
    assert plain["trace_bent"] < 1e-10
    begun = walk.touchdowns["time"]
    second = int(np.searchsorted(samples["time"], 0.5 * (begun[0] + begun[1])))  # of a step on the gait
    samples["torque"] = samples["torque"].copy()
    samples["torque"][second, 1] += 0.3
    moved = traced(dataclasses.replace(walk, samples=samples))
    assert 0.28 < moved["trace_straight"] < 0.3
    assert moved["trace_bent"] < 1e-10


def test_tracking_errors_are_those_at_the_touchdowns(controller: AdaptiveController) -> None:
    """Without re-planning a step begins as far off the gait as the touchdown left it."""
    walk = walked(dataclasses.replace(controller, replanning_delay=None))
    found = traced(walk)
    start = controller.gait.start
    z1 = start[:2] - walk.touchdowns["q"][:-1]
    z2 = start[2:] - walk.touchdowns["dq"][:-1] + controller.position_gain * z1
    first = np.abs(start[:2])  # from rest, both legs upright
    assert (
        found["trace_z1"] >= math.degrees(max(np.abs(z1).max(), first.max())) * 0.95
    )  # the first sample is up to 5 ms later
    assert found["trace_z2"] >= np.abs(z2).max() * 0.9
    assert not {"trace_straight", "trace_bent"} & set(found)  # which steps follow the gait, no plan says


def test_what_is_not_there_is_left_out(walk: mjbiped.Walk) -> None:
    none = {name: column[:0] for name, column in walk.touchdowns.items()}
    assert traced(dataclasses.replace(walk, touchdowns=none)) == {}
    level = {**walk.settings, "terrain": mjbiped.Terrain.level().to_dict()}
    assert "trace_later" not in traced(dataclasses.replace(walk, settings=level))
    assert set(traced(walk)) == set(TRACES)
    passive = mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(2.0), engine="hybrid", steps=1)
    with pytest.raises(InputError, match="PassiveController"):
        traced(passive)
