"""The period-doubling cascade and its diagram."""

import math
from functools import cache

import numpy as np
import pytest

from mjbiped.limit_cycles.bifurcation import FEIGENBAUM, BifurcationDiagram, Cascade, bifurcation_diagram, find_cascade
from mjbiped.limit_cycles.periodic import follow
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped

TABLE_ONE = Compass()


@cache
def cascade() -> Cascade:
    return find_cascade(TABLE_ONE, 4)


@cache
def diagram() -> BifurcationDiagram:
    return bifurcation_diagram(TABLE_ONE, np.radians(np.arange(2.5, 3.7, 0.05)), steps=300, keep=64)


@pytest.mark.slow
def test_onsets() -> None:
    """The digits that this program gives for every step of its differences; the design has 2.7284, 3.296, 3.398, 3.420.

    Those of the design are places where a diagram's points part, good to its grid: they differ by 0.003 at most.
    """
    onsets = np.degrees(cascade().onsets)
    np.testing.assert_allclose(onsets, [2.728444, 3.298631, 3.397861, 3.418719], rtol=0, atol=1e-6)
    np.testing.assert_allclose(onsets, [2.7284, 3.296, 3.398, 3.420], rtol=0, atol=3e-3)
    assert onsets[0] == pytest.approx(2.7284, abs=5e-5)
    assert cascade().end == ""


def test_ratios_tend_to_feigenbaums_number() -> None:
    ratios = cascade().ratios
    assert abs(ratios[1] - FEIGENBAUM) < 0.1 * abs(ratios[0] - FEIGENBAUM)
    assert ratios[1] == pytest.approx(FEIGENBAUM, rel=0.02)
    assert math.degrees(cascade().accumulation) == pytest.approx(3.4244, abs=5e-5)


def test_branches_are_stable_up_to_their_doubling() -> None:
    for number, branch in enumerate(cascade().branches):
        assert branch.count == 2**number
        assert branch.doubling is not None
        assert branch.doubling.multipliers[0].real == pytest.approx(-1, abs=1e-6)
        assert {len(gait.states) for gait in branch.gaits} == {branch.count}
        for gait in branch.gaits:
            assert gait.stable == (gait.slope < branch.doubling.slope)
        assert branch.gaits[-1].slope > branch.doubling.slope
        if number:
            born = cascade().onsets[number - 1]
            assert branch.gaits[0].slope > born


def test_gentler_slopes_for_a_longer_robot_do_not_matter() -> None:
    """Slopes of onsets have no unit: a robot of other mass, length and gravity has the same."""
    giant = Compass(leg_mass=50.0, lower_length=2.0, upper_length=2.0, gravity=1.62)
    np.testing.assert_allclose(find_cascade(giant, 2).onsets, cascade().onsets[:2], rtol=0, atol=1e-10)


def test_diagram_agrees_with_the_cascade() -> None:
    counts, degrees = diagram().counts(), np.degrees(diagram().slopes)
    onsets = [0.0, *np.degrees(cascade().onsets)]
    for degree, count in zip(degrees, counts, strict=True):
        born = np.searchsorted(onsets, degree) - 1
        # close to an onset the robot needs more than these 300 steps to settle
        if degree < 3.41 and np.abs(np.array(onsets) - degree).min() > 0.01:
            assert count == 2**born, degree


def test_counts_are_the_least_after_which_steps_repeat_themselves() -> None:
    """Up to 32; of the last two motions one is longer, and one is known for too few steps."""
    periods = [*range(1, 33), 33, 40]
    angle = 0.2 + 0.001 * (np.arange(64) % np.array(periods)[:, None])
    states = np.stack([-angle, angle, angle, angle], axis=-1)
    slopes, outcomes = np.linspace(0.01, 0.02, len(periods)), ("walking",) * len(periods)
    counts = BifurcationDiagram(TABLE_ONE, slopes, states, angle, outcomes).counts()
    assert counts.tolist() == [*range(1, 33), 0, 0]
    assert BifurcationDiagram(TABLE_ONE, slopes, states[:, :2], angle, outcomes).counts().tolist() == [1] + [0] * 33


def test_robot_is_lost_beyond_the_aperiodic_walks() -> None:
    assert 3.54 < math.degrees(diagram().lost) < 3.61  # this grid's steps; docs/gaits.md has a finer one
    after = diagram().slopes >= diagram().lost
    assert set(np.array(diagram().outcomes)[after]) == {"fell"}
    np.testing.assert_array_equal(np.isnan(diagram().states).all(axis=(1, 2)), after)
    np.testing.assert_array_equal(np.isnan(diagram().states).any(axis=(1, 2)), after)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "begins", "onsets"),
    [(KneedBiped(), 1.940, (5.683, 6.2126, 6.3152)), (KneedBiped.halved_rods(), 4.487, (6.152, 6.5143, 6.5858))],
)
def test_period_doubles_with_knees_too(robot: KneedBiped, begins: float, onsets: tuple[float, ...]) -> None:
    """docs/knees.md has the beginnings of the branches and the first onsets, 5.68 and 6.15 degrees, from SciPy."""
    cascade = find_cascade(robot, 3)
    # the diagram's walks part there, to its grid
    np.testing.assert_allclose(np.degrees(cascade.onsets), onsets, rtol=0, atol=1e-3)
    assert cascade.ratios[0] == pytest.approx(FEIGENBAUM, rel=0.15)  # the first of the ratios
    first = cascade.branches[0]
    assert 0.0 <= math.degrees(first.gaits[0].slope) - begins < 0.05  # a step of the slope
    for one in first.gaits[:: len(first.gaits) // 4]:
        assert one.stable == (one.slope < cascade.onsets[0])
    low, high = cascade.span
    assert low < cascade.onsets[0] < cascade.onsets[-1] < high
    middle = float(0.5 * cascade.onsets[:2].sum())
    diagram = bifurcation_diagram(robot, [middle, high], steps=300, keep=20)
    assert diagram.counts().tolist() == [2, 0]
    (two,) = follow(cascade.branches[1].gaits[0], [middle])
    found = np.unique(np.round(diagram.step_lengths[0], 7))
    np.testing.assert_allclose(found, np.sort(two.step_lengths), rtol=0, atol=1e-6)
