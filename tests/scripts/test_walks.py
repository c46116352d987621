"""The studies of laws for a bounded ankle: their wrong models, their rivals, and grounds that nobody else uses."""

from __future__ import annotations

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, BoundedAnkleController, KneedController, PassiveController
from mjbiped import Terrain
from mjbiped.analysis.replay import replayed
from mjbiped.controllers.room import RECOVERING
from scripts.studies import recovery_search, scuffing_study, sole_limits_study, soles_study, supervised_study
from scripts.studies.threshold_study import ThresholdController


def test_wrong_models_are_wrong_within_their_bounds() -> None:
    robot, chance = mjbiped.Compass(sole=(0.12, 0.12)), np.random.default_rng(0)
    models = [supervised_study.wrong(robot, chance) for _ in range(500)]
    masses = np.array([model.leg_mass / robot.leg_mass for model in models])
    lower = np.array([model.lower_length - robot.lower_length for model in models])
    inertias = np.array([model.leg_inertia / robot.leg_inertia for model in models]) / masses
    for values, middle, bound in ((masses, 1.0, 0.1), (inertias, 1.0, 0.2), (lower, 0.0, 0.02)):
        assert 0.95 * bound < np.abs(values - middle).max() <= bound * (1.0 + 1e-12)
    assert [model.leg_length for model in models] == pytest.approx([1.0] * 500, abs=1e-15)
    assert {model.sole for model in models} == {robot.sole}


def test_intervals_are_wilsons() -> None:
    assert supervised_study.share(8, 8) == "100.0 (67.6 to 100.0)"  # n / (n + z²): 8 / 11.84
    assert supervised_study.share(0, 200) == "0.0 (0.0 to 1.9)"


def test_no_ground_of_the_tables_is_a_training_ground() -> None:
    tables = {made(phase) for _, made in soles_study.grounds() for phase in range(soles_study.PHASES)}
    assert not tables & {*recovery_search.training(), *recovery_search.others()}
    assert not set(recovery_search.training()) & set(recovery_search.others())
    assert recovery_search.training() == recovery_search.training()


@pytest.mark.slow  # a law of the study's own is compiled
def test_thresholds_recover_always_or_never() -> None:
    robot = mjbiped.Compass(sole=(0.12, 0.12))
    gait = mjbiped.find_reference(robot, clearance=0.077, retraction=False)
    ground = mjbiped.Terrain.from_segments([(0.6, 0.0, 0.0), (50.0, 0.0, 0.02)])
    always, never = (ThresholdController(robot, gait, threshold=threshold) for threshold in (0.0, 1e6))
    walk = mjbiped.walk(always, ground, engine="hybrid", steps=6)
    assert all(memory[RECOVERING] for _, memory in replayed(walk, always))
    walks = [
        mjbiped.walk(law, ground, engine="hybrid", steps=6) for law in (never, BoundedAnkleController(robot, gait))
    ]
    assert (walks[0].samples["q"] == walks[1].samples["q"]).all()


@pytest.mark.slow  # it searches for three references
def test_limits_by_energy() -> None:
    """A heel that is 4 cm further behind works that much more over the same step, and on the same grade."""
    short, long = (sole_limits_study.estimates(sole_limits_study.law(sole)) for sole in (0.08, 0.12))
    gait = sole_limits_study.law(0.12).gait
    spread = abs(gait.start[0] - gait.start[1])
    assert long[0] - short[0] == pytest.approx(0.95 * 0.04 * spread, rel=1e-4)  # two references, each optimised
    assert long[1] - short[1] == pytest.approx(0.95 * 0.04, abs=1e-4)
    assert long[1] == pytest.approx(0.95 * 0.12 - 0.0347, abs=1e-4)
    assert sole_limits_study.estimates(sole_limits_study.law(0.005))[1] == 0.0


@pytest.mark.slow
def test_the_greatest_riser_is_the_last_before_a_fall() -> None:
    law = sole_limits_study.law(0.12)
    assert sole_limits_study.greatest(law, sole_limits_study.riser, [2, 30, 3]) == 2


