"""The section just after impacts, and what is read off it."""

import math

import numpy as np
import pytest

import mjbiped
from mjbiped.errors import InputError
from mjbiped.limit_cycles.periodic import check_biped, guard_of, places_of, step_lengths
from mjbiped.robots.robot import Robot


@pytest.mark.parametrize("robot", [mjbiped.Compass(), mjbiped.KneedBiped()])
def test_a_state_is_told_by_one_angle_and_two_rates(robot: Robot) -> None:
    places = np.random.default_rng(0).uniform(-0.5, 0.5, (5, 4, 3))
    states, n = robot.after_touchdown(places), len(robot.angles)
    assert states.shape == (5, 4, 2 * n)
    np.testing.assert_array_equal(places_of(states), places)
    # both feet stand on the plane
    np.testing.assert_allclose(robot.swing_foot(states[..., :n])[..., 1], 0.0, atol=1e-15)
    # and the swing leg is one
    assert not np.diff(states[..., 1:n]).any()
    assert not np.diff(states[..., n + 1 :]).any()


def test_step_lengths_are_distances_of_the_feet(robot: mjbiped.Compass) -> None:
    states = np.array([[-0.2, 0.2, 1.0, 0.5], [math.nan] * 4])
    assert step_lengths(robot, states) == pytest.approx([2.0 * math.sin(0.2), math.nan], rel=1e-15, nan_ok=True)


def test_straight_legs_need_a_guard() -> None:
    assert guard_of(mjbiped.Compass()).reach == 0.0
    assert guard_of(mjbiped.KneedBiped()) == mjbiped.ScuffingRule()


@pytest.mark.parametrize("robot", [mjbiped.RimlessWheel(), "compass"])
def test_what_has_no_two_legs_is_refused(robot: object) -> None:
    with pytest.raises(InputError, match=r"swing leg|robot must be"):
        check_biped(robot)
