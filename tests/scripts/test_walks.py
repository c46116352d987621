"""The studies of laws for a bounded ankle: their wrong models, their rivals, and grounds that nobody else uses."""

import numpy as np
import pytest

import mjbiped
from controllers import PassiveController
from mjbiped import Terrain
from scripts.studies import recovery_search, scuffing_study, sole_limits_study, soles_study


def test_no_ground_of_the_tables_is_a_training_ground() -> None:
    tables = {made(phase) for _, made in soles_study.grounds() for phase in range(soles_study.PHASES)}
    assert not tables & {*recovery_search.training(), *recovery_search.others()}
    assert not set(recovery_search.training()) & set(recovery_search.others())
    assert recovery_search.training() == recovery_search.training()


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
