"""The studies of laws for a bounded ankle: their wrong models, their rivals, and grounds that nobody else uses."""

import numpy as np

import mjbiped
from controllers import PassiveController
from mjbiped import Terrain
from scripts.studies import recovery_search, scuffing_study, soles_study


def test_no_ground_of_the_tables_is_a_training_ground() -> None:
    tables = {made(phase) for _, made in soles_study.grounds() for phase in range(soles_study.PHASES)}
    assert not tables & {*recovery_search.training(), *recovery_search.others()}
    assert not set(recovery_search.training()) & set(recovery_search.others())
    assert recovery_search.training() == recovery_search.training()


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
