"""Theorem 1 along recorded walks: the record against (15)-(26), in the hybrid engine to its accuracy."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.analysis.error_dynamics import impact_gain, impact_matrix
from mjbiped.analysis.stability import Stability, recorded_controller, stability

# error of a step's end in the hybrid engine: some 20 integration steps of tolerance 1e-10 (1 + |y|), and the dense
# output between them
INTEGRATION = 1e-8


def walked(controller: AdaptiveController, terrain: mjbiped.Terrain, **arguments: object) -> mjbiped.Walk:
    given = {"engine": "hybrid", "steps": 6, "sample_period": 2e-3, **arguments}
    return mjbiped.walk(controller, terrain, **given)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def wrong(controller: AdaptiveController) -> AdaptiveController:
    """Starts with an estimate 3 degrees wrong, is never re-planned, never updated: all that (22) has in it moves."""
    return replace(controller, initial_slope_estimate=math.radians(3), replanning_delay=None, estimate_update=False)


@pytest.fixture(scope="module")
def uneven() -> mjbiped.Terrain:
    return mjbiped.Terrain.from_segments([(1.0, 0.0, 0.0), (10.0, 1.0, 0.0)])


@pytest.fixture(scope="module")
def walk(wrong: AdaptiveController, uneven: mjbiped.Terrain) -> mjbiped.Walk:
    return walked(wrong, uneven)


@pytest.fixture(scope="module")
def found(walk: mjbiped.Walk) -> Stability:
    return stability(walk)


@pytest.mark.slow
def test_recorded_errors_obey_22(found: Stability) -> None:
    """The transition matrix, made of the angles alone, carries the errors from a step's start to its end."""
    assert found.residual.max() < INTEGRATION
    assert np.linalg.norm(found.start[0]) > 0.05  # there was something to carry
    assert (np.linalg.norm(found.start - found.end, axis=1) > 1e5 * found.residual).all()


def test_16_and_17(found: Stability, wrong: AdaptiveController, uneven: mjbiped.Terrain) -> None:
    """The Lyapunov function falls as they say."""
    weight = 1 / wrong.adaptation_gain
    assert np.abs(found.balance).max() < INTEGRATION * weight
    z1, z2, theta = found.errors[:, 0:2], found.errors[:, 2:4], found.errors[:, 4:6]
    expected = 0.5 * (z1**2).sum(1) + 0.5 * (z2**2).sum(1) + 0.5 * weight * (theta**2).sum(1)
    np.testing.assert_allclose(found.lyapunov, expected, rtol=1e-13)
    within = np.diff(found.step) == 0
    assert np.diff(found.lyapunov)[within].max() < 0.0
    # what is left at coarse samples is the quadrature's, of fourth order; the finest is free of it
    coarse, fine = (
        np.abs(stability(walked(wrong, uneven, steps=2, sample_period=period)).balance).max() for period in (0.02, 0.01)
    )
    assert 3.0 < math.log2(coarse / fine) < 6.0


def test_estimates_at_the_ends_are_the_recorded_ones(found: Stability, walk: mjbiped.Walk) -> None:
    slope = np.append(0.0, walk.touchdowns["slope"])
    before, after = walk.touchdowns["slope_estimate_before"], walk.touchdowns["slope_estimate"]
    np.testing.assert_allclose(np.sin(slope[:-1]) - found.end[:, 4], np.sin(before), rtol=0, atol=INTEGRATION)
    np.testing.assert_allclose(np.sin(slope[1:-1]) - found.start[1:, 4], np.sin(after[:-1]), rtol=0, atol=INTEGRATION)


def test_touchdowns_against_the_equations(found: Stability, walk: mjbiped.Walk) -> None:
    """(19)-(21) from the record's rows, and the jump of V_a."""
    z1 = np.linalg.norm(found.end[:-1, 0:2], axis=1)
    rates = [np.linalg.norm(eta[:, 2:4] - 5 * eta[:, 0:2], axis=1) for eta in (found.end[:-1], found.start[1:])]
    bound = found.alpha[1:] * z1 + found.beta[1:] * rates[0]
    assert (rates[1] <= bound * (1 + 1e-12)).all()
    sharp = found.alpha[1:] > 0
    np.testing.assert_allclose(rates[1][sharp], bound[sharp], rtol=1e-12)
    for step, q in enumerate(walk.touchdowns["q_before"][:-1], start=1):
        assert found.beta[step] == pytest.approx(np.linalg.norm(impact_matrix(found.controller.robot.constants, q), 2))
        assert found.impact_gain[step] == impact_gain(5.0, found.alpha[step], found.beta[step])
    assert np.isnan([found.alpha[0], found.beta[0], found.impact_gain[0], found.ratio[0], found.lyapunov_jump[0]]).all()
    first_of = np.flatnonzero(np.diff(found.step)) + 1
    np.testing.assert_allclose(found.lyapunov_jump[1:], found.lyapunov[first_of] - found.lyapunov[first_of - 1])
    assert np.flatnonzero(found.slope_change).tolist() == [int(np.argmax(found.lyapunov_jump[1:])) + 1]
    assert found.slope_change.sum() == pytest.approx(math.radians(1))


