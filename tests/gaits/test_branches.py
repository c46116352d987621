"""Trajectories of a passive gait with knees: they join smoothly, and follow the robot's equations where they should."""

import math

import numpy as np
import pytest

from mjbiped.gaits.cycle import free_motion
from mjbiped.gaits.kneed import KneedGait, find_kneed_gait
from mjbiped.gaits.reference import RATE
from mjbiped.robots.kneed import KneedBiped


@pytest.fixture(scope="module")
def gait() -> KneedGait:
    return find_kneed_gait(KneedBiped(), math.radians(2.5))


def test_pieces_join_up_to_the_acceleration(gait: KneedGait) -> None:
    """Those of the bent knee all; those of the straight knee from where its motion is no longer followed back."""
    rate = gait.tables[0][RATE]
    followed = math.floor(0.5 * gait.knee_strike * rate)
    joints = np.arange(1, round(gait.horizon * rate)) / rate
    for bent in (True, False):
        before, after = (gait.branch(joints * (1.0 + side * 1e-12), bent=bent) for side in (-1, 1))
        for order, tolerance in enumerate((1e-9, 1e-8, 2e-5)):  # of degree 9, times 9 and 8, and 20 pieces a second
            jumps = np.abs(after[order] - before[order]).max(axis=1)
            if order == 2 and not bent:
                jumps = np.delete(jumps, followed - 1)
            assert jumps.max() < tolerance


def test_the_bent_knee_moves_freely_for_a_while_and_is_then_driven_on(gait: KneedGait) -> None:
    """Where it no longer moves by the robot's equations, it closes on at the rate that it has in the end."""
    free, width = free_motion(gait.robot.chains[3], gait.slope, 1.0), 1.0 / gait.tables[0][RATE]
    until = math.ceil(min(gait.knee_strike + 0.15 * gait.period, gait.period) / width - 1e-9) * width
    within = np.linspace(0.0, until - 1e-9, 50)
    for q, dq, ddq in zip(*gait.branch(within, bent=True), strict=True):
        # the pieces' own errors, with two derivatives of degree 9
        assert free(0.0, np.concatenate([q, dq]))[3:] == pytest.approx(ddq, abs=1e-3)
    _, dq, ddq = gait.branch(np.linspace(until + width + 1e-9, gait.horizon - 1e-9, 50), bent=True)
    closing = dq[:, 2] - dq[:, 1]
    assert closing.max() < -1.0
    assert np.ptp(closing) < 1e-9
    assert np.abs(ddq[:, 2] - ddq[:, 1]).max() < 1e-7


def test_the_straight_knees_motion_is_the_robots_about_the_strike(gait: KneedGait) -> None:
    locked, width = free_motion(gait.robot.chains[2], gait.slope, 1.0), 1.0 / gait.tables[1][RATE]
    since = math.floor(0.5 * gait.knee_strike / width) * width
    _, dq, ddq = gait.branch(np.linspace(0.0, since - 1e-9, 20), bent=False)
    assert np.ptp(dq, axis=0).max() < 1e-9  # before, evenly
    within = np.linspace(since + 1e-9, gait.period - 1e-9, 50)
    for q, dq, ddq in zip(*gait.branch(within, bent=False), strict=True):
        assert locked(0.0, np.concatenate([q, dq]))[2:] == pytest.approx(ddq, abs=1e-3)


def test_the_reference_is_the_branch_of_the_knee_at_each_time(gait: KneedGait) -> None:
    """Bent before the knee strike; after it thigh and shank of the swing leg are in line."""
    times = np.array([0.0, 0.9, 1.1]) * gait.knee_strike
    bent, straight = gait.branch(times, bent=True), gait.branch(times, bent=False)
    for found, first, second in zip(gait.reference(times), bent, straight, strict=True):
        np.testing.assert_array_equal(found[:2], first[:2])
        np.testing.assert_array_equal(found[2], [second[2, 0], second[2, 1], second[2, 1]])
