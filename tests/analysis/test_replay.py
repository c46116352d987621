"""Replays of records: the references made again are those that the controller tracked while it walked."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import mjbiped
from controllers import AdaptiveController, KneedController
from mjbiped.analysis.replay import TrackedReference, recorded_controller, replayed, transitions
from mjbiped.control.registry import make_controller
from mjbiped.control.tracking import Tracking

BEFORE_A_STEP = mjbiped.Terrain.from_segments([(0.6, 0.0, 0.0), (20.0, 0.0, 0.03)])
GROUND = mjbiped.Terrain.from_segments([(0.6, 0.0, 0.0), (3.0, 2.0, -0.02)])
NOISY = mjbiped.Disturbances(
    angle_noise=5e-3, rate_noise=0.05, angle_bias=2e-3, angle_resolution=1e-3, delay=2e-3, seed=4
)


@pytest.fixture(scope="module")
def kneed() -> KneedController:
    robot = mjbiped.KneedBiped()
    return KneedController(robot, mjbiped.find_kneed_gait(robot, math.radians(2.5)))


def remembering(law: Any) -> tuple[Any, list[list[float]]]:
    """The law in Python, and what it keeps: its plans at the start and at each touchdown."""
    planned: list[list[float]] = []

    class Remembering(type(law)):  # type: ignore[misc]
        def start(self, memory: Any, *state: Any) -> None:
            super().start(memory, *state)
            planned.append([*memory][2:])

        def on_touchdown(self, memory: Any, *state: Any) -> None:
            super().on_touchdown(memory, *state)
            planned.append([*memory][2:])

        def law(self) -> None:  # what is compiled could not keep anything
            return None

    return Remembering(law.robot, law.gait), planned


@pytest.mark.slow
@pytest.mark.parametrize("disturbances", [None, NOISY], ids=["undisturbed", "noisy"])
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.parametrize("knees", [False, True])
def test_plans_made_again(
    controller: AdaptiveController, kneed: KneedController, knees: bool, engine: str, disturbances: Any
) -> None:
    """Bit by bit: the record holds the states that the controller was given, and of what its sensors made noise.

    Some knees strike before the touchdown, and others come down bent, which plans and estimates depend on.
    """
    tracking: Any = kneed if knees else controller
    law, planned = remembering(tracking)
    more: Any = {"steps": 3} if knees else {"steps": 4, "initial": "rest"}
    walk = mjbiped.walk(law, BEFORE_A_STEP if knees else GROUND, engine=engine, disturbances=disturbances, **more)
    again = [list(memory[2 : law.memory_size]) for _, memory in replayed(walk, tracking)]
    tried = planned.index(again[0], 1)  # before the walk the law is tried
    assert len(again) == walk.steps + 1
    assert again == planned[tried:][: walk.steps + 1]
    assert not knees or np.isfinite(walk.touchdowns["knee_strike"]).tolist() == [True, False, False]


@pytest.mark.parametrize("knees", [False, True])
def test_the_robot_follows_its_transitions_until_its_knee_strikes(
    knees: bool, controller: AdaptiveController, kneed: KneedController
) -> None:
    """The motion, which the engine integrates, is the replayed reference where model and slope are known."""
    made: Any = kneed if knees else controller
    ground, initial = (mjbiped.Terrain.stairs(rise=0.02), "gait") if knees else (GROUND, "rest")
    walk = mjbiped.walk(made, ground, engine="hybrid", steps=5, initial=initial, sample_period=1e-3)
    law = recorded_controller(walk, kind=Tracking)
    assert law == made
    found, samples, n = transitions(walk, law), walk.samples, len(law.robot.angles)
    ends = [0.0, *walk.touchdowns["time"]]
    starts = np.vstack([walk.settings["initial"], np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])])
    off = np.abs(starts - made.gait.start).max(axis=1) > made.replanning_threshold
    assert knees or len(found) == off[:-1].sum()  # the walk ends with the touchdown of a step that was not walked
    assert 1 <= len(found) < 5
    strikes, period = walk.touchdowns.get("knee_strike", np.full(5, math.inf)), 0.8 * made.gait.period
    for curve in found:
        (step,) = np.flatnonzero(np.abs(starts - curve[0]).max(axis=1) < 1e-9)
        duration = min(period, ends[step + 1] - ends[step], strikes[step])
        inside = (samples["time"] > ends[step] + 1e-9) & (samples["time"] < ends[step] + duration)
        times = np.linspace(0.0, duration, len(curve)) + ends[step]
        drawn = CubicHermiteSpline(times, curve[:, :n], curve[:, n:])(samples["time"][inside])
        # between 60 points, h^4/384 of a fourth derivative of some 1e4 rad/s^4
        np.testing.assert_allclose(samples["q"][inside], drawn, rtol=0, atol=1e-6)
        if not knees:
            np.testing.assert_allclose(curve[-1], np.concatenate(made.gait.reference(period)[:2]), rtol=0, atol=1e-12)


def test_the_reference_at_any_time_is_the_motion(controller: AdaptiveController) -> None:
    walk = mjbiped.walk(controller, GROUND, engine="hybrid", steps=5, initial="rest")
    reference, time = TrackedReference(walk, controller), walk.samples["time"]
    # a sample at a touchdown is the reference's of the step after it
    away = (np.abs(time[:, None] - walk.touchdowns["time"]) > 1e-9).all(axis=1)
    tracked = np.array([reference.at(t) for t in time[away].tolist()])
    np.testing.assert_allclose(tracked, walk.samples["q"][away], rtol=0, atol=1e-6)


def test_nothing_is_re_planned_where_that_is_off_or_there_is_no_need(controller: AdaptiveController) -> None:
    without = replace(controller, replanning_delay=None)
    for law, ground, initial in ((without, GROUND, "rest"), (controller, mjbiped.Terrain.level(), "gait")):
        assert transitions(mjbiped.walk(law, ground, engine="hybrid", steps=3, initial=initial), law) == []


def test_a_law_on_feet_is_told_of_its_support() -> None:
    robot = mjbiped.FootedCompass()
    law = make_controller("bounded-ankle", robot, {})
    walk = mjbiped.walk(law, mjbiped.Terrain.mixed(), engine="hybrid", steps=2, robot=robot)
    told = [memory[law.support : law.support + 2] for _, memory in replayed(walk, law)]
    assert told[1:] == np.column_stack([walk.touchdowns[f"support_{end}"] for end in ("behind", "ahead")]).tolist()
