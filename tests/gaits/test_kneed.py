"""Passive gaits with knees: published numbers, joints of a step, ends of branches, and trajectories."""

import math
from typing import Any

import golden_numbers
import numpy as np
import pytest

from mjbiped import GaitError, KneedBiped, KneedGait, RoundKneed, find_kneed_gait
from mjbiped.gaits.cycle import free_motion
from mjbiped.gaits.reference import RATE
from mjbiped.robots.chain import Array

MCGEERS = 0.0456
PLAIN = KneedBiped()


@pytest.fixture(scope="module")
def gait() -> KneedGait:
    return find_kneed_gait(PLAIN, math.radians(2.5))


@pytest.fixture(scope="module")
def machine() -> KneedGait:
    return find_kneed_gait(RoundKneed(), MCGEERS)


def parts(gait: KneedGait, count: int) -> list[tuple[Array, Array, Array]]:
    """Angles, rates and accelerations of the free knee until it strikes, then of two straight legs."""
    ends = ((0.0, gait.knee_strike), (gait.knee_strike, gait.period))
    return [gait.branch(np.linspace(*each, count), bent=bent) for each, bent in zip(ends, (True, False), strict=True)]


# ---- gaits -----------------------------------------------------------------------------------------------------------


def test_the_gait_of_light_shanks(gait: KneedGait) -> None:
    """Design, section 6, and its prototype; half a unit of the last digit given."""
    found = [*gait.start, gait.period, gait.knee_strike]
    expected = [-0.24448, 0.24448, 0.24448, 1.08907, 0.35378, 0.35378, 0.61465, 0.52706]
    np.testing.assert_allclose(found, expected, rtol=0, atol=5e-6)
    assert abs(gait.multipliers[0]) == pytest.approx(0.71, abs=5e-3)
    assert gait.clearance == pytest.approx(0.026, abs=5e-4)
    assert gait.step_length == pytest.approx(2 * math.sin(0.24448), abs=2e-5)
    assert gait.stable
    golden_numbers.check("gait with knees")


def test_the_halved_rods_walk_too() -> None:
    """On steeper slopes, where a prototype had found none: stable, and clear of the ground by 8 mm."""
    assert find_kneed_gait(KneedBiped.halved_rods(), math.radians(5.5)).stable
    golden_numbers.check("gait of rods with knees")


@pytest.mark.slow
def test_the_gait_of_mcgeers_machine(machine: KneedGait) -> None:
    """The numbers that he gives to two or three digits, from the nonlinear model; half a unit of our last digit."""
    pair, _, real = machine.multipliers
    found = [abs(pair), abs(np.angle(pair)), real, machine.period / math.sqrt(1.0 / 9.81), machine.clearance]
    np.testing.assert_allclose(found, [0.4606, 0.9443, 0.0670, 2.6550, 0.0088], rtol=0, atol=5e-5)
    assert machine.stable
    assert machine.start[0] == pytest.approx(-0.35011, abs=5e-6)
    assert machine.start[5] > machine.start[4]  # the heel strike bends the departing knee


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "walks", "none", "clearance"),
    [
        (PLAIN, 1.96, 1.92, 0.02),
        (KneedBiped.halved_rods(), 4.51, 4.46, 0.02),
        (PLAIN, 6.84, 6.88, 0.02),
        (RoundKneed(), 0.62, 0.0, 5e-4),
    ],
)
def test_gaits_end_where_two_meet_or_the_foot_touches(robot: Any, walks: float, none: float, clearance: float) -> None:
    """Downwards no gait is left; upwards the foot comes down to the ground."""
    assert find_kneed_gait(robot, math.radians(walks)).clearance < clearance
    with pytest.raises(GaitError):
        find_kneed_gait(robot, math.radians(none))


# ---- trajectories ----------------------------------------------------------------------------------------------------


def test_branches_move_by_the_robots_equations_about_the_strike(gait: KneedGait) -> None:
    """The free knee's for a while beyond it; then the knee closes on at the rate that it has in the end.

    The straight legs' from half of the time before it; until then they turn evenly.
    """
    width = 1.0 / gait.tables[0][RATE]
    until = math.ceil(min(gait.knee_strike + 0.15 * gait.period, gait.period) / width - 1e-9) * width
    since = math.floor(0.5 * gait.knee_strike / width) * width
    for n, first, last in ((3, 0.0, until - 1e-9), (2, since + 1e-9, gait.period - 1e-9)):
        law = free_motion(gait.robot.chains[n], gait.slope, 1.0)
        for q, dq, ddq in zip(*gait.branch(np.linspace(first, last, 50), bent=n == 3), strict=True):
            # the pieces' own errors, with two derivatives of degree 9
            assert law(0.0, np.concatenate([q, dq]))[n:] == pytest.approx(ddq, abs=1e-3)
    _, dq, _ = gait.branch(np.linspace(until + width + 1e-9, gait.horizon - 1e-9, 50), bent=True)
    closing = dq[:, 2] - dq[:, 1]
    assert closing.max() < -1.0
    assert np.ptp(closing) < 1e-9
    _, dq, _ = gait.branch(np.linspace(0.0, since - 1e-9, 20), bent=False)
    assert np.ptp(dq, axis=0).max() < 1e-9
