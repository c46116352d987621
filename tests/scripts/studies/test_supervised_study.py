"""The studies of laws for a bounded ankle: their wrong models, their rivals, and grounds that nobody else uses."""

from __future__ import annotations

import numpy as np
import pytest

import mjbiped
from controllers import BoundedAnkleController, SupervisedController
from mjbiped.analysis.replay import replayed
from mjbiped.controllers.room import RECOVERING
from scripts.studies import recovery_search, sole_limits_study, soles_study, supervised_study
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


@pytest.mark.slow
def test_the_search_begins_with_steps_that_can_be_made() -> None:
    begun, fixed = recovery_search.recovery_of(np.zeros(9)), SupervisedController.recovery
    assert [each.number for each in begun[:3]] == [each.number for each in fixed[:3]]
    level = [mjbiped.Terrain.level()]
    assert recovery_search.loss(begun, level) == pytest.approx(0.5 * 0.0347, rel=5e-3)  # half of the level cost


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
