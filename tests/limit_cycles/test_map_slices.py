"""Slices through return maps, and walks near the gaits in which they meet."""

import math

import numpy as np
import pytest

import mjbiped
from mjbiped.errors import GaitError, InputError
from mjbiped.limit_cycles.map_slices import PUSH, MapSlices, map_slices
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.robots.robot import Robot

WHEEL = mjbiped.RimlessWheel()


def found(robot: Robot, degrees: float) -> MapSlices:
    return map_slices(robot, math.radians(degrees), points=41, steps=20)


@pytest.mark.parametrize(
    ("robot", "degrees"),
    [
        (mjbiped.Compass(), 2.0),
        pytest.param(mjbiped.KneedBiped(), 2.5, marks=pytest.mark.slow),
        pytest.param(WHEEL, 5.0, marks=pytest.mark.slow),
    ],
    ids=lambda each: str(each)[:8],
)
def test_slices_meet_in_the_gait_and_walks_reach_it(robot: Robot, degrees: float) -> None:
    slices = found(robot, degrees)
    middle = slices.before.shape[1] // 2
    np.testing.assert_allclose(slices.before[:, middle], slices.fixed_point, rtol=1e-15)
    np.testing.assert_allclose(slices.after[:, middle], slices.fixed_point, rtol=0, atol=1e-10)  # it repeats itself
    assert len(slices.components) == len(slices.before) == len(slices.after)
    np.testing.assert_allclose(slices.walk[0], (1.0 + PUSH) * slices.fixed_point)
    # by the greatest multiplier a step, 0.71 with knees: 0.02 * 0.71^20 = 2e-5, and some room for the first steps
    assert np.abs(slices.walk[-1] - slices.fixed_point).max() < 1e-4
    assert (slices.outcome, slices.settled) == ("walking", None)


def test_a_point_of_a_slice_is_a_step() -> None:
    slices = found(mjbiped.Compass(), 2.0)
    q1, dq1, dq2 = slices.fixed_point
    for k in (15, 25):
        step = ReturnMap(mjbiped.Compass(), math.radians(2.0)).walk([q1, -q1, slices.before[1, k], dq2], 1)
        assert step.states[0, 2] == slices.after[1, k]
    assert dq1 == slices.before[1, 20]
    assert np.isnan(slices.after[0, 0])  # 15 % longer a step does not land


@pytest.mark.slow
def test_the_wheels_map_is_its_closed_form() -> None:
    """The square of the rate after an impact is the one before it, and what falling adds, times the square kept."""
    slices = found(WHEEL, 5.0)
    hub = WHEEL.mass * WHEEL.length**2 + WHEEL.inertia
    half = WHEEL.between / 2
    gained = 2 * WHEEL.weight * WHEEL.length * 2 * math.sin(half) * math.sin(math.radians(5.0)) / hub
    expected = WHEEL.kept * np.sqrt(slices.before**2 + gained)
    rolls = ~np.isnan(slices.after)
    assert rolls.any()
    np.testing.assert_allclose(slices.after[rolls], expected[rolls], rtol=1e-9)  # the integration's tolerance


def test_beyond_a_doubling_walks_settle_on_two_steps() -> None:
    slices = found(mjbiped.Compass(), 3.0)
    assert slices.settled is not None
    assert len(slices.settled.states) == 2
    assert slices.settled.stable
    assert found(mjbiped.Compass(), 3.5).settled is None  # aperiodic


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match="points"):
        map_slices(mjbiped.Compass(), 0.03, points=0)
    with pytest.raises(InputError, match="scuffing is for straight legs"):
        map_slices(mjbiped.KneedBiped(), 0.04, scuffing=mjbiped.ScuffingRule(reach=0.3))
    with pytest.raises(GaitError, match="downhill"):
        map_slices(mjbiped.Compass(), -0.03)
