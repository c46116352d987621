"""The compass biped on round feet: what it is made of, what it refuses, and its walks in both engines."""

import math

import numpy as np
import pytest

import mjbiped
from mjbiped.controllers import AdaptiveController, PassiveController
from mjbiped.errors import InputError
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.round import RoundCompass

SLOPE = math.radians(1.6)


def test_a_description_is_read_back() -> None:
    robot = RoundCompass(hip_mass=2.0, foot_radius=0.3)
    assert robot_from(robot.to_dict()) == robot
    assert robot.leg_inertia == pytest.approx(5.0 / 12)


def test_no_foot_is_as_large_as_the_leg() -> None:
    with pytest.raises(InputError, match=r"foot_radius = 1: must be less than the leg's length, 1 m"):
        RoundCompass(foot_radius=1.0)


def test_it_has_no_model_for_compiled_laws() -> None:
    with pytest.raises(InputError, match="a RoundCompass rolls"):
        _ = RoundCompass().model


def test_it_walks_on_planes_alone() -> None:
    for ground in (mjbiped.Terrain.stairs(tread=1.0, rise=0.01), mjbiped.Terrain.slopes(length=1.5, change_deg=0.3)):
        with pytest.raises(InputError, match="a RoundCompass walks on planes"):
            mjbiped.walk(PassiveController(), ground, robot=RoundCompass(), steps=1)


def test_on_feet_that_are_too_large_the_robot_stands() -> None:
    """The stance leg topples as long as the mass on it is higher than the arc's centre: m (a - R) + m (l - R) > 0."""
    assert mjbiped.find_passive_gait(RoundCompass(foot_radius=0.7), 0.1 * SLOPE).period > 0.0
    with pytest.raises(mjbiped.GaitError, match="on feet as large as these the robot stands"):
        mjbiped.find_passive_gait(RoundCompass(foot_radius=0.75), SLOPE)


def test_no_law_imitates_its_gait() -> None:
    gait = mjbiped.find_passive_gait(RoundCompass(), SLOPE)
    with pytest.raises(InputError, match="got Compass and PassiveGait of a RoundCompass"):
        AdaptiveController(mjbiped.Compass(), gait)


def test_the_hybrid_engine_repeats_the_passive_gait() -> None:
    """Its multipliers are below 0.45, so that errors of the steps do not add up."""
    robot = RoundCompass()
    gait = mjbiped.find_passive_gait(robot, SLOPE)
    ground = mjbiped.Terrain.incline(math.degrees(SLOPE))
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine="hybrid", steps=3)
    touchdowns = walk.touchdowns
    np.testing.assert_allclose(touchdowns["q"], np.tile(gait.start[:2], (3, 1)), atol=1e-8)
    np.testing.assert_allclose(touchdowns["dq"], np.tile(gait.start[2:], (3, 1)), atol=1e-7)
    along = np.hypot(np.diff(touchdowns["x"]), np.diff(touchdowns["z"]))
    np.testing.assert_allclose(along, gait.step_length, rtol=1e-8)
    assert touchdowns["z"] == pytest.approx(-np.tan(SLOPE) * touchdowns["x"], abs=1e-9)


def test_mujoco_rolls_as_the_hybrid_engine_does() -> None:
    """Nothing of the impact map or of rolling is in MuJoCo but a sphere and friction.

    After one step the angles differ by 1e-5 rad and the rates by 3e-5 rad/s at 0.1 ms and at 1 ms alike: what is left
    is the time of the contact, in which the leg is free, not the step's length.
    """
    ground, walks = mjbiped.Terrain.incline(math.degrees(SLOPE)), []
    for engine in (mjbiped.Hybrid(), mjbiped.Mujoco()):
        walk = mjbiped.walk(PassiveController(), ground, robot=RoundCompass(), engine=engine, steps=2)
        assert walk.outcome == "finished"
        walks.append(walk.touchdowns)
    hybrid, rolled = walks
    np.testing.assert_allclose(rolled["q"], hybrid["q"], atol=1e-4)
    np.testing.assert_allclose(rolled["dq"], hybrid["dq"], atol=1e-3)
    np.testing.assert_allclose(rolled["x"], hybrid["x"], atol=1e-4)
    assert rolled["slip"].max() < 1e-6


def test_arcs_touch_the_ground_where_they_stand() -> None:
    """The lowest point of the drawn arc of an upright leg is the leg's end, and the arc is no longer than twice ARC."""
    robot = RoundCompass(foot_radius=0.3)
    lines = robot.outline([0.0, 1.0, 0.0, 0.4])
    assert lines.shape == (2, 18, 2)
    np.testing.assert_allclose(lines[0, 1], [0.0, 0.0], atol=1e-15)
    assert lines[0, :, 1].min() == pytest.approx(0.0, abs=1e-15)
    centres = robot.limbs([0.0, 1.0, 0.0, 0.4])[:, 0] - 0.7 * np.array([[0.0, 1.0], [math.sin(0.4), math.cos(0.4)]])
    np.testing.assert_allclose(np.linalg.norm(lines[:, 2:] - centres[:, None], axis=-1), 0.3, rtol=1e-12)
    np.testing.assert_array_equal(mjbiped.Compass().outline([0.0, 1.0, 0.0, 0.4]), robot.limbs([0.0, 1.0, 0.0, 0.4]))


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_hip_over_large_feet_has_not_fallen(engine: str) -> None:
    """It is 0.5 leg lengths above the arcs' centres, and those are 0.5 above the ground."""
    robot = RoundCompass(foot_radius=0.5)
    gait = mjbiped.find_passive_gait(robot, SLOPE)
    ground = mjbiped.Terrain.incline(math.degrees(SLOPE))
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine=engine, steps=2, initial=gait.start)
    assert (walk.outcome, walk.steps) == ("finished", 2)