def test_ratios_and_bounds_are_those_of_21_to_26(found: Stability) -> None:
    before, after = (np.linalg.norm(eta, axis=1) for eta in (found.end, found.start))
    np.testing.assert_allclose(found.ratio[1:], before[1:] / before[:-1])
    np.testing.assert_allclose(found.impact_ratio[1:], after[1:] / before[:-1])
    contraction = np.linalg.norm(found.transition, 2, axis=(1, 2))
    np.testing.assert_allclose(found.condition[1:], found.impact_gain[1:] * contraction[1:])
    np.testing.assert_allclose(found.condition_floor, math.sqrt(51.0) * contraction)
    of_estimates = [np.linalg.norm(found.errors[found.step == step, 4:6], axis=1) for step in range(found.steps)]
    np.testing.assert_allclose(found.estimate_rise, [norms.max() - norms[0] for norms in of_estimates], atol=1e-15)
    assert found.estimate_rise.max() > 1e-3


def test_exact_estimate_stays_exact(controller: AdaptiveController, uneven: mjbiped.Terrain) -> None:
    """With (27) and re-planning another slope leaves V_a at zero; without (27) its change goes into V_a."""
    found = stability(walked(controller, uneven))
    assert found.lyapunov.max() < INTEGRATION
    blind = stability(walked(replace(controller, estimate_update=False), uneven))
    change = np.array([math.sin(math.radians(1)), math.cos(math.radians(1)) - 1])
    there = int(np.flatnonzero(blind.slope_change)[0])
    assert blind.lyapunov_jump[there] == pytest.approx((change**2).sum() / 0.6, rel=1e-6)


def test_excitation_and_its_directions(found: Stability) -> None:
    assert (found.excitation[:, 0] > 50.0).all()
    assert (found.excitation[:, 1] / found.excitation[:, 0] < 2.2).all()
    assert (found.weak_direction < math.radians(5)).all()  # the cosine's


def test_mujoco_walk_obeys_22_up_to_its_contacts(wrong: AdaptiveController, uneven: mjbiped.Terrain) -> None:
    """What is left at any timestep is of the contact step and of the foot's rolling."""
    for timestep in (2e-3, 4e-4):
        engine = mjbiped.Mujoco(timestep=timestep)
        residual = stability(walked(wrong, uneven, engine=engine, steps=3, sample_period=4e-3)).residual
        # measured 1.7e-4 and 1.8e-4; with rates half a step old it was of first order in the step, 1.3e-2 and 2.3e-3
        assert np.median(residual) < 3e-4


def test_record_suffices(walk: mjbiped.Walk, wrong: AdaptiveController, found: Stability, tmp_path: Path) -> None:
    assert recorded_controller(walk) == wrong
    walk.save(tmp_path / "walk.npz")
    again = stability(mjbiped.Walk.load(tmp_path / "walk.npz"))
    assert np.array_equal(again.errors, found.errors)
    assert np.array_equal(again.transition, found.transition)


def test_refusals(controller: AdaptiveController, walk: mjbiped.Walk) -> None:
    downhill = mjbiped.Terrain.incline(2.0)
    passive = replace(walk, settings={**walk.settings, "controller": PassiveController().describe()})
    short = walked(controller, downhill, steps=1, sample_period=0.2)
    none = replace(walk, touchdowns={name: column[:0] for name, column in walk.touchdowns.items()})
    for wrong, words in (
        ([passive], "this walk's is PassiveController"),
        ([passive, PassiveController()], r"controller must be a .*AdaptiveTracking, got PassiveController"),
        ([short], r"step 1 of 0\.764 s has only 3 samples"),
        ([none], "no touchdown"),
    ):
        with pytest.raises(mjbiped.InputError, match=words):
            stability(*wrong)
