"""Policies of many robots at once, by the law of `controllers.policy`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjbiped.controllers.policy import FEATURES, LATEST, action

Array = NDArray[np.float64]

WEIGHTS = (2, 2, len(FEATURES))
"""Shape of a policy: action (ankle, hip); constant part and part that goes with time; feature."""


def actions(
    weights: Array, angles: Array, rates: Array, time: Array, stance_after_touchdown: Array, slope: Array
) -> Array:
    """Torque of ankle and hip as parts of the greatest, shape (robots, 2); the task cuts off what is beyond 1.

    Args:
        weights: A policy for each robot, shape (robots, *`WEIGHTS`).
        angles: Stance and swing leg from the ground's normal under the stance foot, rad, shape (robots, 2).
        rates: Theirs, rad/s, shape (robots, 2).
        time: Since the touchdown, s, shape (robots,).
        stance_after_touchdown: Angle of the new stance leg just after it, rad; zero before the first; shape (robots,).
        slope: Of the ground since the start, rad, shape (robots,).
    """
    each = weights.reshape(len(weights), -1).T
    (q1, q2), (dq1, dq2) = angles.T, rates.T
    told = action(each, np.minimum(time, LATEST), q1, q2, dq1, dq2, stance_after_touchdown, slope)
    return np.stack(told, axis=1)
