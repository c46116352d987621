"""The pieces of a passive gait's branches: they join smoothly, and follow the robot's equations where they should."""

import math

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyder, polyval

from mjbiped.gaits.kneed import KneedGait, find_kneed_gait
from mjbiped.gaits.pieces import free_motion
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import KneedBiped


@pytest.fixture(scope="module")
def gait() -> KneedGait:
    return find_kneed_gait(KneedBiped(), math.radians(2.5))


def jumps(pieces: Array, order: int) -> Array:
    """What angles, rates or accelerations change by from each piece to the next, in units of a piece's duration."""
    derived = [polyder(piece, order, axis=0) for piece in pieces]
    ends, begins = (np.array([polyval(place, each) for each in derived]) for place in (1.0, 0.0))
    return np.asarray(np.abs(begins[1:] - ends[:-1]).max(axis=1))


def test_pieces_join_up_to_the_acceleration(gait: KneedGait) -> None:
    """Those of the bent knee all; those of the straight knee from where its motion is no longer followed back."""
    followed = math.floor(0.5 * gait.knee_strike * gait.rate)
    for order in range(3):
        # the motion is interpolated to some 1e-10, which degree 9 takes times 8 * 9; measured 1e-8
        assert jumps(gait.bent, order).max() < 5e-8
        smooth = jumps(gait.straight, order)
        assert np.delete(smooth, followed - 1).max() < 5e-8
        if order < 2:
            assert smooth[followed - 1] < 5e-8
    assert len(gait.bent) == len(gait.straight)


def test_the_bent_knee_moves_freely_for_a_while_and_is_then_driven_on(gait: KneedGait) -> None:
    """Where it no longer moves by the robot's equations, it closes on at the rate that it has in the end."""
    free, width = free_motion(gait.robot.chains[3], gait.slope), 1.0 / gait.rate
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
    locked, width = free_motion(gait.robot.chains[2], gait.slope), 1.0 / gait.rate
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
