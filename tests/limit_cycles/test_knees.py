"""Return map and basins of robots with knees against single walks."""

from __future__ import annotations

import math

import numpy as np
import pytest

import mjbiped
from controllers import KneedController, PassiveController
from mjbiped.errors import InputError
from mjbiped.limit_cycles import basin as basins
from mjbiped.limit_cycles.basin import Fate, basin_of_attraction, basin_of_control
from mjbiped.limit_cycles.bifurcation import FEIGENBAUM, bifurcation_diagram, find_cascade
from mjbiped.limit_cycles.periodic import differentiate, find_periodic_gait, first_gait, follow
from mjbiped.limit_cycles.return_map import ReturnMap, plane_of
from mjbiped.rules.scuffing import ScuffingRule

ROBOT = mjbiped.KneedBiped()
SLOPE = math.radians(2.5)
NEAR = basins.SETTLED * np.repeat([1.0, math.sqrt(9.81)], 3)
STANCE, SWING = np.linspace(1.0, 1.2, 5), np.linspace(-0.2, 0.8, 6)


@pytest.fixture(scope="module")
def gait() -> mjbiped.KneedGait:
    return mjbiped.find_kneed_gait(ROBOT, SLOPE)


@pytest.mark.slow
def test_the_map_is_the_hybrid_engines_walk(gait: mjbiped.KneedGait) -> None:
    """Off the gait, where the walk nears it by 0.71 a step; both integrate to 1e-8 and better."""
    start = gait.start + np.array([0.0, 0.0, 0.0, 0.01, -0.02, -0.02])
    steps = ReturnMap(ROBOT, SLOPE).walk(start, 12)
    ground = mjbiped.Terrain.incline(math.degrees(SLOPE))
    walk = mjbiped.walk(PassiveController(), ground, robot=ROBOT, engine="hybrid", initial=start.tolist(), steps=12)
    states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
    np.testing.assert_allclose(steps.states, states, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(np.cumsum(steps.periods), walk.touchdowns["time"], rtol=0.0, atol=1e-7)


@pytest.mark.slow
def test_the_gaits_multipliers_are_the_maps(gait: mjbiped.KneedGait) -> None:
    """A pair a ± bi: each deviation is 2 a times the one before it, less a² + b² times the one before that."""
    start = gait.start + 1e-4 * np.array([0.0, 0.0, 0.0, 1.0, 0.5, 0.5])
    away = ReturnMap(ROBOT, SLOPE).walk(start, 8).states - gait.start
    pair = gait.multipliers[np.argmax(np.abs(gait.multipliers))]
    left = away[7] - 2.0 * pair.real * away[6] + abs(pair) ** 2 * away[5]
    # the third multiplier is 0.12: after five steps nothing is left of it; the rest is of the deviation's square
    assert np.abs(left).max() < 1e-3 * np.abs(away[5:]).max()


@pytest.mark.slow
def test_each_start_of_a_passive_basin_is_a_walk(gait: mjbiped.KneedGait) -> None:
    found = basin_of_attraction(ROBOT, SLOPE, stance_rates=STANCE, swing_rates=SWING, threads=2)
    for row, column in np.ndindex(found.fates.shape):
        fate, count = Fate(int(found.fates[row, column])), int(found.steps[row, column])
        start = [*gait.start[:3], STANCE[column], SWING[row], SWING[row]]
        walked = ReturnMap(ROBOT, SLOPE).walk(start, 100)
        inside = (np.abs(np.vstack([start, walked.states]) - gait.start) < NEAR).all(axis=1)
        if inside.any():
            assert (fate, count) == (Fate.SETTLED, int(inside.argmax()))
        else:
            assert (fate.name.lower(), count) == (walked.outcome, len(walked.states))
    assert found.share(Fate.SETTLED) > 0.1
    assert found.share(Fate.FELL) > 0.1
    alone = basin_of_attraction(ROBOT, SLOPE, stance_rates=STANCE, swing_rates=SWING, threads=1)
    assert alone.fates.tobytes() == found.fates.tobytes()
    assert alone.steps.tobytes() == found.steps.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("rates", [(1.1, 0.8), (2.5, -2.0), (12.0, -6.0)])
def test_a_controlled_start_is_a_walk(rates: tuple[float, float], gait: mjbiped.KneedGait) -> None:
    controller = KneedController(ROBOT, gait)
    found = basin_of_control(controller, stance_rates=rates[:1], swing_rates=rates[1:], limit=6)
    start = (*gait.start[:3], *rates, rates[1])
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", initial=start, steps=6)
    states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
    inside = (np.abs(states - gait.start) < NEAR).all(axis=1)
    fate, steps = Fate(found.fates[0, 0]), found.steps[0, 0]
    if inside.any():
        assert (fate, steps) == (Fate.SETTLED, 1 + inside.argmax())
    else:
        assert (fate.name.lower(), steps) == (walk.outcome, walk.steps)
    assert found.peak_torque[0, 0] == pytest.approx(walk.peak_torque.max(), rel=1e-6)
    assert (fate is Fate.SETTLED) == (rates[0] < 10.0)


@pytest.mark.slow
@pytest.mark.parametrize("sole", [None, (0.1, 0.1)])
def test_period_one_is_the_gait_of_scipy(sole: tuple[float, float] | None, gait: mjbiped.KneedGait) -> None:
    """Two programs: SciPy's integrator and root finder, and the compiled return map with Newton's method."""
    found = first_gait(mjbiped.KneedBiped(sole=sole), SLOPE)
    np.testing.assert_allclose(found.states[0], gait.start, rtol=0, atol=1e-10)  # SciPy's tolerance is 1e-11
    assert found.periods[0] == pytest.approx(gait.period, abs=1e-10)
    assert found.step_lengths[0] == pytest.approx(gait.step_length, abs=1e-10)
    # both by central differences, and their noise: five digits are promised there
    np.testing.assert_allclose(np.sort_complex(found.multipliers), np.sort_complex(gait.multipliers), rtol=0, atol=1e-6)
    assert found.stable


@pytest.mark.slow
def test_a_landing_on_a_bent_knee_is_off_the_section(gait: mjbiped.KneedGait) -> None:
    """Where the swing leg rests at first, the foot comes down before the knee is straight."""
    places = np.array([[-0.2, gait.start[3], 0.0]])
    bent = ReturnMap(ROBOT, SLOPE).walk(ROBOT.after_touchdown(places[0]), 1)
    assert bent.outcome == "walking"
    assert abs(bent.states[0, :2].sum()) > 1e-6
    assert differentiate(plane_of(ROBOT, SLOPE, ScuffingRule()), places, np.full(3, 1e-4)) is None


def test_what_no_knees_have_is_refused(gait: mjbiped.KneedGait) -> None:
    with pytest.raises(InputError, match="scuffing is for straight legs"):
        ReturnMap(ROBOT, SLOPE, ScuffingRule(reach=0.3))
    with pytest.raises(InputError, match="scuffing is for straight legs"):
        basin_of_attraction(ROBOT, SLOPE, scuffing=ScuffingRule(reach=0.3))
    with pytest.raises(InputError, match=r"expected shape \(6,\)"):
        ReturnMap(ROBOT, SLOPE).walk([-0.2, 0.2, 1.0, 0.5], 1)
    with pytest.raises(InputError, match="the swing leg is straight"):
        ReturnMap(ROBOT, SLOPE).walk([-0.2, 0.2, 0.3, 1.0, 0.5, 0.5], 1)
    with pytest.raises(InputError, match=r"shape \(n, 6\)"):
        find_periodic_gait(ROBOT, SLOPE, gait.start[None, [0, 1, 3, 4]])
    with pytest.raises(InputError, match="scuffing is for straight legs"):
        bifurcation_diagram(ROBOT, [SLOPE], scuffing=ScuffingRule(reach=0.3))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "begins", "onsets"),
    [(ROBOT, 1.940, (5.683, 6.2126, 6.3152)), (mjbiped.KneedBiped.halved_rods(), 4.487, (6.152, 6.5143, 6.5858))],
)
def test_period_doubles_with_knees_too(robot: mjbiped.KneedBiped, begins: float, onsets: tuple[float, ...]) -> None:
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