@pytest.mark.slow
def test_decisions_are_those_of_the_walk() -> None:
    """Given what was known at each touchdown of a walk up one riser, machine code searches at the riser alone."""
    law = sole_limits_study.law(0.08)
    kept, searched = sole_limits_study.decisions(law, lambda phase: sole_limits_study.riser(1.3 + 0.01 * phase, 3))
    assert len(kept) + len(searched) == soles_study.PHASES * soles_study.STEPS
    assert soles_study.PHASES <= len(searched) <= 2 * soles_study.PHASES
    assert min(searched) > np.median(kept)


def test_straight_legs_scuff_as_their_gait_says() -> None:
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, np.deg2rad(2.0))
    time = np.linspace(0.0, gait.period, 5000)
    q = np.array([gait.reference(t)[0] for t in time])
    height = robot.leg_length * (np.cos(q[:, 0]) - np.cos(q[:, 1]))
    inside = time[height < -scuffing_study.TOUCHED] / gait.period

    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), engine="hybrid", steps=3, sample_period=1e-3)
    passed = scuffing_study.passed_through(walk)
    # 1 ms beside the deepest point, 0.9 mm that curve by some 0.4 m/s²; the height over the slope's normal is
    # 6e-4 less than that over the profile
    np.testing.assert_allclose(passed.depth, -height.min(), rtol=0, atol=2e-6)
    np.testing.assert_allclose(passed.part, (inside[0], inside[-1]), rtol=0, atol=2e-3)  # 1 ms of 0.76 s
    assert scuffing_study.passes([walk]) == "100 %, 0 %; 0.09"


@pytest.mark.slow
def test_straight_legs_pass_through_risers_and_knees_do_not() -> None:
    stairs = [Terrain.stairs(rise=0.02, first=first) for first in (1.5, 1.6, 1.7, 1.8)]
    compass, kneed = mjbiped.Compass(), mjbiped.KneedBiped()
    straight = AdaptiveController(compass, mjbiped.find_passive_gait(compass, np.deg2rad(2.0)))
    knees = KneedController(kneed, mjbiped.find_kneed_gait(kneed, np.deg2rad(2.5)))
    of_straight, of_knees = (
        [
            scuffing_study.passed_through(mjbiped.walk(law, ground, engine="hybrid", steps=12, sample_period=2e-3))
            for ground in stairs
        ]
        for law in (straight, knees)
    )
    assert all(np.all(passed.depth > scuffing_study.TOUCHED) for passed in of_straight)
    deepest = max(passed.depth.max() for passed in of_straight)
    assert 0.01 < deepest < 0.021  # the riser, and less than 1 mm that straight legs scuff
    assert all(np.all(passed.depth == 0.0) and np.isnan(passed.part).all() for passed in of_knees)


def test_a_foot_that_stands_before_a_riser_is_not_in_it() -> None:
    robot = mjbiped.KneedBiped()
    law = KneedController(robot, mjbiped.find_kneed_gait(robot, np.deg2rad(2.5)))
    walk = mjbiped.walk(law, Terrain.stairs(rise=0.04, first=1.5), steps=6, sample_period=1e-3)
    x, z = walk.robot.limbs(walk.samples["qpos"])[..., -1, :].T
    assert np.max(walk.terrain.height(x) - z) > 5e-3  # the toe pushes against the face, some micrometres inside
    assert scuffing_study.passed_through(walk).depth.max() < scuffing_study.TOUCHED


def test_each_ground_changes_later_with_each_phase() -> None:
    for name, ground in soles_study.grounds():
        first = [ground(phase).x[1:2] for phase in range(soles_study.PHASES)]
        assert name == "level" or name.startswith("treads") or len(set(first)) == soles_study.PHASES
    mixed = dict(soles_study.grounds())["mixed"](0)
    assert mixed.rises == pytest.approx(Terrain.mixed().rises, abs=1e-12)  # sums of a dozen heights of centimetres
