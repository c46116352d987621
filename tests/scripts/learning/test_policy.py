"""The law of the policy, written out."""

from __future__ import annotations

import numpy as np
import pytest

from mjbiped.controllers.policy import FEATURES
from scripts.learning.policy import WEIGHTS, actions


@pytest.mark.parametrize("time", [0.0, 0.3, 0.765, 1.2, 3.0])
def test_gains_go_with_time_up_to_a_latest(time: float) -> None:
    random = np.random.default_rng(1)
    weights = random.normal(size=(3, *WEIGHTS))
    angles, rates = random.normal(size=(2, 3, 2))
    stance, slope = random.normal(size=(2, 3))
    told = actions(weights, angles, rates, np.full(3, time), stance, slope)
    phase = 2.0 * min(time / 0.765, 1.5) - 1.0
    for robot in range(3):
        features = [*angles[robot] / 0.2, *rates[robot], phase, stance[robot] / 0.2 + 1.0, slope[robot] / 0.035, 1.0]
        for joint in range(2):
            constant, with_time = weights[robot, joint]
            expected = sum((constant[k] + with_time[k] * phase) * features[k] for k in range(len(FEATURES)))
            # sums of 16 numbers of size one in another order
            assert told[robot, joint] == pytest.approx(expected, abs=1e-13)


def test_each_robot_has_its_own_policy() -> None:
    """A robot's action depends neither on the others nor on how many there are, to the last bit."""
    random = np.random.default_rng(2)
    weights = random.normal(size=(7, *WEIGHTS))
    felt = [random.normal(size=(7, 2)), random.normal(size=(7, 2)), random.uniform(size=7), *random.normal(size=(2, 7))]
    together = actions(weights, *felt)
    for robot in range(7):
        alone = actions(weights[robot : robot + 1], *(part[robot : robot + 1] for part in felt))
        np.testing.assert_array_equal(alone[0], together[robot])
