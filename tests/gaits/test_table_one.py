"""The gait of Table I's robot on 2 degrees, to the digits of two programs written before this one, independently."""

import math

import numpy as np
import pytest

from mjbiped.gaits.passive import PassiveGait, find_passive_gait
from mjbiped.limit_cycles.bifurcation import find_cascade
from mjbiped.robots.compass import Compass


def test_gait_on_two_degrees(robot: Compass, gait: PassiveGait) -> None:
    """States, period, step length, speed, multipliers, energies."""
    np.testing.assert_allclose(gait.start, [-0.19008478, 0.19008478, 1.10317583, 0.81185710], rtol=0, atol=5e-9)
    np.testing.assert_allclose(gait.end, [0.19008478, -0.19008478, 1.44951875, 1.51242286], rtol=0, atol=5e-9)
    assert gait.period == pytest.approx(0.76484357, abs=5e-9)
    assert gait.step_length == pytest.approx(0.377884, abs=5e-7)
    assert gait.speed == pytest.approx(0.494067, abs=5e-7)
    expected = [-0.43032 - 0.31560j, -0.43032 + 0.31560j, 0.27555]
    np.testing.assert_allclose(np.sort_complex(gait.multipliers), expected, rtol=0, atol=5e-6 * math.sqrt(2))
    assert gait.energy == pytest.approx(51.31078, abs=5e-6)
    assert robot.energy(gait.end[:2], gait.end[2:], gait.slope) == pytest.approx(51.31078, abs=5e-6)
    assert robot.kinetic_energy(gait.end[:2], gait.end[2:]) == pytest.approx(3.820468, abs=5e-7)
    assert robot.kinetic_energy(gait.start[:2], gait.start[2:]) == pytest.approx(2.526728, abs=5e-7)


def test_impact_from_published_digits(robot: Compass) -> None:
    """The impact map takes the state before the impact to the one after."""
    q, dq = robot.impact([0.19008478, -0.19008478], [1.44951875, 1.51242286])
    # eight digits in, and the impact matrix's entries are below 5
    np.testing.assert_allclose([*q, *dq], [-0.19008478, 0.19008478, 1.10317583, 0.81185710], rtol=0, atol=5e-8)


def test_clearance(robot: Compass, gait: PassiveGait) -> None:
    """The swing foot clears the ground ahead of the stance foot by at most 0.0462 m, at 79 %."""
    times = np.linspace(0, gait.period, 2001)
    foot = np.array([robot.swing_foot(q) for q in gait.reference(times)[0]])
    clearance = np.where(foot[:, 0] > 0, foot[:, 1], -1)
    assert clearance.max() == pytest.approx(0.0462, abs=5e-5)
    assert times[clearance.argmax()] / gait.period == pytest.approx(0.79, abs=5e-3)


@pytest.mark.slow
def test_period_doubling() -> None:
    """The paper: stable gaits of period one for slopes in (0, 2.72) degrees. Computed: up to 2.72844.

    2.72 agrees if its digits are cut off, not if they are rounded.
    """
    onset = math.degrees(find_cascade(Compass(), 1).onsets[0])
    assert onset == pytest.approx(2.72844, abs=5e-6)
    assert math.floor(100 * onset) / 100 == 2.72
    assert not find_passive_gait(Compass(), math.radians(2.73)).stable
    assert all(find_passive_gait(Compass(), math.radians(degrees)).stable for degrees in (0.1, 1.0, 2.72))
